"""How well a value is known by which something switches: by the likelihood, not by its curvature.

Such a value (the gap at which a bond is torn, the instant of a step) decides at which sample an
event happens. Between two samples the cost is flat, and at a sample it jumps: its curvature tells
nothing of how far the value may be off. Here the cost itself is asked, with the value held and all
others fitted again.

Contents: the values of a model by which it switches, and their intervals.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.search import descend
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.physics.composition import Composition
from tissue_probe.quantities import SIDE

#: By how much the misfit rises at the ends of a 95 % interval where the cost is a parabola.
OF_PARABOLA = SIDE**2
#: The same where it goes up by chance steps, one at each event that moves past a sample: about the
#: truth the rise falls short by the larger of two exponential variables, of either side, and stays
#: within -2 log(1 - 0.95^(1/2)) in 95 % of all recordings (D. Siegmund, Int. Statistical Review 56
#: (1988), 31).
OF_STEPS = -2.0 * np.log(1.0 - 0.95**0.5)
#: The curvature is right where its interval's ends are as unlikely as it says, to this share.
AS_CURVED = 0.5
#: Share of an interval to which its ends are found.
PRECISION = 0.1
#: The first way that is tried where the curvature tells none, as a share of the value, or of one
#: that is typical where it is 0.
LEAST_WAY = 1e-4


def name_switching_values(composition: Composition) -> set[str]:
    """Return the values of effects by which something switches."""
    return {
        entry.name
        for effect in composition.all_effects
        for entry in effect.parameters
        if any({entry.symbol} & (each.on + each.off).free_symbols for each in effect.switches)
    }


def ask_likelihood(fit: Fit, instrument: Instrument) -> Fit:
    """Return a fit whose intervals hold the values that the samples do not exclude.

    Parameters
    ----------
    fit : Fit
        The fit; values by which nothing switches stay as they are.
    instrument : Instrument
        Constants of the rig with their tolerances.

    Returns
    -------
    Fit
        With another covariance where the curvature of the cost misleads: half of an interval is its
        farther end.
    """
    problem = Problem(fit.composition, fit.measurements, instrument)
    names = name_switching_values(fit.composition)
    known = fit.covariance.copy()
    for place, meaning in enumerate(problem.runs.meanings):
        if meaning not in names or not problem.free[place]:
            continue
        deviation = float(np.sqrt(max(known[place, place], 0.0)))
        half = _find_half(fit, problem, place, SIDE * deviation)
        if deviation > 0.0:
            known[place, :] *= half / (SIDE * deviation)
            known[:, place] *= half / (SIDE * deviation)
        else:
            known[place, place] = (half / SIDE) ** 2
    return fit if np.array_equal(known, fit.covariance) else replace(fit, covariance=known)


def _find_half(fit: Fit, problem: Problem, place: int, half: float) -> float:
    """Return half of the interval of a value: ``half``, by the curvature, where that is right."""
    value, ways = fit.values[place], []
    least = LEAST_WAY * (abs(value) or fit.entries[place].default)
    for bound, side in ((problem.lower[place], -1.0), (problem.upper[place], 1.0)):
        room = abs(bound - value)
        profile = _Profile(fit, problem.instrument, place, side)
        if not 0.0 < half <= room or not _is_parabola(profile.rise(half)):
            ways.append(_find_way(profile, max(min(half, room), least), room))
    return max(ways) if len(ways) == 2 else max([half, *ways])


def _is_parabola(rise: float) -> bool:
    """Whether the misfit rises at an end of the interval as the curvature says."""
    return AS_CURVED * OF_PARABOLA <= rise <= OF_PARABOLA / AS_CURVED


class _Profile:
    """The misfit over a value that is held, on one side of a fit, all others fitted again."""

    def __init__(self, fit: Fit, instrument: Instrument, place: int, side: float) -> None:
        self._fit, self._instrument, self._place, self._side = fit, instrument, place, side
        self._values, self._starts = fit.values, fit.starts

    def rise(self, way: float) -> float:
        """Return by how much the misfit rises; begin with the values of the last that were likely.

        So the others follow: far from the fit a search might not find them.
        """
        fit, values = self._fit, self._values.copy()
        values[self._place] = value = fit.values[self._place] + self._side * way
        held = {fit.names[self._place]: float(value)}
        problem = Problem(fit.composition, fit.measurements, self._instrument, held)
        found = descend(problem, values, self._starts)
        if found is None:
            return np.inf
        least = np.finfo(float).tiny  # zeros are fitted without a rest
        ratio = max(found[0].cost, least) / max(fit.cost, least)
        rise = fit.samples * float(np.log(ratio))
        if rise < OF_STEPS:
            self._values, self._starts = found[0].values, tuple(found[0].starts)
        return rise


def _find_way(profile: _Profile, first: float, room: float) -> float:
    """Return how far a value may go on one side until it is excluded, ``room`` at the most."""
    inside, outside = 0.0, min(first, room)
    while profile.rise(outside) < OF_STEPS:
        if outside >= room:
            return room
        inside, outside = outside, min(2.0 * outside, room)
    while outside - inside > PRECISION * outside and outside > LEAST_WAY * first:
        middle = 0.5 * (inside + outside)
        likely = profile.rise(middle) < OF_STEPS
        inside, outside = (middle, outside) if likely else (inside, middle)
    return outside
