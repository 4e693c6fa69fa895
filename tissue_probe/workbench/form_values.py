"""Values as a form states them: a number may be a text, and a blank states nothing.

Contents: each kind of value.
"""

from __future__ import annotations

import math
from typing import Any

from tissue_probe.workbench.declaration import shorten_value
from tissue_probe.workbench.refusal import RequestRefused


def number(name: str, value: Any) -> float | None:
    """Return a number; None where none is stated.

    Raises
    ------
    Refused
        If it is none, or not finite.
    """
    if value in (None, ""):
        return None
    try:
        if isinstance(value, (str, int, float)) and not isinstance(value, bool):
            found = float(value)
            if math.isfinite(found):
                return found
    except (ValueError, OverflowError):
        pass
    raise RequestRefused(f"`{name}` is {shorten_value(value)}; give a number")


def whole(name: str, value: Any) -> int | None:
    """Return a whole number; None where none is stated.

    Raises
    ------
    Refused
        If it is none.
    """
    found = number(name, value)
    if found is None:
        return None
    if not found.is_integer():
        raise RequestRefused(f"`{name}` is {shorten_value(value)}; give a whole number")
    return int(found)


def flag(name: str, value: Any) -> bool:
    """Return yes or no.

    Raises
    ------
    Refused
        If it is neither.
    """
    if not isinstance(value, bool):
        raise RequestRefused(f"`{name}` is {shorten_value(value)}; give true or false")
    return value


def text(name: str, value: Any) -> str | None:
    """Return a text; None where it is blank.

    Raises
    ------
    Refused
        If it is none.
    """
    if value in (None, ""):
        return None
    if not isinstance(value, str):
        raise RequestRefused(f"`{name}` is {shorten_value(value)}; give a text")
    return value


def names(name: str, value: Any) -> tuple[str, ...]:
    """Return texts.

    Raises
    ------
    Refused
        If it is no list of texts.
    """
    if not isinstance(value, (list, tuple)) or not all(isinstance(each, str) for each in value):
        raise RequestRefused(f"`{name}` is {shorten_value(value)}; give a list of names")
    return tuple(value)


def constants(name: str, value: Any) -> dict[str, tuple[float, float]]:
    """Return values with their standard deviations, by name.

    Raises
    ------
    Refused
        If one is no pair of numbers.
    """
    return {each: _pair(name, stated) for each, stated in _by_name(name, value)}


def odds(name: str, value: Any) -> dict[str, float]:
    """Return odds by name, as a form states them, with an error that they have not, or as kept.

    Raises
    ------
    Refused
        If one is no number.
    """
    return {
        each: _pair(name, stated)[0]
        if isinstance(stated, (list, tuple))
        else _check_known(name, stated)
        for each, stated in _by_name(name, value)
    }


def _by_name(name: str, value: Any) -> Any:
    if not isinstance(value, dict):
        raise RequestRefused(f"`{name}` is {shorten_value(value)}; give numbers by name")
    return value.items()


def _pair(name: str, value: Any) -> tuple[float, float]:
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise RequestRefused(
            f"`{name}` is {shorten_value(value)}; give a number and its standard deviation"
        )
    return _check_known(name, value[0]), _check_known(name, value[1])


def _check_known(name: str, value: Any) -> float:
    found = number(name, value)
    if found is None:
        raise RequestRefused(f"`{name}` is {shorten_value(value)}; give a number")
    return found
