"""Which effects promise something beside those that a model already has.

Contents: a score of effects that does without composing them with the model, whose code would have
to be generated and compiled for every pair.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.sensitivities import by_unknown, precision, stack_parts, unknown
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidates import forms
from tissue_probe.diagnosis.ranking.starts import begin_states, extent, start_values
from tissue_probe.diagnosis.sharing import map_shared
from tissue_probe.physics.composition import Composition
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect


class Promise(NamedTuple):
    """The lower cost that an effect, in one form of it, promises beside a fitted model.

    Attributes
    ----------
    effect : Effect
        In the form that promises most.
    cost : float
        The cost that it promises.
    """

    effect: Effect
    cost: float


def screen_effects(
    pairs: Iterable[tuple[Fit, Iterable[Effect]]], alone: Composition, instrument: Instrument
) -> list[list[Promise]]:
    """Return the promises of effects, each in its best form, beside fitted models, the best first.

    The force that an effect adds is computed from the model without the others, at the fitted
    values; the part of it that the fitted model's own parameters and starts can make is projected
    out, and the remainder is compared with the residual (a score test).

    Parameters
    ----------
    pairs : iterable of (Fit, iterable of Effect)
        Models as they are, and the effects that may be added to each.
    alone : Composition
        The model to which effects are added one at a time, such as the base of a ladder.
    instrument : Instrument
        Constants of the rig with their tolerances.
    """
    pairs = [(fit, _list_tried(fit, alone, effects)) for fit, effects in pairs]
    tests = [_tests(fit, alone, tried, instrument) for fit, tried in pairs]
    jobs = [
        (test, form)
        for (_, tried), own in zip(pairs, tests, strict=True)
        for test, form in zip(own, tried, strict=True)
    ]
    scores = iter(map_shared(lambda job: job[0].score(job[1]), jobs))
    return [_order_promises(fit, [(form, next(scores)) for form in tried]) for fit, tried in pairs]


def _list_tried(fit: Fit, alone: Composition, effects: Iterable[Effect]) -> list[Effect]:
    return forms(alone, [effect for effect in effects if effect.name not in fit.composition.names])


def _order_promises(fit: Fit, scores: Iterable[tuple[Effect, float]]) -> list[Promise]:
    """Return the best form of each effect, the most promising first.

    Of forms with more values than others these have to be paid for, by the criterion of fits.
    """
    promises = [Promise(form, max(fit.cost - score, 0.0)) for form, score in scores]
    best: dict[str, Promise] = {}
    for promise in sorted(promises, key=lambda each: _criterion(fit, each)):
        best.setdefault(promise.effect.name, promise)
    return sorted(best.values(), key=lambda each: each.cost)


def _criterion(fit: Fit, promise: Promise) -> float:
    """Return minus twice the logarithm of how probable a form is, of forms of one effect."""
    samples = float(fit.samples)
    left = max(promise.cost, np.finfo(float).tiny)
    return float(samples * np.log(left) + len(promise.effect.parameters) * np.log(samples))


def _tests(
    fit: Fit, alone: Composition, tried: Iterable[Effect], instrument: Instrument
) -> list[_ScoreTest]:
    """Return the test for each effect: in all samples where the position is corrected, else few."""
    corrects = fit.composition.kernel.corrects
    exactly = [corrects or alone.plus(form).kernel.corrects for form in tried]
    few = [measurement.thin_samples() for measurement in fit.measurements]
    tests = {
        each: _ScoreTest(fit, alone, fit.measurements if each else few, instrument)
        for each in set(exactly)
    }
    return [tests[each] for each in exactly]


class _ScoreTest:
    """The residual of a fitted model at some samples, less the part its own unknowns can make."""

    def __init__(
        self,
        fit: Fit,
        alone: Composition,
        measurements: Sequence[Measurement],
        instrument: Instrument,
    ) -> None:
        self.fit, self.alone, self.instrument = fit, alone, instrument
        self.measurements = measurements
        with np.errstate(all="ignore"):  # a value beyond all bounds is left out
            own, residual = _own(fit, Problem(fit.composition, measurements, instrument))
            without = Problem(alone, measurements, instrument)
            plain = start_values(without, fit.named(), None, {})
            self.bare = _residuals(without, plain, begin_states(without, fit, plain))
        self.basis = np.linalg.qr(own)[0]
        self.residual = residual - self.basis @ (self.basis.T @ residual)
        #: Samples that each of these stands for.
        self.share = fit.samples / sum(int(np.sum(each.used)) for each in measurements)

    def score(self, form: Effect) -> float:
        """Return the sum of squares of all samples that an effect could explain."""
        problem = Problem(self.alone.plus(form), self.measurements, self.instrument)
        changes = _changes(self.fit, problem, form, self.bare)
        explained = (_sum_explained(change, self.basis, self.residual) for change in changes)
        return self.share * max(explained, default=0.0)


def _sum_explained(change: FloatArray, basis: FloatArray, residual: FloatArray) -> float:
    """Sum of squares of the residual that a change of the force could explain.

    The effect has no part in the last rows of basis and residual: those of the priors.
    """
    if not np.isfinite(change).all():
        return 0.0
    change = np.pad(change, ((0, residual.size - len(change)), (0, 0)))
    change = change - basis @ (basis.T @ change)
    size = np.linalg.norm(change, axis=0)
    change = change[:, size > 0] / size[size > 0]
    weights = np.linalg.lstsq(change, residual, rcond=1e-8)[0]
    return float(np.sum((change @ weights) ** 2))


def _changes(fit: Fit, problem: Problem, effect: Effect, bare: FloatArray) -> Iterator[FloatArray]:
    """Yield the forces that the effect's strengths add, over the noise, for each start.

    ``bare`` is the residual without the effect.
    """
    strengths = [entry.name for entry in effect.parameters[: effect.strengths]]
    strong = [meaning in strengths for meaning in problem.runs.meanings]
    columns = np.flatnonzero(strong) + problem.states
    for proposed in effect.starts(extent(fit, fit.named(), effect)):
        values = start_values(problem, fit.named(), effect, proposed)
        starts = begin_states(problem, fit, values)
        with np.errstate(all="ignore"):
            if not strengths or strengths[0] in proposed:
                yield (bare - _residuals(problem, values, starts))[:, None]
            else:
                yield stack_parts(
                    problem, [s[:, columns] for _, s in problem.simulate(values, starts)]
                )


def _residuals(problem: Problem, values: FloatArray, starts: Sequence[FloatArray]) -> FloatArray:
    parts = [residual[:, None] for residual, _ in problem.simulate(values, starts)]
    return stack_parts(problem, parts)[:, 0]


def _own(fit: Fit, problem: Problem) -> tuple[FloatArray, FloatArray]:
    """Return the sensitivities of the fitted model's unknowns, and its residual, over noise.

    Below stand their changes and departures over their prior deviations, without which
    any tolerance of the rig would make up for an effect.
    """
    free = unknown(problem)
    own = by_unknown(problem, fit.values, fit.starts)
    prior = np.sqrt(precision(problem, fit.values))
    known = np.isfinite(prior)
    below = np.diag(np.where(known, prior, 0.0))
    departure = np.where(known, prior * _departure(problem, fit), 0.0)
    used = free & np.isfinite(own).all(axis=0) & np.any(own != 0.0, axis=0)
    own = np.concatenate([own, below])[:, used]
    residual = _residuals(problem, fit.values, fit.starts)
    return own / np.linalg.norm(own, axis=0), np.concatenate([residual, departure])


def _departure(problem: Problem, fit: Fit) -> FloatArray:
    """Return by how much each unknown is below the mean of its prior."""
    expected = [begun.mean for begun in problem.begin(fit.values)]
    return np.concatenate([problem.nominal - fit.values, *expected - np.array(fit.starts)])
