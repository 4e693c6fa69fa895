"""How strong a hidden effect is made: so that it leaves the residual that was asked for.

Contents: the search for the strength.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tissue_probe.challenge.case import Case
from tissue_probe.challenge.change import Change, HiddenEffect
from tissue_probe.challenge.tolerances import Tolerances

SEARCH_RATE = 8_000
"""Steps a second while searching [Hz]; the challenge itself is simulated at 40 kHz."""

STRENGTH_TOLERANCE = 0.02  # of the logarithm of the excess
STRENGTHS_TRIED = 12
ABSORBED = 1.05
"""Ratio below which an effect counts as absorbed by the Kelvin-Voigt model."""

FAINTEST_RATIO = 1.2
"""Ratio that an effect leaves at least, if any strength does."""


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
        Asked for, and reached: rms left by the best Kelvin-Voigt fit, in units of the noise, with
        this effect alone.
    shown : float
        The ratio that is left where the fit may move the rig within its tolerances.
    absorbed : bool
        Whether the model absorbs it, at its typical strength or whatever strength was tried.
    """

    change: Change
    strength: float
    target: float
    ratio: float
    shown: float
    absorbed: bool


def hide(
    effect: HiddenEffect, case: Case, target: float, seed: int, tolerances: Tolerances | None = None
) -> Hidden:
    """Find the strength at which an effect leaves ``target`` times the noise.

    Where no strength of its range does, that which comes nearest is taken. ``seed`` is that of
    whatever the effect draws; ``tolerances`` are those of the rig, None where it is known exactly.
    """

    def change(strength: float) -> Change:
        return effect.make(strength, case.situation, np.random.default_rng(seed))

    def ratio(strength: float) -> float:
        return case.apply_change(change(strength)).ratio(case.specimen, SEARCH_RATE)

    strength = effect.typical
    if ratio(strength) >= ABSORBED:
        strength = _reach(ratio, effect, target)
    reached = ratio(strength)
    made, shown = change(strength), reached
    if tolerances is not None:
        shown = case.apply_change(made).ratio(case.specimen, SEARCH_RATE, tolerances)
    return Hidden(made, strength, target, reached, shown, absorbed=reached < ABSORBED)


def _reach(ratio: Callable[[float], float], effect: HiddenEffect, target: float) -> float:
    """Find where the ratio is the target, by secants on logarithms kept within a bracket.

    The excess over the noise grows about as the strength, so that the first secant is near.
    """

    def excess(place: float) -> float:
        over = min(ratio(float(np.exp(place))), 1e6) ** 2 - 1.0
        return 0.5 * float(np.log(max(over, 1e-12) / (target**2 - 1.0)))

    low, place, high = np.log([effect.weakest, effect.typical, effect.strongest])
    slope, errors = 1.0, {place: excess(place)}
    while abs(errors[place]) > STRENGTH_TOLERANCE and len(errors) < STRENGTHS_TRIED:
        low, high = (place, high) if errors[place] < 0.0 else (low, place)
        following = float(np.clip(place - errors[place] / slope, low, high))
        if following in errors:  # beyond what is known to be too weak or too strong
            following = 0.5 * (low + high)
        if following == place:  # at an end of the range
            break
        errors[following] = excess(following)
        rise = (errors[following] - errors[place]) / (following - place)
        slope, place = float(np.clip(rise, 0.3, 10.0)), following
    # Some effects set in with a jump: rather one that shows too well than one that does not.
    faintest = 0.5 * np.log((FAINTEST_RATIO**2 - 1.0) / (target**2 - 1.0))
    shown = [place for place, error in errors.items() if error >= faintest]
    return float(np.exp(min(shown or errors, key=lambda place: abs(errors[place]))))
