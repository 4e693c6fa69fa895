"""Noise of a force that drives, as it comes out in the position: slow, and no longer white.

What belongs here: its colour by a fitted model, and the filter that takes the colour out again.
What does not: the fit (``search``), how white noise is estimated (``residuals``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.search import search
from tissue_probe.diagnosis.fitting.shaken import FAINT, felt, no_louder, shaken
from tissue_probe.diagnosis.fitting.whitening import Whitening
from tissue_probe.quantities import FORCE
from tissue_probe.signals import FloatArray

#: Coefficients of the autoregression; a second-order system under noise, read with noise, is one of
#: moving average too, which so many follow.
ORDER = 24
#: Samples that are drawn for each coefficient: a filter that is learnt from so many leaves other
#: noise larger by a hundredth of its square.
LEARNT = 200


def whitened(fit: Fit, instrument: Instrument, held: Mapping[str, float] | None = None) -> Fit:
    """Fit again with the noise that the driving force leaves, if it is seen and not known yet.

    Least squares on residuals that are white is what the criteria of ``ranking`` suppose: effects
    would else follow the slow wanderings of a tip that is shaken by noise. What compares with this
    fit takes its measurements, and so the same filter.

    Parameters
    ----------
    fit : Fit
        A model's first fit.
    instrument, held
        As for ``Problem``.
    """
    if any(m.whitening is not None or m.shaken is not None for m in fit.measurements):
        return fit
    if fit.composition.input is not FORCE:
        return _steadied(fit, instrument, held)
    return _again(fit, filtered(fit, instrument), instrument, held)


def with_input_noise(fit: Fit, instrument: Instrument) -> list[Measurement]:
    """Return the measurements of a fit with the noise that errors of what drives it make."""
    of_force = fit.composition.input is FORCE
    return filtered(fit, instrument) if of_force else shaken(fit, instrument)


def _steadied(fit: Fit, instrument: Instrument, held: Mapping[str, float] | None) -> Fit:
    """Fit again with the noise that a noisy position leaves, and what the output tells of it."""
    if all(m.motion is None for m in fit.measurements):
        return fit
    seen = _again(fit, shaken(fit, instrument), instrument, held)
    told = _again(seen, felt(seen), instrument, held)
    known = _again(told, shaken(told, instrument), instrument, held)
    return _again(known, no_louder(known), instrument, held)


def _again(
    fit: Fit,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    held: Mapping[str, float] | None,
) -> Fit:
    """Fit the model to the same measurements, of which something else is known now."""
    if all(new is old for new, old in zip(measurements, fit.measurements, strict=True)):
        return fit
    problem = Problem(fit.composition, measurements, instrument, held)
    return search(problem, fit.values, fit.starts) or fit


def filtered(fit: Fit, instrument: Instrument) -> list[Measurement]:
    """Return the measurements of a fit, with filters for the noise in its model."""
    problem = Problem(fit.composition, fit.measurements, instrument)
    return [_filtered(problem, fit, index) for index in range(len(fit.measurements))]


def _filtered(problem: Problem, fit: Fit, index: int) -> Measurement:
    """Draw errors that the force's noise makes."""
    measurement = fit.measurements[index]
    force, noise = measurement.force, measurement.force_noise
    if not noise:
        return measurement
    random = np.random.default_rng(0)
    right = problem.response(index, force, fit.values, fit.starts[index]).output

    def drawn() -> FloatArray:
        noisy = force + noise * random.standard_normal(force.size)
        return problem.response(index, noisy, fit.values, fit.starts[index]).output - right

    errors = [drawn()]
    if not np.sqrt(np.mean(errors[0] ** 2)) > FAINT * measurement.noise:
        return measurement
    errors += [drawn() for _ in range(LEARNT * ORDER // force.size)]
    whitening = Whitening.of(errors, ORDER, noise, measurement.noise)
    return replace(measurement, whitening=whitening)
