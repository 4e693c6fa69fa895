"""The states at the start of a motion that goes on, told from the first samples, then from more.

Contents: another start of a search that may have ended in a minimum of a wrong start.

The residual of a whole record has many minima over the states at its start: a resonance that begins
with another speed comes out of step, and in step again. Over a short window there is one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.point import point_at
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.search import Bar, descend, search
from tissue_probe.signals import FloatArray

#: Samples of the first window, as many as tell the first speed, and how many times longer the next
#: one is: a state known to a share of a turn by one window is known to less than a turn by the
#: next, as long as its error falls as fast as the window grows.
FIRST, LONGER = 8, 3
#: The last window, three times as much longer: its start is then known to a share of a turn of a
#: motion that turns once in the samples of the first.
LAST = FIRST * LONGER**3


def search_other_starts(problem: Problem, fit: Fit | None, bar: Bar | None = None) -> Fit | None:
    """Return a fit, or the one that is found from a start that growing windows tell, if better.

    A model that is linear in its states has one minimum only, and so has one that begins at rest.
    """
    if fit is None or problem.kernel.linear or not problem.states:
        return fit
    starts = [
        start if measurement.at_rest else _estimate_start(problem, index, fit.values, start)
        for index, (measurement, start) in enumerate(
            zip(problem.measurements, fit.starts, strict=True)
        )
    ]
    if all(new is old for new, old in zip(starts, fit.starts, strict=True)):
        return fit
    with np.errstate(all="ignore"):
        if point_at(problem, fit.values, starts, fit.cost) is None:
            return fit
    found = search(problem, fit.values, starts, bar)
    return found if found is not None and found.cost < fit.cost else fit


def _estimate_start(
    problem: Problem, index: int, values: FloatArray, start: FloatArray
) -> FloatArray:
    """Return the start of a measurement that the first samples tell, the values being held."""
    own = problem.runs.values_in(index, values)
    held = dict(zip(problem.kernel.values, map(float, own), strict=True))
    measurement, size = problem.measurements[index], FIRST
    counting = np.flatnonzero(measurement.used)
    found: Sequence[FloatArray] = [problem.begin(values)[index].mean]
    while size <= LAST and size < counting.size:
        begun = measurement.take_beginning(int(counting[size]))
        window = Problem(problem.composition, [begun], problem.instrument, held)
        ended = descend(window, own, found)
        if ended is None:
            return start
        found, size = ended[0].starts, LONGER * size
    return found[0]
