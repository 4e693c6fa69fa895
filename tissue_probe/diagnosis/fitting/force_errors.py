"""Noise of a force that drives, as it comes out in the position: slow, and no longer white.

Contents: its colour by a fitted model.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.observation.coloured_noise import Coloured
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.noise import faint
from tissue_probe.quantities import POSITION
from tissue_probe.signals import FloatArray

#: Coefficients of the autoregression; a second-order system under noise, read with noise, is one of
#: moving average too, which so many follow.
AUTOREGRESSION_ORDER = 24
#: Samples that are drawn for each coefficient: a filter that is learnt from so many leaves other
#: noise larger by a hundredth of its square.
SAMPLES_A_COEFFICIENT = 200


def feels_force(fit: Fit) -> bool:
    """Whether noise of a force that drives counts as noise of the output."""
    return fit.output is POSITION and fit.is_coloured


def filter_measurements(fit: Fit, instrument: Instrument) -> list[Measurement]:
    """Return the measurements of a fit, with filters for the noise in its model."""
    problem = Problem(fit.composition, fit.measurements, instrument)
    return [_estimate_force_noise(problem, fit, index) for index in range(len(fit.measurements))]


def _estimate_force_noise(problem: Problem, fit: Fit, index: int) -> Measurement:
    """Draw errors that the force's noise makes."""
    measurement = fit.measurements[index]
    force, noise = measurement.force, measurement.force_noise
    if not noise:
        return measurement
    random = np.random.default_rng(0)
    right = problem.response(index, force, fit.values, fit.starts[index]).output

    def draw_error() -> FloatArray:
        noisy = force + noise * random.standard_normal(force.size)
        return problem.response(index, noisy, fit.values, fit.starts[index]).output - right

    errors = [draw_error()]
    if faint(errors[0], measurement.noise):
        return measurement
    errors += [
        draw_error() for _ in range(SAMPLES_A_COEFFICIENT * AUTOREGRESSION_ORDER // force.size)
    ]
    return replace(
        measurement, noise=Coloured.of(errors, AUTOREGRESSION_ORDER, noise, measurement.noise.own)
    )
