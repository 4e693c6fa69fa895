"""The two signals of an instrument, as what they are called and measured in.

What belongs here: name, unit, and the units in which people read them.
What does not: which of them drives and which answers (``physics.rigs``), samples (``signals``).

It imports no NumPy: names are asked for before there are numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


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
        What its change in time is called.
    drawn, small : str
        Units in which the signal, and an error of it, are shown.
    per_drawn, per_small : float
        How many of these make one SI unit.
    zeroed : bool
        Whether its zero means something: a position counts from anywhere.
    """

    name: str
    unit: str
    rate: str
    drawn: str
    per_drawn: float
    small: str
    per_small: float
    zeroed: bool

    def size(self, values: NDArray[np.float64]) -> float:
        """Return the rms of values [SI], about their mean where the zero means nothing."""
        import numpy as np

        return float(np.sqrt(np.mean(values**2)) if self.zeroed else np.std(values))

    def tell(self, error: float, digits: int = 3) -> str:
        """Return an error [SI] in words."""
        return f"{self.per_small * error:.{digits}g} {self.small}"


POSITION = Quantity("position", "m", "speed", "mm", 1e3, "um", 1e6, zeroed=False)
FORCE = Quantity("force", "N", "rate of force", "N", 1.0, "mN", 1e3, zeroed=True)


def other(quantity: Quantity) -> Quantity:
    """Return the signal that drives where this one answers, and the reverse."""
    return POSITION if quantity is FORCE else FORCE
