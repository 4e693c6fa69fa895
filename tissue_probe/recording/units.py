"""Units of foreign files, and what turns their numbers into SI.

What belongs here: names of units, and units in the names of columns (``u_mm``, ``force [mN]``).
What does not: choosing columns (``table_file``) or topics (``foreign_bag``).
"""

from __future__ import annotations

import re

POSITION_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
"""Metres in one of each."""

FORCE_UNITS = {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "kN": 1e3, "gf": 9.80665e-3, "kgf": 9.80665}
"""Newtons in one of each."""

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Seconds in one of each."""

_SUFFIX = re.compile(r"(?P<stem>.*?)\s*(?:_(?P<bare>\w+)|\[(?P<square>\w+)\]|\((?P<round>\w+)\))")


def unit_size(unit: str, units: dict[str, float]) -> float:
    """Return how large a unit is in SI.

    Parameters
    ----------
    unit : str
        A name in ``units``, or a positive number: the size of one count, volt, ... in SI.
    units : dict
        One of the tables above.

    Raises
    ------
    ValueError
        If it is neither.
    """
    if (size := units.get(_ascii(unit))) is not None:
        return size
    try:
        size = float(unit)
    except ValueError:
        size = 0.0
    if not 0.0 < size < float("inf"):
        raise ValueError(
            f"unit '{unit}' is not known; give {', '.join(units)}, or the size of one in "
            f"{next(iter(units))} as a positive number"
        )
    return size


def split_unit(name: str, units: dict[str, float]) -> tuple[str, str | None]:
    """Split ``u_mm``, ``u [mm]`` or ``u (mm)`` into name and unit; None where it has no unit."""
    match = _SUFFIX.fullmatch(_ascii(name.strip()))
    if match:
        unit = match["bare"] or match["square"] or match["round"]
        if unit in units:
            return match["stem"], unit
    return name, None


def _ascii(text: str) -> str:
    """Write the micro sign and the Greek letter that looks like it as u."""
    return text.replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")
