"""How strong a hidden effect is made: so that it leaves the residual that was asked for.

What belongs here: the search for the strength. What does not: measuring it (``case``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from tissue_probe.challenge.case import Case
from tissue_probe.challenge.change import Change, Effect
from tissue_probe.challenge.motion import RATE

SEARCH_RATE = 8_000
"""Steps a second while searching [Hz]; the challenge itself is simulated at 40 kHz."""

TOLERANCE = 0.03  # of the logarithm of the strength
ABSORBED = 1.05
"""Ratio below which a typical strength counts as absorbed by the Kelvin-Voigt model."""


@dataclass(frozen=True)
class Hidden:
    """An effect at the strength found.

    Attributes
    ----------
    change : Change
        What it sets.
    strength : float
        In the unit of the effect's table.
    target, ratio : float
        Asked for, and reached: rms left by the best Kelvin-Voigt fit, in units of the noise, this effect alone.
    absorbed : bool
        Whether the model absorbs it; it then has its typical strength.
    """

    change: Change
    strength: float
    target: float
    ratio: float
    absorbed: bool


def hide(effect: Effect, case: Case, target: float, seed: int) -> Hidden:
    """Find the strength at which an effect leaves ``target`` times the noise.

    Where no strength of its range does, that which comes nearest is taken. ``seed`` is that of
    whatever the effect draws.
    """

    def change(strength: float) -> Change:
        return effect.make(strength, case.situation, np.random.default_rng(seed))

    def ratio(strength: float, rate: int = SEARCH_RATE) -> float:
        return case.changed(change(strength)).ratio(case.specimen, rate)

    def excess(logarithm: float) -> float:
        left = min(ratio(float(np.exp(logarithm))), 1e6)
        return 0.5 * float(np.log(max(left**2 - 1.0, 1e-12) / (target**2 - 1.0)))

    absorbed = ratio(effect.typical) < ABSORBED
    strength = effect.typical
    if not absorbed:
        strength = float(np.exp(_root(excess, np.log(effect.weakest), np.log(effect.strongest))))
    return Hidden(change(strength), strength, target, ratio(strength, RATE), absorbed)


def _root(excess: Callable[[float], float], low: float, high: float) -> float:
    """Return where the excess over the target is none, else the end that comes nearest."""
    below, above = excess(low), excess(high)
    if below >= 0.0 or above <= 0.0:
        return low if abs(below) < abs(above) else high
    return brentq(excess, low, high, xtol=TOLERANCE, rtol=1e-3, maxiter=30)
