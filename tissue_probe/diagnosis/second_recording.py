"""Models tried on a second recording of the specimen, to which none of them is fitted.

Contents: how that recording is weighed, the models' errors on it, how likely it makes them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from tissue_probe.diagnosis.evidence.conclusion import Ladder, conclude_search
from tissue_probe.diagnosis.fitting.corners import without_corners
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.force_errors import feels_force
from tissue_probe.diagnosis.fitting.input_noise import with_input_noise
from tissue_probe.diagnosis.fitting.outliers import without_outliers
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.undecided_samples import without_undecided
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.noise import Noise
from tissue_probe.diagnosis.ranking.other_runs import carry_model, of_specimen
from tissue_probe.diagnosis.sharing import map_shared
from tissue_probe.physics.response import Fineness
from tissue_probe.signals import FloatArray, IntArray

#: Where the residual on a second recording is rougher than the noise of the first.
NOISIER = (
    "The noise of the second recording is {:.2g} times that of the first: the sensor, its wiring "
    "or its range may be another."
)
#: Models of several effects that are less probable than this are not tried on a second recording:
#: its error would have to be smaller by more than noise hides.
POSSIBLE = 1e-4
#: A model does not carry over that leaves this many times as much as it should on a second
#: recording, and its noise is another one from as many times on.
FAR_RATIO = 1.5


@dataclass(frozen=True)
class SecondRecording:
    """A second recording, and each model that was tried on it.

    Attributes
    ----------
    measurements : tuple of Measurement
        As the last model shows that they are to be weighed; empty without a second recording.
    moved : mapping of tuple of str to Fit or None
        Each model there, by the names of its effects; None where it diverges.
    instrument : Instrument
        Constants of the rig with their tolerances.
    """

    measurements: tuple[Measurement, ...]
    moved: Mapping[tuple[str, ...], Fit | None]
    instrument: Instrument

    @classmethod
    def of(
        cls, ladder: Ladder, given: Sequence[Measurement], instrument: Instrument
    ) -> SecondRecording:
        """Try the models of a ladder on other measurements, of which there may be none."""
        if not given:
            return cls((), {}, instrument)
        first = ladder.final.measurements
        # As the input goes on between samples of the first recording, it does in the second.
        alike = [replace(m, between=first[0].between, fineness=_finest(first)) for m in given]
        told = weigh_by_model(ladder.final, alike, instrument)
        tried = _list_tried(ladder)
        known = [*told, *(fit.composition for fit in tried)]
        found = map_shared(
            lambda fit: carry_model(fit.composition, fit.named(), told, instrument), tried, known
        )
        moved = {fit.composition.names: on for fit, on in zip(tried, found, strict=True)}
        return cls(tuple(told), moved, instrument)

    @property
    def errors(self) -> dict[tuple[str, ...], float]:
        """Error of each model [unit of the output], by the names of its effects."""
        return {names: fit.rmse if fit else math.inf for names, fit in self.moved.items()}

    @property
    def noise(self) -> float:
        """The noise over all measurements, with that of errors of the position; NaN if none.

        The excess of a fit has such errors, too, but those of its own measurements: a quicker
        motion has larger ones.
        """
        if not self.measurements:
            return math.nan
        counts = [int(np.sum(each.used)) for each in self.measurements]
        return math.sqrt(np.average([m.noise.power for m in self.measurements], weights=counts))

    def conclude_ladder(self, ladder: Ladder) -> Ladder:
        """Return the ladder with the verdict of both recordings.

        A model that diverges on the second one is none of those that it may make probable.
        """
        likely = {
            frozenset(fit.composition.names): _likelihood(fit, other, self.instrument)
            for fit in _list_tried(ladder)
            if (other := self.moved.get(fit.composition.names)) is not None
        }
        if not likely:
            return ladder
        # A model that errs more there than the plain one is not told by the first one alone.
        plain = self.errors[ladder.base.composition.names]
        better = {frozenset(n) for n, error in self.errors.items() if error <= plain}
        no_worse = {names: value for names, value in likely.items() if names in better}
        second = no_worse if len(no_worse) > 1 else likely
        again = conclude_search(ladder.base, ladder.ranking, ladder.steps, ladder.tried, second)
        return replace(again, curtailed=ladder.curtailed, revisions=ladder.revisions)

    def noisier(self, final: Fit) -> list[Finding]:
        """Tell where this recording has more noise of its own than those that were fitted."""
        times = max((each.noise.own / final.noise for each in self.measurements), default=0.0)
        return [Finding("noisier", NOISIER.format(times))] if times > FAR_RATIO else []

    def uncertainty(self, fit: Fit) -> float:
        """Return the error that the covariance of a model's values predicts here.

        To first order in the values' errors, and rms over all samples; 0 where the model diverges.
        """
        moved = self.moved.get(fit.composition.names)
        if moved is None:
            return 0.0
        _, by_value, held = _by_value(fit, moved, self.instrument)
        pairs = zip(by_value, moved.measurements, strict=True)
        used = np.concatenate([each[measurement.used] for each, measurement in pairs])
        squares = float(np.sum(used @ fit.covariance[np.ix_(held, held)] * used))
        return math.sqrt(max(squares, 0.0) / len(used))


def _list_tried(ladder: Ladder) -> list[Fit]:
    """Return the models that are told, and those that the recording might make probable."""
    pairs = zip(ladder.posterior.models, ladder.posterior.probabilities, strict=True)
    possible = [fit for fit, probability in pairs if probability > POSSIBLE]
    every = ladder.base, *ladder.steps, *ladder.ranking, *possible
    return list(dict.fromkeys(every))


def weigh_by_model(
    fit: Fit, measurements: Sequence[Measurement], instrument: Instrument
) -> Sequence[Measurement]:
    """Return other recordings of the specimen as the last model shows that they are to be weighed.

    As those that are fitted: with the noise that errors of the input make, and without the samples
    that no model follows there. All models are tried on the same samples. Where the last model
    diverges, it shows nothing.

    The instrument is the same: a driving force has the noise that it has in the first recordings,
    and the output no more than there, unless the residual has.
    """

    def transfer_fit(samples: Sequence[Measurement]) -> Fit | None:
        return carry_model(fit.composition, fit.named(), samples, instrument)

    of_force = float(np.fmax.reduce([each.input_noise for each in fit.measurements]))
    found = transfer_fit([replace(each, input_noise=of_force) for each in measurements])
    if found is None:
        return measurements
    quiet = [
        _as_quiet(each, residual, fit)
        for each, residual in zip(found.measurements, found.residuals, strict=True)
    ]
    found = replace(found, measurements=tuple(quiet))
    found = transfer_fit(with_input_noise(found, instrument)) or found
    undecided = partial(without_undecided, instrument=instrument)
    for without in (without_corners, undecided, without_outliers):
        kept = without(found)
        found = (transfer_fit(kept) if kept else found) or found
    return found.measurements


def _as_quiet(measurement: Measurement, residual: FloatArray, fit: Fit) -> Measurement:
    """Return another recording with no more noise than a fit leaves, unless its residual has more.

    A residual under a force that is noisy is rough for that.
    """
    if measurement.noise.own <= fit.noise:
        return measurement
    if feels_force(fit):
        return replace(measurement, noise=Noise(fit.noise))
    return measurement.within(residual)


def _finest(measurements: Sequence[Measurement]) -> Fineness:
    """Return the fineness that none of the measurements exceeds."""
    every = [each.fineness for each in measurements]
    return Fineness(max(each.degree for each in every), max(each.parts for each in every))


def _likelihood(fit: Fit, moved: Fit, instrument: Instrument) -> float:
    """Return the logarithm of the likelihood of other recordings; the noise's level is unknown.

    Over all values that the first recording leaves possible, to first order in their errors
    (D. MacKay, Neural Computation 4 (1992), 415, section 3). Values of a run are fitted again, and
    paid for as in the first recording: they make a model that has more of them no more probable.

    Parameters
    ----------
    fit : Fit
        The model as the first recording told it.
    moved : Fit
        The same on the other recordings.
    instrument : Instrument
        Constants of the rig with their tolerances.
    """
    problem, by_value, held = _by_value(fit, moved, instrument)
    weighed = [problem.weighed(index, each) for index, each in enumerate(by_value)]
    left = [problem.weighed(index, each) for index, each in enumerate(moved.residuals)]
    # Values are in units of their deviations: else the smallest would be lost beside the largest.
    deviation = np.sqrt(np.diag(fit.covariance)[held])
    scale = np.where(deviation > 0.0, deviation, 1.0)
    sizes, directions = np.linalg.eigh(fit.covariance[np.ix_(held, held)] / np.outer(scale, scale))
    root = (directions * np.sqrt(np.maximum(sizes, 0.0))).T * scale
    steps = np.concatenate(weighed) @ root.T
    steps = np.where(np.isfinite(steps), steps, 0.0)  # near a model that diverges none is known
    # By singular values: the normal equations of values that are hardly known would be singular.
    directions, sizes, _ = np.linalg.svd(steps, full_matrices=False)
    towards = directions.T @ np.concatenate(left)
    cost = moved.cost - float(np.sum(towards**2 * sizes**2 / (1.0 + sizes**2)))
    said = moved.samples * math.log(max(cost, float(np.finfo(float).tiny)))
    learnt = moved.unknowns * math.log(moved.samples) + float(np.sum(np.log1p(sizes**2)))
    return -0.5 * (said + learnt)


def _by_value(
    fit: Fit, moved: Fit, instrument: Instrument
) -> tuple[Problem, list[FloatArray], IntArray]:
    """Return the sensitivity of each other recording's output to values of the specimen.

    With the problem of these recordings, and the places of the values among all of the first.
    """
    held = np.flatnonzero(np.isin(fit.names, of_specimen(fit.composition, instrument)))
    problem = Problem(moved.composition, moved.measurements, instrument)
    simulated = problem.simulate(moved.values, moved.starts)
    return problem, [each[:, problem.states :][:, held] for _, each in simulated], held
