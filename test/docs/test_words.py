"""How often "what", "whatever" and "whoever" stand for a noun: the share of them may only fall.

Each makes a reader search for the noun (``docs/terms.md``). True questions are left out, and the
two questions with which each module opens.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = sorted((ROOT / "tissue_probe").rglob("*.py"))
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
VAGUE = re.compile(r"\b(?:what|whatever|whoever)\b", re.IGNORECASE)
WORD = re.compile(r"[A-Za-z]+(?:['’-][A-Za-z]+)*")
QUESTION = re.compile(r"[^.!?:;|]*\?")
OPENING = re.compile(r"What\s+belongs\s+here:|What\s+does\s+not:")
#: Of each kind of text, how many of 1000 words: no more than this, and not less by more than 2 %.
#: Who lowers a share writes the new one here.
WRITTEN = {"docstrings and comments": 12.3, "docs and README": 5.87, "messages": 3.03}
FALLEN = 0.02


def per_thousand(texts: Iterator[str]) -> float:
    """Return how many of 1000 words are vague."""
    text = "\n\n".join(QUESTION.sub("", OPENING.sub("", each)) for each in texts)
    return 1000.0 * len(VAGUE.findall(text)) / len(WORD.findall(text))


def docstrings(tree: ast.Module) -> Iterator[ast.Constant]:
    """Yield the docstrings of a module, and strings that stand alone below a name."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            yield node.value


def comments(source: str) -> Iterator[str]:
    """Yield the comments of a module, neighbouring lines as one text."""
    lines = [
        token.string.lstrip("#: ") if token.type == tokenize.COMMENT else "\n"
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type != tokenize.NL
    ]
    yield " ".join(lines)


def messages(tree: ast.Module) -> Iterator[str]:
    """Yield the strings that have a space in them and are no docstrings."""
    apart = {id(node) for node in docstrings(tree)}
    for node in ast.walk(tree):
        text = node.value if isinstance(node, ast.Constant) and id(node) not in apart else None
        if isinstance(text, str) and " " in text:
            yield text


def texts(kind: str) -> Iterator[str]:
    """Yield the texts of a kind."""
    if kind == "docs and README":
        yield from (path.read_text(encoding="utf-8") for path in DOCUMENTS)
        return
    for path in SOURCES:
        source = path.read_text(encoding="utf-8")
        tree = ast.parse(source)
        if kind == "messages":
            yield from messages(tree)
        else:
            yield from (str(node.value) for node in docstrings(tree))
            yield from comments(source)


@pytest.mark.parametrize("kind", WRITTEN)
def test_the_share_of_words_that_hide_a_noun_only_falls(kind):
    share, written = per_thousand(texts(kind)), WRITTEN[kind]
    assert share <= written, (
        f"{kind}: {share:.3f} of 1000 words are what, whatever or whoever, and {written} are "
        "allowed: name the noun (docs/terms.md)"
    )
    assert share >= (1.0 - FALLEN) * written, (
        f"{kind}: {share:.3f} of 1000 words are what, whatever or whoever, fewer than {written}: "
        f"write the new value down in {Path(__file__).name}"
    )


@pytest.mark.parametrize(
    ("text", "share"),
    [
        ("It says what it is.", 200.0),
        ("What is it? It is a mass.", 0.0),
        ("What belongs here: a list. What does not: whatever else.", 250.0),
        ("Whoever reads it, somewhat slowly.", 200.0),
    ],
)
def test_questions_and_the_opening_of_modules_do_not_count(text, share):
    assert per_thousand(iter([text])) == pytest.approx(share)


def test_texts_of_a_module_are_of_one_kind_each():
    source = (
        '"""A doc what."""\nA = "no_space"\n#: A comment.\nB = f"a {A} message"  # and\n# more\n'
    )
    tree = ast.parse(source)
    assert [node.value for node in docstrings(tree)] == ["A doc what."]
    assert list(messages(tree)) == ["a ", " message"]
    assert "A comment." in next(comments(source))
    assert WORD.findall(next(comments(source)))[-2:] == ["and", "more"]
