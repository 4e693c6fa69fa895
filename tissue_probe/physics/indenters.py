"""Indenters on an elastic half space or on a thin layer: force over modulus at a depth.

Contents: flat punch, sphere and cone, and a sphere on a layer that is bonded to a hard base.

With E the modulus, nu Poisson's ratio, F the force at the depth d, a or R the radius, t the half
angle from the axis: F = 2 a d E / (1 - nu^2) for a flat punch, 4/3 sqrt(R) d^1.5 E / (1 - nu^2) for
a sphere (Hertz, 1881), 2/pi tan(t) d^2 E / (1 - nu^2) for a cone (Sneddon, Int. J. Engineering
Science 3 (1965), 47). On a layer of the height h, of nu = 0.5, the sphere's force is larger by a
polynomial of chi = sqrt(R d) / h (Dimitriadis et al., Biophysical J. 82 (2002), 2798, eq. 12).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

Shape = Literal["flat", "sphere", "cone"]
#: Power of the depth that the force of each grows with.
DEPTH_POWERS: dict[Shape, float] = {"flat": 1.0, "sphere": 1.5, "cone": 2.0}
#: Factors by which a layer that keeps its volume stiffens, of the powers of chi.
OF_LAYER = (1.0, 1.133, 1.283, 0.769, 0.0975)
#: Beyond it the polynomial of a thin layer is not given [-].
THINNEST = 1.0


@dataclass(frozen=True)
class Indenter:
    """The shape of a tip, and the layer that it presses on.

    Attributes
    ----------
    shape : {"flat", "sphere", "cone"}
        Of the tip.
    size : float
        Radius [m]; of a cone the half angle from its axis [rad].
    poisson : float
        Poisson's ratio of the tissue, 0 to 0.5.
    layer : float
        Height of a layer bonded to a hard base, under a sphere [m]; infinite on a half space.
    """

    shape: Shape
    size: float
    poisson: float = 0.5
    layer: float = math.inf

    def force(self, depth: float) -> float:
        """Return the force over the modulus at a depth [m], in square metres."""
        plane = 1.0 - self.poisson**2
        if self.shape == "flat":
            return 2.0 * self.size * depth / plane
        if self.shape == "cone":
            return 2.0 / math.pi * math.tan(self.size) * depth**2 / plane
        return float(4.0 / 3.0 * math.sqrt(self.size) * depth**1.5 / plane * self._of_layer(depth))

    def slope(self, depth: float) -> float:
        """Return the stiffness over the modulus at a depth [m], in metres: the force's slope."""
        step = 1e-4 * depth
        return (self.force(depth + step) - self.force(depth - step)) / (2.0 * step)

    def chi(self, depth: float) -> float:
        """Return the contact's radius over the layer's height; 0 on a half space."""
        return math.sqrt(self.size * depth) / self.layer

    def _of_layer(self, depth: float) -> float:
        chi = self.chi(depth)
        return sum(each * chi**power for power, each in enumerate(OF_LAYER))
