"""Noise that a model shows to be less than it was taken for.

What belongs here: telling it anew by the best model. What does not: how much less there must be
(``evidence.adequacy``), the noise as the channels alone tell it (``residuals.noise_floor``).

The noise of a channel is told from its roughness. A force that jumps between two samples, as dry
friction does where the motion turns, is rough too. And an error of the position shakes the force by
the damping, of which a model that lacks an effect has a wrong value. The residual of a model that
has the effect is the noise alone.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.fitting.shaken import shaken

#: Share of the noise's square below which it is less: above, an estimate errs by as much.
LESS = 0.5


def quieter(fit: Fit, instrument: Instrument) -> list[Measurement] | None:
    """Return the measurements of a fit with the noise that it leaves; None where it is as much."""
    if any(each.shaken is not None for each in fit.measurements):
        told = shaken(fit, instrument)
    else:
        pairs = zip(fit.measurements, fit.residuals, strict=True)
        told = [measurement.with_noise_of(residual) for measurement, residual in pairs]
    pairs = zip(told, fit.measurements, strict=True)
    return told if any(_size(new) ** 2 < LESS * _size(old) ** 2 for new, old in pairs) else None


def _size(measurement: Measurement) -> float:
    """Return how large the noise is: white noise, or the force that an error of 1 m shakes up."""
    if measurement.shaken is None:
        return measurement.noise
    return float(np.linalg.norm(measurement.shaken.taps))
