"""How often "what", "whatever" and "whoever" stand for a noun: at most twice in 1000 words.

Each makes a reader search for the noun (``docs/terms.md``). True questions are left out.
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
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
VAGUE = re.compile(r"\b(?:what|whatever|whoever)\b", re.IGNORECASE)
WORD = re.compile(r"[A-Za-z]+(?:['’-][A-Za-z]+)*")
QUESTION = re.compile(r"[^.!?:;|]*\?")
#: Of each kind of text, how many of 1000 words may hide a noun.
MOST = {"docstrings and comments": 2.0, "docs and README": 2.0, "messages": 2.0}


def per_thousand(texts: Iterator[str]) -> float:
    """Return how many of 1000 words are vague."""
    text = "\n\n".join(QUESTION.sub("", each) for each in texts)
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


@pytest.mark.parametrize("kind", MOST)
def test_nouns_are_named(kind):
    share = per_thousand(texts(kind))
    assert share <= MOST[kind], (
        f"{kind}: {share:.2f} of 1000 words are what, whatever or whoever, and {MOST[kind]:g} "
        "are allowed: name the noun (docs/terms.md)"
    )


@pytest.mark.parametrize(
    ("text", "share"),
    [
        ("It says what it is.", 200.0),
        ("What is it? It is a mass.", 0.0),
        ("Whoever reads it, somewhat slowly.", 200.0),
    ],
)
def test_questions_do_not_count(text, share):
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
