"""What errors of a noisy position leave in the output of a model that it drives.

What belongs here: how large these are at each sample. What does not: the motion (``motion``), noise
of a force that drives (``coloured``).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.signals import FloatArray

#: So many errors are drawn, and those of so many neighbours count together: 24 squares have a mean
#: that is right to a third, as the strength of the motion is told.
DRAWS, NEIGHBOURS = 8, 3


def shaken(fit: Fit, instrument: Instrument) -> list[Measurement]:
    """Return the measurements of a fit with the errors that noise of the position leaves in each.

    Errors of the position are drawn as the samples leave them possible, and the model is run with
    each.
    """
    problem = Problem(fit.composition, fit.measurements, instrument)
    return [
        each if each.motion is None else replace(each, shaken=_shaken(problem, fit, index))
        for index, each in enumerate(fit.measurements)
    ]


def _shaken(problem: Problem, fit: Fit, index: int) -> FloatArray:
    """Return the standard deviation of the output's error at each sample [its unit]."""
    measurement, random = fit.measurements[index], np.random.default_rng(0)
    position, squares = measurement.position, np.zeros(measurement.position.size)
    right = problem.response(index, position, fit.values, fit.starts[index]).output
    for _ in range(DRAWS):
        wrong = position + measurement.motion.error(random)
        output = problem.response(index, wrong, fit.values, fit.starts[index]).output
        squares += (output - right) ** 2
    finite = np.where(np.isfinite(squares), squares / DRAWS, np.inf)
    return np.sqrt(uniform_filter1d(finite, NEIGHBOURS, mode="nearest"))
