"""A tip that follows a known motion, and the force on it: closed forms.

    F = spring(x) + beta x' + sum_i q_i,    q_i' = k_i x' - r_i q_i

Contents: forces of motions that have gone on for ever, and of ramps and holds from rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.instrument.laws import REFERENCE
from benchmarks.instrument.multisine import Multisine

Array = np.ndarray


@dataclass(frozen=True)
class Tissue:
    """A tissue that a rigid tip presses, all SI units.

    Attributes
    ----------
    stiffness, damping : float
        k, of a power the secant's at 1 mm; beta.
    branches : tuple of (float, float)
        k_i and r_i.
    exponent : float
        Of the spring: k x0 (x / x0)^n with x0 = 1 mm, in contact only.
    cubic : float
        k3 of a spring k x + k3 x^3.
    """

    stiffness: float
    damping: float
    branches: tuple[tuple[float, float], ...] = ()
    exponent: float = 1.0
    cubic: float = 0.0

    def spring(self, depth: Array) -> Array:
        """Return the spring's force [N] at depths [m] above 0."""
        power = REFERENCE * (depth / REFERENCE) ** self.exponent
        return self.stiffness * power + self.cubic * depth**3

    def in_motion(self, depth: Multisine, times: Array) -> Array:
        """Return the force [N] at some times [s] of a motion that has gone on for ever."""
        force = self.spring(depth(times))
        moved = depth.through(
            lambda s: self.damping * s + sum(k * s / (s + r) for k, r in self.branches)
        )
        return force + moved(times)

    def on_path(self, corners: Array, depths: Array, times: Array) -> Array:
        """Return the force [N] on straight lines between corners (times [s], depths [m]).

        It begins at rest. A branch on a line of slope v:

            q = q0 exp(-r t) + k v / r (1 - exp(-r t))
        """
        slopes = np.diff(depths) / np.diff(corners)
        piece = np.clip(np.searchsorted(corners, times, side="left") - 1, 0, slopes.size - 1)
        force = self.spring(np.interp(times, corners, depths)) + self.damping * slopes[piece]
        for stiffness, rate in self.branches:
            begun = np.zeros(corners.size)
            for i, step in enumerate(np.diff(corners)):
                begun[i + 1] = _on_line(begun[i], stiffness, rate, slopes[i], step)
            since = times - corners[piece]
            force = force + _on_line(begun[piece], stiffness, rate, slopes[piece], since)
        return force

    def values(self) -> dict[str, float]:
        """Return its values by the library's names."""
        found = {"stiffness": self.stiffness, "damping": self.damping}
        if self.exponent != 1.0:
            found["contact_exponent"] = self.exponent
        if self.cubic:
            found["cubic_stiffness"] = self.cubic
        for number, (stiffness, rate) in enumerate(sorted(self.branches, key=lambda b: b[1]), 1):
            which = f"_{number}" if len(self.branches) > 1 else ""
            found[f"relaxing_stiffness{which}"] = stiffness
            found[f"relaxation_rate{which}"] = rate
        return found

    def effects(self) -> dict[str, str]:
        """Return its effects and their families, by the library's names."""
        found = {}
        if self.exponent != 1.0:
            found["hertz_contact"] = "stiffening"
        if self.cubic:
            found["cubic_stiffening"] = "stiffening"
        if self.branches:
            several = len(self.branches) > 1
            found["generalized_maxwell" if several else "standard_linear_solid"] = "relaxation"
        return found


def _on_line(begun: Array, stiffness: float, rate: float, slope: Array, since: Array) -> Array:
    gone = np.exp(-rate * since)
    return begun * gone + stiffness * slope / rate * (1.0 - gone)
