"""Noise that a model shows to be less than it was taken for, or more.

What belongs here: telling it anew by the best model. What does not: whether a fit leaves less than
its noise (``evidence.adequacy``), the noise as the channels alone tell it
(``residuals.noise_floor``).

The noise of a channel is told from its roughness. A force that jumps between two samples, as dry
friction does where the motion turns, is rough too. And an error of the position shakes the force by
damping and mass, of which a model that lacks an effect has wrong values. The residual of a model
that has the effect is the noise alone, and errors of the position shake it as they shake the probe.
"""

from __future__ import annotations

from collections.abc import Sequence
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
    return told if _is_less(told, fit) else None


def anew(fit: Fit, instrument: Instrument, quiet: bool) -> list[Measurement] | None:
    """Return the measurements of a fit with the noise that it tells; None where it is as much.

    It may be more where errors of the position count, and less where the fit is ``quiet``.
    """
    moving = any(each.motion is not None for each in fit.measurements)
    if not moving and not quiet:
        return None
    told = _told(fit, instrument)
    return told if (moving and _is_more(told, fit)) or (quiet and _is_less(told, fit)) else None


def _is_less(told: Sequence[Measurement], fit: Fit) -> bool:
    pairs = zip(told, fit.measurements, strict=True)
    return any(new.noise_power < LESS * old.noise_power for new, old in pairs)


def _is_more(told: Sequence[Measurement], fit: Fit) -> bool:
    pairs = zip(told, fit.measurements, strict=True)
    return any(new.noise_power > (1.0 + MORE) * old.noise_power for new, old in pairs)


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
