"""Numbers as a reader wants them: as many digits as are known.

Contents: text made of values.
"""

from __future__ import annotations

import math

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_SMALLEST, _LARGEST = 1e-3, 1e5  # written without a power of ten
_NOTHING = 100.0  # half widths over value from which on nothing is known of a value but its size


def significant(value: float, digits: int = 3) -> str:
    """Return a value with so many significant digits; a dash for NaN."""
    if not math.isfinite(value):
        return "–"
    if value != 0.0 and not _SMALLEST <= abs(value) < _LARGEST:
        power = math.floor(math.log10(abs(value)))
        return f"{value / 10.0**power:.{digits - 1}f} × 10{_superscript(power)}"
    return _write_fixed(value, digits - 1 - _magnitude(value))


def interval(value: float, low: float, high: float) -> tuple[str, str]:
    """Return a value and its interval, to two digits of the interval's half width.

    Of a value that is lost in its interval the first text is ``0 ± half``, the second empty.

    Parameters
    ----------
    value, low, high : float
        In one unit; without an interval (NaN) the second text is empty.
    """
    half = 0.5 * abs(high - low)
    if not math.isfinite(half) or half == 0.0:
        return significant(value, 4), ""
    if _is_lost(value, half) and _is_lost(0.5 * (low + high), half):
        return f"0 ± {significant(half, 2)}", ""
    large = max(abs(value), abs(low), abs(high))
    scaled = not _SMALLEST <= large < _LARGEST
    power = math.floor(math.log10(large)) if scaled else 0
    decimals = 1 - (_magnitude(half) - power)
    middle, least, most = (
        _write_fixed(each / 10.0**power, decimals) for each in (value, low, high)
    )
    if scaled:
        factor = f" × 10{_superscript(power)}"
        return f"{middle}{factor}", f"({least} … {most}){factor}"
    return middle, f"{least} … {most}"


def _is_lost(value: float, half: float) -> bool:
    """Whether a value is nothing beside its interval, or would be written as 0."""
    return half >= _NOTHING * abs(value) or round(value, 1 - _magnitude(half)) == 0.0


def _magnitude(value: float) -> int:
    return math.floor(math.log10(abs(value))) if value else 0


def _superscript(power: int) -> str:
    return str(power).translate(_SUPERSCRIPTS)


def _write_fixed(value: float, decimals: int) -> str:
    # Adding 0 takes the sign off a zero.
    text = f"{round(value, decimals) + 0.0:.{max(decimals, 0)}f}"
    return text.replace("-", "−")
