"""The question, as a page states it: the items of ``analysis.asked``, but for files."""

from __future__ import annotations

from dataclasses import field, make_dataclass, replace
from typing import Any

from tissue_probe.analysis.asked import ITEMS_BY_NAME, Item
from tissue_probe.workbench import stated
from tissue_probe.workbench.declared import shorten_value
from tissue_probe.workbench.refused import RequestRefused

#: Values supposed where a page states nothing; of others' recordings the rig is asked for.
SUPPOSED: dict[str, Any] = {"tissue": "kelvin_voigt"}
#: The items that a page may state: no file of its machine.
PAGE_ITEMS = tuple(each for each in ITEMS_BY_NAME.values() if each.kind not in ("file", "files"))


def checked_question(given: dict[str, Any]) -> dict[str, Any]:
    """Return a page's statements on the model, as ``tissue_probe.compare`` takes them.

    Raises
    ------
    Refused
        If something is no parameter, or has no such value.
    """
    return {name: _check_statement(name, value) for name, value in given.items()}


def _apply_changes(asked: Any, given: dict[str, Any]) -> Any:
    """Return it with a page's statements, checked."""
    return replace(asked, **checked_question(given))


def _parameters(asked: Any) -> dict[str, Any]:
    """Return it as ``compare`` and ``diagnose`` take it."""
    return {each.name: getattr(asked, each.name) for each in PAGE_ITEMS}


def _of_samples(asked: Any) -> dict[str, Any]:
    """Return the part that is of the samples, and not of the model."""
    return {name: getattr(asked, name) for name in ("starts", "site", "lowpass", "course")}


def _field(item: Item) -> tuple[str, Any, Any]:
    if item.kind in ("constants", "odds"):
        return item.name, dict[str, Any], field(default_factory=dict)
    return item.name, Any, field(default=SUPPOSED.get(item.name, item.default))


#: Parameters of ``tissue_probe.compare``; None where the user states nothing. ``constants`` holds
#: (value, standard deviation) by name.
Asked = make_dataclass(
    "Asked",
    map(_field, PAGE_ITEMS),
    namespace={"changed": _apply_changes, "parameters": _parameters, "of_samples": _of_samples},
    frozen=True,
)


def _check_statement(name: str, value: Any) -> Any:
    item = ITEMS_BY_NAME.get(name)
    if item not in PAGE_ITEMS:
        raise RequestRefused(f"there is no parameter {name} of a comparison")
    if item.kind == "choice":
        if value in (None, "") and name not in SUPPOSED and item.default is None:
            return None
        if value not in item.choices:
            raise RequestRefused(
                f"`{name}` is {shorten_value(value)}; give one of {', '.join(item.choices)}"
            )
        return value
    return _READ[item.kind](name, value)


_READ: dict[str, Any] = {
    "flag": stated.flag,
    "whole": stated.whole,
    "number": stated.number,
    "constants": stated.constants,
    "odds": stated.odds,
    "names": stated.names,
}
