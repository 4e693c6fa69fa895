"""The size of a record: the units in which a model's constants are of the usual size.

Contents: how many times larger than usual lengths, forces and times are, and the factor of a number
by its unit.

Bounds, typical values and starts of a search are numbers for a probe that moves by millimetres and
feels newtons. For a cantilever of an atomic force microscope, or a press, the same numbers hold in
other units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

#: Sizes are powers of these: so steps of a prefix (um, mm, m; mN, N, kN) change
#: nothing but the units.
PREFIX_STEP = 1000.0
#: Exponents of length, force, time and second input in the units of which those of parameters are
#: made. The unit of a second input is that of its channel.
UNIT_EXPONENTS: dict[str, tuple[int, int, int, int]] = {
    "m": (1, 0, 0, 0),
    "N": (0, 1, 0, 0),
    "s": (0, 0, 1, 0),
    "kg": (-1, 1, 2, 0),
    "Hz": (0, 0, -1, 0),
    "Pa": (-2, 1, 0, 0),
    "rad": (0, 0, 0, 0),
    "input2": (0, 0, 0, 1),
}
#: Of seconds to a power that is itself a parameter. A law says of which time that is a multiple,
#: and its constant is as large for any such time.
TIME_TO_A_POWER = "s^a"


class UnitError(ValueError):
    """A unit that is not made of those known."""


@dataclass(frozen=True)
class Scale:
    """How many times larger than usual lengths, forces, times and second input of a record are."""

    length: float = 1.0
    force: float = 1.0
    time: float = 1.0
    input2: float = 1.0

    @property
    def is_usual(self) -> bool:
        """Whether the record is of the usual size."""
        return self == USUAL

    @property
    def inverse(self) -> Scale:
        """The scale that turns numbers back."""
        return Scale(1.0 / self.length, 1.0 / self.force, 1.0 / self.time, 1.0 / self.input2)

    def of(self, unit: str) -> float:
        """Return how many times larger than usual numbers of a unit are.

        Parameters
        ----------
        unit : str
            A product of ``UNIT_EXPONENTS`` and their powers, such as "N s/m" or "N/m^3": a unit
            after a stroke divides. "1" and nothing are units, too.

        Raises
        ------
        UnitError
            If there is something else in it.
        """
        length, force, time, input2 = _exponents(unit)
        factor = self.length**length * self.force**force * self.time**time
        return factor * self.input2**input2


USUAL = Scale()


def nearest(size: float, usual: float) -> float:
    """Return the power of ``PREFIX_STEP`` by which a size is nearest to the usual; 1 if none is.

    As a power of ten in whole digits, so that a record in other units gives the same numbers.
    """
    if not 0.0 < size < math.inf:
        return 1.0
    return float(f"1e{3 * math.floor(math.log(size / usual, PREFIX_STEP) + 0.5)}")


@lru_cache(maxsize=256)
def _exponents(unit: str) -> tuple[int, int, int, int]:
    found = [0, 0, 0, 0]
    for factor in unit.replace("*", " ").replace("/", " /").split():
        if factor in ("1", TIME_TO_A_POWER):
            continue
        name, _, power = factor.removeprefix("/").partition("^")
        sign = -1 if factor.startswith("/") else 1
        if name not in UNIT_EXPONENTS or not (power or "1").lstrip("-").isdigit():
            raise UnitError(f"the unit {unit!r} is not made of {', '.join(UNIT_EXPONENTS)}")
        for place, exponent in enumerate(UNIT_EXPONENTS[name]):
            found[place] += sign * int(power or 1) * exponent
    return found[0], found[1], found[2], found[3]
