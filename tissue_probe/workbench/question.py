"""The question, as a page states it: the items of ``analysis.question_items``, but for files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tissue_probe.analysis.question_items import ITEMS_BY_NAME, Item
from tissue_probe.workbench import form_values
from tissue_probe.workbench.declaration import shorten_value
from tissue_probe.workbench.refusal import RequestRefused

#: Values supposed where a page states nothing; of others' recordings the rig is asked for.
SUPPOSED: dict[str, Any] = {"tissue": "kelvin_voigt"}
#: The items that a page may state: no file of its machine.
PAGE_ITEMS = tuple(each for each in ITEMS_BY_NAME.values() if each.kind not in ("file", "files"))


def check_question(given: dict[str, Any]) -> dict[str, Any]:
    """Return a page's statements on the model, as ``tissue_probe.compare`` takes them.

    Raises
    ------
    Refused
        If something is no parameter, or has no such value.
    """
    return {name: _check_statement(name, value) for name, value in given.items()}


@dataclass(frozen=True)
class StatedQuestion:
    """The question, by the names of the items: what is stated, and what is supposed elsewhere.

    ``constants`` holds (value, standard deviation) by name.
    """

    items: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        whole = {each.name: self.items.get(each.name, _suppose(each)) for each in PAGE_ITEMS}
        object.__setattr__(self, "items", whole)

    def changed(self, given: dict[str, Any]) -> StatedQuestion:
        """Return it with a page's further statements, checked."""
        return StatedQuestion({**self.items, **check_question(given)})

    def parameters(self) -> dict[str, Any]:
        """Return it as ``compare`` and ``diagnose`` take it: None where nothing is stated."""
        return dict(self.items)

    def of_samples(self) -> dict[str, Any]:
        """Return the part that is of the samples, and not of the model."""
        return {name: self.items[name] for name in ("starts", "site", "lowpass", "course")}


def _suppose(item: Item) -> Any:
    return {} if item.kind in ("constants", "odds") else SUPPOSED.get(item.name, item.default)


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
    "flag": form_values.flag,
    "whole": form_values.whole,
    "number": form_values.number,
    "constants": form_values.constants,
    "odds": form_values.odds,
    "names": form_values.names,
}
