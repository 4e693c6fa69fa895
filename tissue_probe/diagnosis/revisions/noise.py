"""Noise that a model shows to be less than it was taken for, or more.

What belongs here: telling it anew by a fit. What does not: whether a fit leaves less than
its noise (``evidence.adequacy``), the noise as the channels alone tell it
(``residuals.noise_floor``).

The noise of a channel is told from its roughness. A force that jumps between two samples, as dry
friction does where the motion turns, is rough too. And an error of the position shakes the force by
damping and mass, of which a model that lacks an effect has wrong values. The residual of a model
that has the effect is the noise alone, and errors of the position shake it as they shake the probe.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.evidence.adequacy import explained
from tissue_probe.diagnosis.fitting.coloured import filtered
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.search import search
from tissue_probe.diagnosis.fitting.shaken import shaken
from tissue_probe.diagnosis.fitting.whitening import Whitening
from tissue_probe.quantities import FORCE
from tissue_probe.signals import FloatArray

#: Share of the noise's square by which it must be another: as much makes no residual larger by more
#: than a twentieth, and so nothing that is explained unexplained.
ANOTHER = 0.1


def quieter(fit: Fit, instrument: Instrument, least: bool = False) -> list[Measurement] | None:
    """Return the measurements of a fit with the noise that it leaves; None where it is as much.

    The fit leaves less than its noise, so that no more than noise is in its residual: errors of the
    position are as small as that for every model.

    Parameters
    ----------
    fit : Fit
        Leaves less than its noise.
    instrument : Instrument
        What is known of the rig.
    least : bool
        Whether the fit may lack an effect. Its residual has the colour of its resonance then, too,
        so that it cannot tell that noise of a driving force has it: there is none of that.
    """
    shaken_by = shaken(fit, instrument)
    told = [_within(*each, least) for each in zip(shaken_by, fit.residuals, strict=True)]
    pairs = zip(told, fit.measurements, strict=True)
    if not any(new.noise_power < (1.0 - ANOTHER) * old.noise_power for new, old in pairs):
        return None
    return [_surer(new, old) for new, old in zip(told, shaken_by, strict=True)]


def louder(fit: Fit, instrument: Instrument) -> list[Measurement] | None:
    """Return the measurements of a fit with the errors of the input that it feels.

    None where they make no more noise than is counted. Noise of a force that drives is as large as
    the residual lets it be, and counts only where all of that is noise then.
    """
    if fit.composition.input is FORCE:
        return _driven_louder(fit, instrument)
    if all(each.motion is None for each in fit.measurements):
        return None
    shaken_by = shaken(fit, instrument)
    told = [_within(*each) for each in zip(shaken_by, fit.residuals, strict=True)]
    pairs = zip(told, fit.measurements, strict=True)
    more = any(new.noise_power > (1.0 + ANOTHER) * old.noise_power for new, old in pairs)
    return told if more else None


def _driven_louder(fit: Fit, instrument: Instrument) -> list[Measurement] | None:
    bounded = [replace(each, input_noise=np.nan, whitening=None) for each in fit.measurements]
    coloured = filtered(replace(fit, measurements=tuple(bounded)), instrument)
    told = [_within(*each) for each in zip(coloured, fit.residuals, strict=True)]
    pairs = zip(told, fit.measurements, strict=True)
    if not any(new.noise_power > (1.0 + ANOTHER) * old.noise_power for new, old in pairs):
        return None
    found = search(Problem(fit.composition, told, instrument), fit.values, fit.starts)
    return told if found is not None and explained(found) else None


def _within(measurement: Measurement, residual: FloatArray, least: bool = False) -> Measurement:
    """Return a measurement whose noise is no more than a residual.

    The noise that errors of the position make is told from how the motion changes from sample to
    sample. A motion that changes less at random than that, such as a sine, has smaller errors.
    """
    if measurement.whitening is not None:
        return _with_less_colour(measurement, measurement.whitening, residual, least)
    beyond = float(np.mean(residual[measurement.counted] ** 2)) - measurement.noise**2
    if measurement.shaken is None or beyond <= 0.0:
        return replace(measurement.with_noise_of(residual), shaken=None)
    share = min(np.sqrt(beyond) / measurement.shaken.size, 1.0)
    return replace(measurement, shaken=measurement.shaken.times(share))


def _with_less_colour(
    measurement: Measurement, whitening: Whitening, residual: FloatArray, least: bool
) -> Measurement:
    """Return a measurement whose residual has less of the driving force's noise, or none of it.

    Whichever makes the residual likelier.
    """
    found = None if least else whitening.likeliest(residual, measurement.used)
    if found is None or not found.force:
        return replace(measurement.with_noise_of(residual), whitening=None, input_noise=0.0)
    return replace(measurement, whitening=found, noise=found.own, input_noise=found.force)


def _surer(measurement: Measurement, before: Measurement) -> Measurement:
    """Return a measurement whose motion errs as little as its noise shows."""
    if measurement.motion is None or before.shaken is None:
        return measurement
    left = measurement.shaken.size if measurement.shaken is not None else 0.0
    share = left / before.shaken.size
    return replace(measurement, motion=measurement.motion.surer(share))
