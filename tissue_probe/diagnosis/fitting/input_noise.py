"""Noise of the input, as a fitted model leaves it in the output: a fit is made again with it.

Contents: when a fit is made again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.force_errors import filter_measurements
from tissue_probe.diagnosis.fitting.position_errors import (
    add_position_noise,
    estimate_motions,
    no_louder,
)
from tissue_probe.diagnosis.fitting.refit_samples import refit_measurements
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.quantities import FORCE


def whiten_input_noise(
    fit: Fit, instrument: Instrument, held: Mapping[str, float] | None = None
) -> Fit:
    """Fit again with the noise that the driving force leaves, if it is seen and not known yet.

    The criteria of ``ranking`` suppose least squares on white residuals: effects would else follow
    the slow wanderings of a tip that is shaken by noise. A fit that is compared with this one takes
    its measurements, and so the same filter.

    Parameters
    ----------
    fit : Fit
        A model's first fit.
    instrument, held
        As for ``Problem``.
    """
    if fit.is_coloured:
        return fit
    if fit.composition.input is not FORCE:
        return _fit_position_noise(fit, instrument, held)
    return _fit_again(fit, filter_measurements(fit, instrument), instrument, held)


def with_input_noise(fit: Fit, instrument: Instrument) -> list[Measurement]:
    """Return the measurements of a fit with the noise that errors of the input make."""
    of_force = fit.composition.input is FORCE
    return filter_measurements(fit, instrument) if of_force else add_position_noise(fit, instrument)


def _fit_position_noise(fit: Fit, instrument: Instrument, held: Mapping[str, float] | None) -> Fit:
    """Fit again with the noise that a noisy position leaves, estimated from the output, too."""
    if all(m.motion is None for m in fit.measurements):
        return fit
    seen = _fit_again(fit, add_position_noise(fit, instrument), instrument, held)
    told = _fit_again(seen, estimate_motions(seen), instrument, held)
    known = _fit_again(told, add_position_noise(told, instrument), instrument, held)
    return _fit_again(known, no_louder(known), instrument, held)


def _fit_again(
    fit: Fit,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    held: Mapping[str, float] | None,
) -> Fit:
    """Fit the model to the same measurements, of which something else is known now."""
    if all(new is old for new, old in zip(measurements, fit.measurements, strict=True)):
        return fit
    return refit_measurements(fit, measurements, instrument, held) or fit
