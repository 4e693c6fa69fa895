"""Lines, constants, the worst function and circles of imports are counted as the page says."""

import ast

import pytest

from benchmarks.code.circles import circles
from benchmarks.code.constants import constants
from benchmarks.code.measure import SUM, measure, size


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("LIMIT = 3.0", 1),
        ("LOWEST: float = -3", 1),
        ("_PRIVATE = 1e-3", 1),
        ("BOTH = (1.0, 2.0)", 2),
        ("A, B = 1.0, 2.0", 2),
        ("SHARE = 2.0 * np.pi / 3.0", 1),
        ("OF_ANOTHER = 2.0 * LIMIT", 1),
        ("SAME = LIMIT", 0),
        ("TABLE = {1: 0.5, 'a': (1.0, 2.0)}", 3),
        ("ARRAY = np.array([1.0, 2.0, -3.0])", 3),
        ("PART = TABLE[0]", 0),
        ("SWITCH = True", 0),
        ("NAME = 'three'", 0),
        ("lower = 3.0", 0),
        ("def f():\n    LOCAL = 3.0", 0),
        ("TABLE[0] = 3.0", 0),
    ],
)
def test_numbers_in_names_of_capitals_count_one_by_one(text, count):
    assert constants(ast.parse(text)) == count


def parsed(**texts):
    return {f"p.{name}": ast.parse(text) for name, text in texts.items()}


def test_modules_that_import_one_another_are_a_circle():
    trees = parsed(a="from p import b", b="from p.c import x", c="import p.a", d="import p.a")
    assert circles(trees, deferred=False) == [["p.a", "p.b", "p.c"]]


@pytest.mark.parametrize(
    "text",
    [
        "def f():\n    from p import a",
        "if TYPE_CHECKING:\n    from p.a import x",
        "class C:\n    def f(self):\n        import p.a",
    ],
)
def test_an_import_in_a_function_or_for_types_is_deferred(text):
    trees = parsed(a="import p.b", b=text)
    assert circles(trees, deferred=False) == []
    assert circles(trees, deferred=True) == [["p.a", "p.b"]]


def test_a_name_of_a_package_is_the_package_and_a_module_of_it_the_module():
    trees = {"p": ast.parse("from p.a import x"), **parsed(a="from p import b", b="")}
    assert circles(trees, deferred=True) == []
    assert circles({**trees, "p.b": ast.parse("from p import NAME")}, deferred=True) == [
        ["p", "p.a", "p.b"]
    ]


def test_the_worst_function_is_named_a_method_too():
    branches = "\n".join(f"        if x == {n}: return {n}" for n in range(4))
    found = size({"p.a": "def f(x):\n    return x", "p.b": f"class C:\n    def g(x):\n{branches}"})
    assert (found.worst, found.complexity) == ("p.b.C.g", 5)
    assert (found.modules, found.lines) == (2, 8)


def test_packages_are_counted_one_by_one_and_in_all(tmp_path):
    for package in ("one", "two"):
        (tmp_path / "p" / package).mkdir(parents=True)
        (tmp_path / "p" / package / "__init__.py").write_text("")
        (tmp_path / "p" / package / "m.py").write_text("A = 1\n\n\ndef f():\n    return A\n")
    found = measure(tmp_path, ("p/one", "p/two"))
    assert list(found) == ["p/one", "p/two", SUM]
    assert [each.lines for each in found.values()] == [5, 5, 10]
    assert [each.constants for each in found.values()] == [1, 1, 2]
