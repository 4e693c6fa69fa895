"""A fitted model on other runs of the specimen: its values are held, but those of a run.

Contents: the values that are fitted again in each run, such as the phase of the mains.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.runs import of_part, of_run
from tissue_probe.diagnosis.fitting.search import promise, search
from tissue_probe.diagnosis.fitting.start_in_motion import search_other_starts
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.starts import (
    Values,
    extent,
    instants,
    start_values,
    with_instant,
)
from tissue_probe.physics.composition import Composition

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

#: How many of the instants that promise most are searched from.
FOLLOWED = 2


def of_specimen(composition: Composition, instrument: Instrument) -> list[str]:
    """Name the values of a model that are the same in every run and part."""
    own = of_run(composition) | of_part(composition) | {*instrument.of_run}
    return [name for name in composition.kernel.values if name not in own]


def carry_model(
    composition: Composition,
    named: Values,
    measurements: Sequence[Measurement],
    instrument: Instrument,
) -> Fit | None:
    """Take a model to other runs of the specimen; None where it diverges.

    Only the values of a run are fitted again: the states at its start, and phases and instants
    (``Effect.of_run``).

    Parameters
    ----------
    composition : Composition
        The model.
    named : mapping of str to float
        Its values, where it was fitted.
    measurements : sequence of Measurement
        Of the other runs.
    instrument : Instrument
        Constants of the rig with their tolerances.
    """
    held = {name: named[name] for name in of_specimen(composition, instrument)}
    problem = Problem(composition, measurements, instrument, held)
    best = None
    # A constant of the run is as in the other one, or where it would be without that.
    for known in (named, held) if instrument.of_run else (named,):
        values = start_values(problem, _with_nominal(problem, known), None, {})
        starts = [begun.mean for begun in problem.begin(values)]
        found = search_other_starts(problem, search(problem, values, starts))
        if found is not None and (best is None or found.cost < best.cost):
            best = found
    if best is not None:
        for number in range(problem.runs.count):
            for effect in composition.all_effects:
                best = _at_instants(problem, best, effect, number)
    return best


def _with_nominal(problem: Problem, known: Values) -> Values:
    """Return values, and of constants that are not among them the nominal ones."""
    constants = problem.instrument.constants
    nominal = zip(problem.runs.names, map(float, problem.nominal), strict=True)
    return {**{name: value for name, value in nominal if name in constants}, **known}


def _at_instants(problem: Problem, best: Fit, effect: Effect, number: int) -> Fit:
    """Search from other instants of an effect in a run too: no step is sure to lead to them."""
    if instants(effect):
        reach = extent(best, best.named(), effect)
        best = _from(problem, best, effect, number, effect.starts(reach))
        if effect.near:
            found = problem.runs.name_for_run(number, best.named())
            best = _from(problem, best, effect, number, effect.near(reach, found))
    return best


def _from(problem: Problem, best: Fit, effect: Effect, number: int, tried: Iterable[Values]) -> Fit:
    """Search from the most promising of other instants in a run; return the best."""
    every = [with_instant(problem, best.named(), effect, number, each) for each in tried]
    promises = [promise(problem, values, best.starts) for values in every]
    chosen = [every[place] for place in np.argsort(promises, kind="stable")[:FOLLOWED]]
    fits = [search(problem, values, best.starts) for values in chosen]
    return min([best, *filter(None, fits)], key=lambda fit: fit.cost)
