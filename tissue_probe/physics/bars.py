"""Bars between two grips or plates: force over modulus.

Contents: a specimen of even cross-section that is pulled or pressed along its length.

With E Young's modulus, A the area and L the gauge length, F = E A x / L for an extension or
shortening x: stress F / A, strain x / L, both engineering, of the specimen without load. Its sides
are free: one that is as wide as high and stuck to its plates is stiffer (A. Gent and P. Lindley,
Proc. Inst. Mech. Engineers 173 (1959), 111). Indenters have a file of their own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class UniformBar:
    """A specimen of even cross-section.

    Attributes
    ----------
    length, area : float
        Gauge length [m], and area of the cross-section [m^2], where nothing pulls.
    length_deviation, area_deviation : float
        Standard deviations of their errors; 0 where they are known.
    """

    length: float
    area: float
    length_deviation: float = 0.0
    area_deviation: float = 0.0

    @property
    def slope(self) -> float:
        """The stiffness over the modulus [m]."""
        return self.area / self.length

    @property
    def relative_deviation(self) -> float:
        """Standard deviation of the slope over the slope."""
        return math.hypot(self.length_deviation / self.length, self.area_deviation / self.area)
