"""Circles of imports: modules of which each needs, by some way, each of the others.

Contents: which module imports which, and the circles.

An import in a function, or for types only, is deferred: it lets modules of a circle be loaded, and
the circle stays.
"""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


def circles(trees: Mapping[str, ast.Module], deferred: bool) -> list[list[str]]:
    """Return the circles among modules, the largest first; each is a list of their names.

    Parameters
    ----------
    trees : mapping of str to ast.Module
        The modules by their full names.
    deferred : bool
        Whether deferred imports count, too.
    """
    places = {name: place for place, name in enumerate(trees)}
    pairs = [
        (places[name], places[other])
        for name, tree in trees.items()
        for other in imported(tree, places, deferred)
        if other != name
    ]
    if not pairs:
        return []
    rows, columns = np.transpose(pairs)
    arrows = coo_array((np.ones(len(pairs)), (rows, columns)), shape=(len(trees), len(trees)))
    _, labels = connected_components(arrows, directed=True, connection="strong")
    groups = defaultdict(list)
    for name, label in zip(trees, labels, strict=True):
        groups[label].append(name)
    found = (sorted(group) for group in groups.values() if len(group) > 1)
    return sorted(found, key=lambda group: (-len(group), group))


def imported(tree: ast.Module, known: Collection[str], deferred: bool) -> Iterator[str]:
    """Yield the known modules that a module imports; a name that is no module is its package's."""
    for node in _imports(tree, deferred):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            names = [
                inner if (inner := f"{node.module}.{alias.name}") in known else node.module
                for alias in node.names
            ]
        yield from (name for name in names if name in known)


def _imports(node: ast.AST, deferred: bool) -> Iterator[ast.Import | ast.ImportFrom]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, (ast.Import, ast.ImportFrom)):
            yield child
        elif deferred or not _defers(child):
            yield from _imports(child, deferred)


def _defers(node: ast.AST) -> bool:
    if isinstance(node, ast.If):
        return ast.unparse(node.test).endswith("TYPE_CHECKING")
    return isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda))
