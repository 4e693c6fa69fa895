"""Samples of the output that hang on the noise of the position, as a model switches with it.

Contents: finding them by the model itself, driven by positions that are as likely as the one it
has.

Dry friction turns with the direction of the motion. Where the tip hardly moves, the noise of the
position hides which way: the force of friction is then known but for its sign.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import binary_dilation

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.motion import MotionEstimate
from tissue_probe.signals import BoolArray

#: Errors drawn: a sample that switches in a fifth of them is found in 97 of 100 cases.
ERRORS_DRAWN = 16
#: A change of the output stands out by so many times the usual change: of normal errors one in
#: 15,000.
CHANGE_STANDS_OUT = 4.0
#: Share of the samples that are left out at the most: the others must tell the tissue.
MOST_LEFT_OUT = 0.5


def without_undecided(fit: Fit, instrument: Instrument) -> list[Measurement] | None:
    """Return the measurements of a fit without such samples; None where there are none."""
    return fit.without(find_undecided(fit, instrument), MOST_LEFT_OUT)


def find_undecided(fit: Fit, instrument: Instrument) -> list[BoolArray]:
    """Return which samples of each measurement are such: none without an effect that switches."""
    found = [np.zeros(each.position.size, dtype=bool) for each in fit.measurements]
    if not any(effect.drag != 0 for effect in fit.composition.effects):
        return found
    problem = Problem(fit.composition, fit.measurements, instrument)
    for index, each in enumerate(fit.measurements):
        if each.motion is not None:
            found[index] = _find_undecided_samples(problem, fit, index, each.motion)
    return found


def _find_undecided_samples(
    problem: Problem, fit: Fit, index: int, motion: MotionEstimate
) -> BoolArray:
    """Return the samples whose output changes far more than usual with the position's noise.

    Errors are as large as the samples leave them possible: that they are smaller elsewhere tells
    nothing of where the tip hardly moves.
    """
    measurement, possible = fit.measurements[index], replace(motion, share=1.0)
    position, random = measurement.position, np.random.default_rng(0)
    values, start = fit.values, fit.starts[index]
    right = problem.response(index, position, values, start).output
    errors = (possible.error(random) for _ in range(ERRORS_DRAWN))
    changes = np.abs(
        [problem.response(index, position + each, values, start).output - right for each in errors]
    )
    usual = np.hypot(np.quantile(changes, 0.68), measurement.noise.own)
    found: BoolArray = binary_dilation(changes.max(axis=0) > CHANGE_STANDS_OUT * usual)
    return found
