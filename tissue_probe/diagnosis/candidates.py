"""Every effect of the library, added to a fitted model and fitted in its turn.

What belongs here: where the search for each candidate begins, and the search.
What does not: comparing the candidates (``ranking``).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import product

import numpy as np

from tissue_probe.diagnosis.fit import Fit, Problem, promise, search
from tissue_probe.diagnosis.measurement import Instrument, Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import Effect, Extent
from tissue_probe.physics.effects.effect import TISSUE_FORCE
from tissue_probe.signals import FloatArray

#: How many of the proposed starts are followed to the end, and up to how much worse a promise.
FOLLOWED, WORSE = 3, 2.0
#: Two shared cores: compiled code runs beside the interpreter's lock.
THREADS = 2


def fit_base(
    composition: Composition, measurements: Sequence[Measurement], instrument: Instrument
) -> Fit:
    """Fit a model from its default values, from several stiffnesses.

    Raises
    ------
    ValueError
        If no start leads to a fit.
    """
    problem = Problem(composition, measurements, instrument)
    names = list(problem.kernel.VALUES)
    fits = []
    for stiffness in (300.0, 2000.0):
        values = problem.nominal.copy()
        values[names.index("stiffness")] = stiffness
        starts = [z for z, _ in problem.begin(values)]
        fits.append(search(problem, values, starts))
    found = [fit for fit in fits if fit is not None]
    if not found:
        raise ValueError(
            "no fit: the model diverges from every start; check the units and the force's polarity"
        )
    return min(found, key=lambda fit: fit.cost)


def fit_candidates(base: Fit, effects: Iterable[Effect], instrument: Instrument) -> list[Fit]:
    """Fit the model with each effect added; effects that cannot be fitted are left out."""
    wanted = [effect for effect in effects if effect.name not in base.composition.names]
    with ThreadPoolExecutor(THREADS) as pool:
        fits = list(pool.map(lambda effect: fit_candidate(base, effect, instrument), wanted))
    return [fit for fit in fits if fit is not None]


def fit_candidate(base: Fit, effect: Effect, instrument: Instrument) -> Fit | None:
    """Fit the model with one effect added, in the form of it that fits best."""
    fits = []
    for form in (replace(effect, forms=()), *effect.forms):
        fits.extend(_fit_form(base, form, instrument))
    return min(fits, key=lambda fit: fit.cost, default=None)


def _fit_form(base: Fit, effect: Effect, instrument: Instrument) -> list[Fit]:
    problem = Problem(base.composition.plus(effect), base.measurements, instrument)
    proposals = []
    begin = [base.named()]
    if effect.contact != TISSUE_FORCE:
        begin += _pressed(base, instrument)
    for known, proposed in product(begin, effect.starts(extent(base.measurements))):
        values = _values(problem, known, effect, proposed)
        starts = _starts(problem, base, values)
        promised, after, begun = promise(problem, values, starts)
        # A strength that was proposed stands for a nonlinear effect: one step may lead astray.
        direct = effect.parameters and effect.parameters[0].name in proposed
        proposals.append((promised, values if direct else after, starts if direct else begun))
    proposals.sort(key=lambda proposal: proposal[0])
    best = proposals[0][0]
    fits = [
        search(problem, values, starts)
        for promised, values, starts in proposals[:FOLLOWED]
        if promised <= WORSE * best
    ]
    found = [fit for fit in fits if fit is not None]
    if effect.near and found:
        best = min(found, key=lambda fit: fit.cost)
        found += _around(problem, best, effect)
    return found


def _around(problem: Problem, best: Fit, effect: Effect) -> list[Fit]:
    """Search again from the most promising of the values near those found."""
    own = {p.name for p in effect.parameters}
    proposals = []
    for proposed in effect.near(extent(best.measurements), best.named()):
        known = best.named() | {name: value for name, value in proposed.items() if name in own}
        values = np.clip(np.array(list(known.values())), problem.lower, problem.upper)
        proposals.append((promise(problem, values, best.starts)[0], values))
    proposals.sort(key=lambda proposal: proposal[0])
    fits = [search(problem, values, best.starts) for _, values in proposals[:2]]
    return [fit for fit in fits if fit is not None]


def extent(measurements: Sequence[Measurement]) -> Extent:
    """How far the longest measurement reaches."""
    return max((each.extent for each in measurements), key=lambda each: each.duration)


def _pressed(base: Fit, instrument: Instrument) -> list[dict[str, float]]:
    """Fit what is sure to be in contact only: elsewhere the base is wrong if contact is lost."""
    stiffness = base.named().get("load_cell_stiffness", np.inf)
    inside = [replace(m, used=m.pressed(stiffness)) for m in base.measurements]
    if min(np.mean(m.used) for m in inside) < 0.05:
        return []
    problem = Problem(base.composition, inside, instrument)
    fit = search(problem, base.values, base.starts)
    return [] if fit is None else [fit.named()]


def _values(
    problem: Problem, base: dict[str, float], effect: Effect, proposed: dict[str, float]
) -> FloatArray:
    strengths = {p.name: effect.neutral for p in effect.parameters[: effect.strengths]}
    known = base | strengths | dict(proposed)
    values = np.array([known.get(e.name, e.default) for e in problem.composition.values])
    return np.clip(values, problem.lower, problem.upper)


def _starts(problem: Problem, base: Fit, values: FloatArray) -> list[FloatArray]:
    known = [dict(zip(base.composition.kernel.STATES, start, strict=True)) for start in base.starts]
    return [
        np.array([of.get(name, at) for name, at in zip(problem.kernel.STATES, rest, strict=True)])
        for of, (rest, _) in zip(known, problem.begin(values), strict=True)
    ]
