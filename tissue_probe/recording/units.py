"""Units of foreign files, and their factors to SI.

Contents: names of units, and units in the names of columns (``u_mm``, ``force [mN]``).
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from tissue_probe.errors import ParameterError

POSITION_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "in": 0.0254}
"""Metres in one of each."""

VELOCITY_UNITS = {
    f"{length}/{time}": metres / seconds
    for length, metres in POSITION_UNITS.items()
    for time, seconds in (("s", 1.0), ("min", 60.0))
}
"""Metres a second in one of each."""

POUND = 4.4482216152605
FORCE_UNITS = {
    "N": 1.0,
    "mN": 1e-3,
    "uN": 1e-6,
    "nN": 1e-9,
    "kN": 1e3,
    "gf": 9.80665e-3,
    "kgf": 9.80665,
    "lbf": POUND,
}
"""Newtons in one of each."""

STIFFNESS_UNITS = {
    f"{force}/{length}": newtons / metres
    for force, newtons in FORCE_UNITS.items()
    for length, metres in POSITION_UNITS.items()
}
"""Newtons a metre in one of each."""

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
"""Seconds in one of each."""

_SPELT = {
    "s": "s", "mm": "mm", "sec": "s", "secs": "s", "second": "s", "seconds": "s", "sek": "s",
    "msec": "ms", "millisecond": "ms", "milliseconds": "ms",
    "usec": "us", "microsecond": "us", "microseconds": "us",
    "nsec": "ns", "nanosecond": "ns", "nanoseconds": "ns",
    "minute": "min", "minutes": "min", "hr": "h", "hour": "h", "hours": "h",
    "metre": "m", "meter": "m", "metres": "m", "meters": "m", "micron": "um", "microns": "um",
    "millimetre": "mm", "millimeter": "mm", "millimetres": "mm", "millimeters": "mm",
    "inch": "in", "inches": "in", "micrometre": "um", "micrometer": "um",
    "newton": "N", "newtons": "N", "millinewton": "mN", "millinewtons": "mN",
    "kilonewton": "kN", "kilonewtons": "kN",
}  # fmt: skip
"""Other spellings, in lower case."""

_UNIT = r"[\w/]+"
_SUFFIX = re.compile(
    rf"(?P<stem>.*?)\s*(?:_(?P<bare>{_UNIT})|\[\s*(?P<square>{_UNIT})\s*\]"
    rf"|\(\s*(?P<round>{_UNIT})\s*\)|[/,]\s*(?P<after>{_UNIT})|\s+in\s+(?P<words>{_UNIT}))"
)
_ALL = POSITION_UNITS | FORCE_UNITS | TIME_UNITS | VELOCITY_UNITS
_OTHER = re.compile(r"\(\s*[^()]*\s*\)|\[\s*[^\[\]]*\s*\]")


def unit_size(unit: str, units: Mapping[str, float]) -> float:
    """Return how large a unit is in SI.

    Parameters
    ----------
    unit : str
        A name in ``units``, or a positive number: the size of one count, volt, ... in SI.
    units : dict
        One of the tables above.

    Raises
    ------
    ParameterError
        If it is neither.
    """
    if (size := units.get(spell_unit(unit))) is not None:
        return size
    try:
        size = float(unit)
    except ValueError:
        size = 0.0
    if not 0.0 < size < float("inf"):
        raise ParameterError(
            f"unit '{unit}' is not known; give {', '.join(units)}, or the size of one in "
            f"{next(iter(units))} as a positive number"
        )
    return size


def split_unit(name: str, units: Mapping[str, float]) -> tuple[str, str | None]:
    """Split a name and its unit; None where it has none of these.

    ``u_mm``, ``u [mm]``, ``u (mm)``, ``u / mm``, ``u, mm`` and ``u in mm``.
    """
    match = _SUFFIX.fullmatch(_ascii(name.strip()))
    if match:
        unit = next(spell_unit(found) for found in match.groups()[1:] if found)
        if unit in units and not (match["bare"] and unit in ("in", "h")):  # u_in, F_h: no units
            return match["stem"], unit
    return name, None


def bare_unit(text: str) -> str | None:
    """Return the unit that a text is, in brackets or not; None where it is none that is known."""
    text = text.strip()
    if _OTHER.fullmatch(text):
        text = text[1:-1]
    unit = spell_unit(text)
    return unit if unit in _ALL else None


def bare_unit_in(name: str) -> str | None:
    """Return the unit in a column's name, of any quantity."""
    return split_unit(name, _ALL)[1]


def spell_unit(unit: str) -> str:
    """Return a unit as it stands in the tables above, where it is spelt otherwise."""
    unit = _ascii(unit.strip())
    return _SPELT.get(unit.casefold(), unit)


def _ascii(text: str) -> str:
    """Write the micro sign and the Greek letter that looks like it as u."""
    return text.replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")
