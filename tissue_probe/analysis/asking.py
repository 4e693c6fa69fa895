"""Keywords of a question in Python: their signature and their documentation.

Contents: showing the declared items (``question_items``) where a function takes them.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from textwrap import fill, indent
from typing import Any, TypeVar

from tissue_probe.analysis.question import Asked
from tissue_probe.analysis.question_items import ITEMS, Item

#: Where the keywords stand in the documentation of a function.
KEYWORDS_MARK = "**asked\n    See ``Asked``."

#: Python's form of values that stand as rows of names and values on the command line.
_MAPPED = {
    "constants": 'In Python a mapping: ``{"tip_mass": (0.04, 0.001), "stiffness": 0.0}``.',
    "odds": 'In Python a mapping: ``{"relaxation": 10.0}``.',
}

_F = TypeVar("_F", bound=Callable[..., Any])


def asks(function: _F) -> _F:
    """Show the keywords that a function takes as ``Asked``, with their defaults and sentences.

    In its documentation they stand where it names ``**asked``.
    """
    signature = inspect.signature(function)
    own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
    written = Asked.__annotations__
    keywords = [
        inspect.Parameter(
            each.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=each.default,
            annotation=written[each.name].__forward_arg__,
        )
        for each in ITEMS
    ]
    function.__signature__ = signature.replace(parameters=[*own, *keywords])  # type: ignore[attr-defined]
    told = "\n".join(f"{each.name}\n{indent(fill(_in_python(each), 92), '    ')}" for each in ITEMS)
    # Where Python leaves out documentation, there is none.
    function.__doc__ = (inspect.getdoc(function) or "").replace(KEYWORDS_MARK, told)
    return function


def _in_python(item: Item) -> str:
    return f"{item.about} {_MAPPED.get(item.kind, '')}".strip()
