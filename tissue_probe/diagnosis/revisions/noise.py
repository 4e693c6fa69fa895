"""Noise that a model shows to be less than it was taken for, or more.

Contents: telling it anew by a fit.

The noise of a channel is told from its roughness. A force that jumps between two samples, as dry
friction does where the motion turns, is rough too. And an error of the position shakes the force by
damping and mass, of which a model that lacks an effect has wrong values. The residual of a model
that has the effect is the noise alone, and errors of the position shake it as they shake the probe.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.evidence.adequacy import leaves_only_noise
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.force_errors import filter_measurements
from tissue_probe.diagnosis.fitting.position_errors import add_position_noise
from tissue_probe.diagnosis.fitting.refit_samples import refit_measurements
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.noise import Noise
from tissue_probe.quantities import FORCE

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
        Constants of the rig with their tolerances.
    least : bool
        Whether the fit may lack an effect. Its residual has the colour of its resonance then, too,
        so that it cannot tell that noise of a driving force has it: there is none of that.
    """
    shaken_by = add_position_noise(fit, instrument)
    told = _within(shaken_by, fit, colour=not least)
    pairs = zip(told, fit.measurements, strict=True)
    if not any(new.noise.power < (1.0 - ANOTHER) * old.noise.power for new, old in pairs):
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
    shaken_by = add_position_noise(fit, instrument)
    told = _within(shaken_by, fit)
    return told if _is_more(told, fit) else None


def _driven_louder(fit: Fit, instrument: Instrument) -> list[Measurement] | None:
    bounded = [
        replace(each, input_noise=np.nan, noise=Noise(each.noise.own)) for each in fit.measurements
    ]
    told = _within(filter_measurements(replace(fit, measurements=tuple(bounded)), instrument), fit)
    if not _is_more(told, fit):
        return None
    found = refit_measurements(fit, told, instrument)
    return told if found is not None and leaves_only_noise(found) else None


def _within(
    measurements: Sequence[Measurement], fit: Fit, colour: bool = True
) -> list[Measurement]:
    """Return measurements with no more noise than a fit leaves."""
    pairs = zip(measurements, fit.residuals, strict=True)
    return [each.within(residual, colour) for each, residual in pairs]


def _is_more(told: Sequence[Measurement], fit: Fit) -> bool:
    """Whether measurements have more noise than those of a fit."""
    pairs = zip(told, fit.measurements, strict=True)
    return any(new.noise.power > (1.0 + ANOTHER) * old.noise.power for new, old in pairs)


def _surer(measurement: Measurement, before: Measurement) -> Measurement:
    """Return a measurement whose motion errs as little as its noise shows."""
    if measurement.motion is None or not before.noise.by_input:
        return measurement
    share = measurement.noise.by_input / before.noise.by_input
    return replace(measurement, motion=measurement.motion.surer(share))
