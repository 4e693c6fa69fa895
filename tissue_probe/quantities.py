"""The two signals of an instrument: their names and units.

Contents: name, unit, the units in which people read them, and the width of their intervals.

It imports no NumPy: names are asked for before there are numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, SupportsIndex

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: Half of a 95 % interval, in standard deviations of a normal error.
SIDE = 1.96


@dataclass(frozen=True)
class Quantity:
    """A signal that is measured.

    Attributes
    ----------
    name : str
        Also that of the samples' attribute.
    unit : str
        SI.
    rate : str
        The name of its rate of change.
    drawn, small : str
        Units in which the signal, and an error of it, are shown.
    per_drawn, per_small : float
        How many of these make one SI unit.
    zeroed : bool
        Whether its zero means something: a position counts from anywhere.
    """

    name: Literal["force", "position"]
    unit: Literal["N", "m"]
    rate: str
    drawn: str
    per_drawn: float
    small: str
    per_small: float
    zeroed: bool

    def __reduce_ex__(self, protocol: SupportsIndex) -> Any:
        """Come back from bytes as the one of its name: which of the two it is, is asked by `is`."""
        return find_quantity, (self.name,)

    def size(self, values: NDArray[np.float64]) -> float:
        """Return the rms of values [SI], about their mean where the zero means nothing."""
        import numpy as np

        return float(np.sqrt(np.mean(values**2)) if self.zeroed else np.std(values))

    def tell(self, error: float, digits: int = 3) -> str:
        """Return an error [SI] in words."""
        return engineering(error, self.unit, digits)


#: Prefixes of units, from the smallest on, three powers of ten apart.
PREFIXES = "fpnum kMGT"


def scale_value(value: float, unit: str) -> tuple[float, str]:
    """Return a value's divisor [unit], and the unit with its prefix, to read it easily.

    Pure numbers, times and rates of inverse units have none.
    """
    factor = 1.0
    if unit == "kg":
        factor, unit = 1e-3, "g"
    if not (unit[:1].isalpha() and math.isfinite(value) and value):
        return factor, unit
    # To three digits 999.96 is 1000.
    power = math.floor(math.log10(abs(float(f"{value / factor:.3g}"))) / 3.0)
    power = min(max(power, -PREFIXES.index(" ")), len(PREFIXES) - 1 - PREFIXES.index(" "))
    prefix = PREFIXES[PREFIXES.index(" ") + power].strip()
    return factor * 10.0 ** (3 * power), f"{prefix}{unit}"


def engineering(value: float, unit: str, digits: int = 3) -> str:
    """Return a value [SI] in words, as engineers write it: 0.0402 N is 40.2 mN."""
    factor, shown = scale_value(value, unit)
    return f"{value / factor:.{digits}g} {shown}".removesuffix(" 1")


POSITION = Quantity("position", "m", "speed", "mm", 1e3, "um", 1e6, zeroed=False)
FORCE = Quantity("force", "N", "rate of force", "N", 1.0, "mN", 1e3, zeroed=True)


def find_quantity(name: str) -> Quantity:
    """Return the quantity of a name."""
    known: dict[str, Quantity] = {each.name: each for each in (POSITION, FORCE)}
    return known[name]


def other(quantity: Quantity) -> Quantity:
    """Return the signal that drives where this one answers, and the reverse."""
    return POSITION if quantity is FORCE else FORCE
