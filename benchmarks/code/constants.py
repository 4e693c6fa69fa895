"""How many numbers a module assigns to constants.

Contents: which numbers count.

A number that decides, such as a threshold, stands in a name of capitals at the level of the module.
Each has to be justified, so each counts: those of a tuple, of a dictionary's values and of a call's
arguments one by one; arithmetic is one, with whatever names.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

CAPITALS = re.compile(r"_*[A-Z][A-Z0-9_]*\Z")
_SEVERAL = (ast.Tuple, ast.List, ast.Set, ast.Dict, ast.ListComp, ast.DictComp, ast.GeneratorExp)


def constants(tree: ast.Module) -> int:
    """Return how many numbers are assigned to names of capitals at the level of a module."""
    return sum(_numbers(value) for value in _assigned(tree))


def _assigned(tree: ast.Module) -> Iterator[ast.expr]:
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        names = [name.id for each in targets if each for name in _names(each)]
        value = getattr(node, "value", None)
        if value is not None and names and all(map(CAPITALS.match, names)):
            yield value


def _names(target: ast.expr) -> list[ast.Name]:
    """Return what an assignment binds; of ``table[key]`` or ``thing.part`` nothing."""
    if isinstance(target, ast.Tuple):
        return [name for each in target.elts for name in _names(each)]
    return [target] if isinstance(target, ast.Name) else []


def _numbers(node: ast.AST) -> int:
    if isinstance(node, ast.Constant):
        return int(type(node.value) in (int, float, complex))
    if isinstance(node, ast.Dict):
        return sum(map(_numbers, node.values))
    if isinstance(node, ast.Subscript):
        return _numbers(node.value)  # a place is no constant
    found = sum(map(_numbers, ast.iter_child_nodes(node)))
    return min(found, 1) if _is_one(node) else found


def _is_one(node: ast.AST) -> bool:
    """Whether an expression is arithmetic of single numbers."""
    arithmetic = isinstance(node, (ast.BinOp, ast.UnaryOp))
    return arithmetic and not any(isinstance(each, _SEVERAL) for each in ast.walk(node))
