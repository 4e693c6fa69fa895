"""Noise that a model shows to be less than it was taken for, or more.

What belongs here: telling it anew by the best model. What does not: whether a fit leaves less than
its noise (``evidence.adequacy``), the noise as the channels alone tell it
(``residuals.noise_floor``).

The noise of a channel is told from its roughness. A force that jumps between two samples, as dry
friction does where the motion turns, is rough too. And an error of the position shakes the force by
damping and mass, of which a model that lacks an effect has wrong values. The residual of a model
that has the effect is the noise alone, and what errors of the position make in it is as they do.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.fitting.shaken import shaken
from tissue_probe.signals import FloatArray

#: Share of the noise's square below which it is less: above, an estimate errs by as much.
LESS = 0.5
#: Share of the noise's square by which it must be more: as much makes no residual larger by more
#: than a twentieth, and so nothing that is explained unexplained.
MORE = 0.1


def quieter(fit: Fit, instrument: Instrument) -> list[Measurement] | None:
    """Return the measurements of a fit with the noise that it leaves; None where it is as much."""
    told = _told(fit, instrument)
    pairs = zip(told, fit.measurements, strict=True)
    return told if any(_power(new) < LESS * _power(old) for new, old in pairs) else None


def louder(fit: Fit, instrument: Instrument) -> list[Measurement] | None:
    """Return the measurements of a fit with the noise that errors of the position make in it.

    None where that is hardly more than was counted.
    """
    if all(each.motion is None for each in fit.measurements):
        return None
    told = _told(fit, instrument)
    pairs = zip(told, fit.measurements, strict=True)
    return told if any(_power(new) > (1.0 + MORE) * _power(old) for new, old in pairs) else None


def _told(fit: Fit, instrument: Instrument) -> list[Measurement]:
    """Return the measurements with the noise that a fit tells.

    What errors of the position make is told from how the motion changes from sample to sample. A
    motion that changes less at random than that, such as a sine, has smaller errors: no larger than
    the residual has them.
    """
    pairs = zip(shaken(fit, instrument), fit.residuals, strict=True)
    return [_no_more(measurement, residual) for measurement, residual in pairs]


def _no_more(measurement: Measurement, residual: FloatArray) -> Measurement:
    """Return a measurement whose noise is no more than a residual."""
    beyond = float(np.mean(residual[measurement.counted] ** 2)) - measurement.noise**2
    if measurement.shaken is None or beyond <= 0.0:
        return replace(measurement.with_noise_of(residual), shaken=None)
    share = min(np.sqrt(beyond) / measurement.shaken.size, 1.0)
    return replace(measurement, shaken=measurement.shaken.times(share))


def _power(measurement: Measurement) -> float:
    """Return the square of all noise in the output: its own, and of errors of the position."""
    by_position = measurement.shaken.size if measurement.shaken is not None else 0.0
    return measurement.noise**2 + by_position**2
