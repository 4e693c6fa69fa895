"""The specimen under the tip, and the tip: what force an indentation meets.

Contents: the law of the force, by numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Specimen:
    """Kelvin-Voigt, f = k e + beta v, and at most one part more. All SI units.

    Attributes
    ----------
    stiffness, damping, mass : float
        k, beta, and the mass that moves with the tip.
    touch : float
        Position at which the tip touches; the indentation e is the position less this.
    branch_stiffness, branch_rate : tuples of float
        Maxwell branches beside it: q' = stiffness v - rate q, each a force q.
    law : str
        ``linear``; ``exponential``: k L (exp(e / L) - 1); ``cubic``: k e (1 + (e / L)^2);
        ``power``: k e (e / L)^(n - 1) for e > 0, none out of contact.
    length, exponent : float
        L [m] and n of the law.
    one_sided : bool
        Whether the tissue only pushes: its force is none at e <= 0, and never below 0.
    friction : float
        Dry friction Fc [N] on the tip, against its motion.
    """

    stiffness: float
    damping: float
    mass: float = 0.0
    touch: float = 0.0
    branch_stiffness: tuple[float, ...] = ()
    branch_rate: tuple[float, ...] = ()
    law: str = "linear"
    length: float = 1.0
    exponent: float = 1.0
    one_sided: bool = False
    friction: float = 0.0

    def spring(self, depth: Array) -> Array:
        """Return the spring's force [N] at an indentation [m]."""
        if self.law == "exponential":
            return self.stiffness * self.length * np.expm1(depth / self.length)
        if self.law == "cubic":
            return self.stiffness * depth * (1.0 + (depth / self.length) ** 2)
        if self.law == "power":
            within = np.maximum(depth, 0.0)
            return self.stiffness * self.length * (within / self.length) ** self.exponent
        return self.stiffness * depth

    def force(self, depth: Array, speed: Array, branches: Array) -> Array:
        """Return the tissue's force [N] on the tip.

        Parameters
        ----------
        depth, speed : float or array
            Indentation [m], and its rate [m/s].
        branches : float or array
            Sum of the forces in the branches [N].
        """
        whole = self.spring(depth) + self.damping * speed + branches
        if not self.one_sided:
            return whole
        return np.where(np.asarray(depth) > 0.0, np.maximum(whole, 0.0), 0.0)

    @property
    def stiffness_at_once(self) -> float:
        """Of the spring and all branches [N/m], the law's length apart."""
        return self.stiffness + sum(self.branch_stiffness)
