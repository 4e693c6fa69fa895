"""Size of packages: lines, constants, the worst function, circles of imports.

Contents: the counts of a package, and the table.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from rich.table import Table

from benchmarks.code.circles import circles
from benchmarks.code.constants import constants

ROOT = Path(__file__).parents[2]
PACKAGES = ("tissue_probe/diagnosis", "tissue_probe/physics", "tissue_probe/analysis")
SUM = "in all"


@dataclass(frozen=True)
class Size:
    """Counts of one package, or of several together.

    Attributes
    ----------
    modules, lines, constants : int
        Files, their lines, and numbers in constants.
    worst : str
        The function of the largest cyclomatic complexity (T. McCabe, IEEE Transactions on Software
        Engineering SE-2 (1976), 308), as radon counts it.
    complexity : int
        Of that function.
    circles, deferred_circles : list of list of str
        Modules in circles of imports; by module-level imports alone, and by all.
    """

    modules: int
    lines: int
    constants: int
    worst: str
    complexity: int
    circles: list[list[str]]
    deferred_circles: list[list[str]]


def measure(root: Path = ROOT, packages: tuple[str, ...] = PACKAGES) -> dict[str, Size]:
    """Return the size of each package, and of all together."""
    sources = {package: _sources(root, package) for package in packages}
    every = {name: text for texts in sources.values() for name, text in texts.items()}
    return {name: size(texts) for name, texts in {**sources, SUM: every}.items()}


def size(sources: Mapping[str, str]) -> Size:
    """Return the counts of modules, whose texts are given by their full names."""
    trees = {name: ast.parse(text) for name, text in sources.items()}
    complexity, worst = max(_complexities(sources), default=(0, ""))
    return Size(
        modules=len(trees),
        lines=sum(len(text.splitlines()) for text in sources.values()),
        constants=sum(map(constants, trees.values())),
        worst=worst,
        complexity=complexity,
        circles=circles(trees, deferred=False),
        deferred_circles=circles(trees, deferred=True),
    )


def table(sizes: Mapping[str, Size]) -> Table:
    """Return the counts, a row a package."""
    made = Table("package", title="Code", title_justify="left", caption_justify="left")
    for column in ("modules", "lines", "constants", "circles", "with deferred imports"):
        made.add_column(column, justify="right")
    made.add_column("worst function", overflow="fold")
    for name, each in sizes.items():
        if name == SUM:
            made.add_section()
        counts = (each.modules, each.lines, each.constants)
        rings = (_told(each.circles), _told(each.deferred_circles))
        made.add_row(name, *map(str, counts), *rings, f"{each.worst}: {each.complexity}")
    made.caption = "circles of imports, and in brackets how many modules each has"
    return made


def _told(found: list[list[str]]) -> str:
    sizes = ", ".join(str(len(each)) for each in found)
    return f"{len(found)} ({sizes})" if found else "0"


def _sources(root: Path, package: str) -> dict[str, str]:
    paths = sorted((root / package).rglob("*.py"))
    return {_module(path.relative_to(root)): path.read_text(encoding="utf-8") for path in paths}


def _module(path: Path) -> str:
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _complexities(sources: Mapping[str, str]) -> Iterator[tuple[int, str]]:
    from radon.visitors import ComplexityVisitor

    for name, text in sources.items():
        found = ComplexityVisitor.from_code(text)
        methods = (method for each in found.classes for method in each.methods)
        for each in (*found.functions, *methods):
            yield each.complexity, f"{name}.{each.fullname}"
