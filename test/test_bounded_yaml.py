"""YAML from anywhere: plain values, whatever it holds, within bounds of size, depth and aliases."""

from __future__ import annotations

import itertools
import subprocess
import sys

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.bounded_yaml import DEEPEST_YAML, LONGEST_YAML, YamlError, parse, read

plain = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**63) | st.floats(allow_nan=False)
    | st.text(st.characters(codec="utf-8"), max_size=20) | st.dates(),
    lambda inner: st.lists(inner, max_size=4)
    | st.dictionaries(st.text(st.characters(codec="utf-8"), max_size=8), inner, max_size=4),
    max_leaves=12,
)  # fmt: skip


@given(plain)
@settings(deadline=None)
def test_what_pyyaml_writes_is_read_as_it_was(value):
    assert parse(yaml.safe_dump(value)) == value


YAMLISH = st.text("[]{}:,-?&*!|>'\"%@ab1.\n \t#<=~", max_size=60).map(str.encode)


@given(st.binary(max_size=200) | YAMLISH)
@settings(deadline=None, max_examples=300)
def test_any_bytes_are_read_or_refused_in_one_sentence(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_bytes(content)
    told = "is read"
    try:
        read(path)
    except YamlError as error:
        told = str(error)
    assert told.startswith(("is ", "has ", "holds "))
    assert "\n" not in told


def laughs(levels: int) -> str:
    """Nine times nine times ...: a text that grows ninefold with each line."""
    lines = ["a: &a [x, x, x, x, x, x, x, x, x]"]
    for before, name in zip("abcdefgh", "bcdefghi"[: levels - 1], strict=False):
        lines.append(f"{name}: &{name} [{', '.join(9 * ['*' + before])}]")
    return "\n".join(lines)


def merges() -> str:
    """Each mapping takes the one before twice: twice as many keys with each line, all alike."""
    names = "abcdefghijklmnopqrstuvwxyz"
    lines = [f"{n}: &{n} {{<<: [*{b}, *{b}]}}" for b, n in itertools.pairwise(names)]
    return "\n".join(["a: &a {x: 1}", *lines])


BEYOND = {
    "aliases of lists": (laughs(9), "characters with its aliases written out"),
    "aliases of a long text": (
        f"a: &a {LONGEST_YAML // 8 * 'x'}\nb: {8 * '[*a, '}{8 * ']'}", "aliases"
    ),
    "merged mappings": (merges(), "characters with its aliases written out"),
    "a list that holds itself": ("a: &a [1, *a]", r"holds itself: \*a \(line 1\)"),
    "a flow nested deeply": (
        (DEEPEST_YAML + 1) * "[" + (DEEPEST_YAML + 1) * "]",
        "nested more than",
    ),
    "a hundred thousand brackets": (100_000 * "[", "is not YAML"),
    "a block nested deeply": (
        "\n".join(n * " " + "a:" for n in range(DEEPEST_YAML + 1)), "levels deep .line 51"
    ),
    "too many characters": ((LONGEST_YAML + 1) * " ", f"more than {LONGEST_YAML} characters"),
    "a number without end": (":".join(100 * ["1"]), "more than 100 digits"),
    "a hexadecimal number without end": ("a: 0x" + 2000 * "f", "more than 100 digits"),
    "a key twice": ("a: 1\nb:\n  c: 2\n  c: 3", r"the key 'c' twice \(line 4\): leave one out"),
    "no day": ("date: 2026-13-45", "month must be in 1..12"),
    "no such tag": ("!!python/object/apply:os.system [ls]", "line 1: could not determine"),
    "a wrong tag": ("!!bool maybe", "not of the type in its tag"),
}  # fmt: skip


@pytest.mark.parametrize("what", BEYOND)
def test_what_is_beyond_a_bound_is_refused_in_one_sentence(what):
    text, told = BEYOND[what]
    with pytest.raises(YamlError, match=told) as failure:
        parse(text)
    assert "\n" not in str(failure.value)
    assert len(str(failure.value)) < 200


def test_aliases_within_the_bound_and_merged_keys_are_read():
    text = "a: &a {x: 1, y: 2}\nb: {<<: *a, y: 3}\nc: [*a, *a]"
    assert parse(text) == {"a": (a := {"x": 1, "y": 2}), "b": {"x": 1, "y": 3}, "c": [a, a]}


def test_one_name_at_several_places_is_no_key_twice():
    assert parse("a: {c: 1}\nb: {c: a, d: a}\ne: [c, c]\n1: x\n'1': y")["b"] == {"c": "a", "d": "a"}


MEASURED = """
import resource, sys
from tissue_probe.bounded_yaml import YamlError, read
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    repr(read(sys.argv[1]))
except YamlError:
    pass
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


LARGE = {
    "aliases": laughs(7),
    "merges": merges(),
    "lists": "[" + (LONGEST_YAML // 3 - 1) * "[]," + "]",
    "text": f"a: {LONGEST_YAML * 'x'}",
    "longer than the bound": 9 * LONGEST_YAML * "x",
}


@pytest.mark.parametrize("name", LARGE)
def test_no_document_takes_more_than_a_hundred_megabytes(tmp_path, name):
    (tmp_path / "large.yaml").write_text(LARGE[name])
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, tmp_path / "large.yaml"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert int(done.stdout) < 100_000  # kB


def test_a_file_that_never_ends_is_refused():
    with pytest.raises(YamlError, match="has more than"):
        read("/dev/zero")
