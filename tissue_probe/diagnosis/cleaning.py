"""Measurements made fit for a search: spoilt samples left out, noise and the air taken off.

Contents: which samples are left out or corrected before any model is fitted, and the sentences that
tell it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.fitting.problem import CONTACT_NAME
from tissue_probe.diagnosis.inspection.contact import touch_within
from tissue_probe.diagnosis.inspection.disturbances import bridge_disturbed
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.inspection.grating import REPEATS, repeats
from tissue_probe.diagnosis.inspection.inspection import inspect
from tissue_probe.diagnosis.inspection.touch import first_touch
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.motion import motion
from tissue_probe.diagnosis.observation.noise import UNKNOWN_NOISE
from tissue_probe.errors import MeasurementError
from tissue_probe.physics.kinds import LONGEST_DELAY
from tissue_probe.physics.rounding import COARSE_STEP, smooth_rounding
from tissue_probe.quantities import FORCE, POSITION
from tissue_probe.signals import BoolArray

#: Answers that are no models: causes that spoilt the samples.
SPOILING_CAUSES = ("adc_saturation", "stuck_samples")
#: Findings that a commanded force causes where it rests, and that are no faults of it.
CAUSED_BY_REST = tuple((name, FORCE.name) for name in (*SPOILING_CAUSES, "no_contact"))
#: Values that stand alone are left out of every fit besides, and where they drive, bridged.
DISTURBED = {"spikes": FORCE, "position_spikes": POSITION}
#: Where a record begins in the air.
BEGINS_IN_AIR = (
    "{}The tip is in the air before sample {}, and touches at about {:.4g} m: the samples before "
    "are left out, and contact_position is fitted.{}"
)
#: And where the force is not zero there.
ZERO_TAKEN_OFF = " The force there, {:.3g} N, is taken off: it is the zero."


def clean_measurements(
    measurements: Sequence[Measurement],
) -> tuple[list[Measurement], list[Finding]]:
    """Inspect measurements, leave spoilt samples out of the fit, and smooth the position.

    By its noise, or by the steps of a fine encoder.

    Raises
    ------
    MeasurementError
        If the samples are such that any fit would be worthless; says why, and the remedy.
    """
    inspected = [_inspect_measurement(each) for each in measurements]
    findings = [finding for each in inspected for finding in each]
    fatal = next((finding for finding in findings if finding.fatal), None)
    if fatal:
        raise MeasurementError(fatal.sentence)
    sound = map(_without_spoilt, measurements, inspected)
    return [_finely_read(each) for each in sound], findings


def from_touch(
    measurements: Sequence[Measurement], instrument: Instrument
) -> tuple[list[Measurement], Instrument, list[Finding]]:
    """Leave out the air before a first touch; where the tip touches is fitted then.

    The air tells the zero of the force: of a tissue that follows Hooke's law, another zero is
    another place of the touch. That place is known to the first of such records only: another
    specimen's surface lies elsewhere.
    """
    found, findings, places = [], [], []
    for each in measurements:
        touch = None
        if each.input is POSITION and CONTACT_NAME in instrument.constants:
            touch = first_touch(each.position, each.force, each.noise.own)
        if touch is None:
            found.append(each)
            continue
        pressed = each.since(touch.sample, instrument.rig)
        found.append(replace(pressed, force=pressed.force - touch.zero))
        places.append(touch.position)
        told = f"{each.source}: " if each.source else ""
        zero = ZERO_TAKEN_OFF.format(touch.zero) if touch.zero else ""
        sentence = BEGINS_IN_AIR.format(told, touch.sample, touch.position, zero)
        findings.append(Finding("touch", sentence))
    if places:
        constants = {**instrument.constants, CONTACT_NAME: (places[0], np.inf)}
        instrument = replace(instrument, constants=constants)
    return found, instrument, findings


def with_any_touch(measurements: Sequence[Measurement], instrument: Instrument) -> Instrument:
    """Return the instrument with the place of touch as free as the records leave it.

    That is where nobody has said where the position's zero is: anywhere, where the tip never leaves
    the tissue; else as far from zero as no force is felt. Where a force drives, the touch is where
    that force is zero, and the travel over the force says how far off that may be.
    """
    if not instrument.any_zero:
        return instrument
    if all(each.input is FORCE for each in measurements):
        touch = max((_touch_unloaded(each) for each in measurements), key=lambda told: told[1])
        return replace(instrument, constants={**instrument.constants, CONTACT_NAME: touch})
    if instrument.constants.get(CONTACT_NAME, (0.0, 0.0))[1] > 0.0:
        return instrument
    within = min(
        touch_within(each.position[each.used], each.force[each.used], each.noise.own)
        for each in measurements
    )
    if not np.isfinite(within):
        return replace(instrument, free_touch=True)
    return replace(instrument, constants={**instrument.constants, CONTACT_NAME: (0.0, within)})


def _touch_unloaded(measurement: Measurement) -> tuple[float, float]:
    """Return where a tip that a force drives may touch [m], and the standard deviation of that.

    It is the travel, and as many times longer as the force is larger than its range; anywhere,
    where the force does not change.
    """
    position, force = measurement.position, measurement.force
    loaded = float(np.max(np.abs(force)))
    times = max(1.0, loaded / np.ptp(force)) if np.ptp(force) > 0.0 else np.inf
    return float(np.mean(position)), float(np.ptp(position) * times)


def _inspect_measurement(measurement: Measurement) -> tuple[Finding, ...]:
    found = inspect(
        measurement.position,
        measurement.force,
        measurement.sample_period,
        times=measurement.scale.time,
        drives=measurement.input,
    ).findings
    if measurement.is_commanded:  # it rests where it is told to
        found = tuple(f for f in found if (f.name, f.channel) not in CAUSED_BY_REST)
    told = f"{measurement.source}: " if measurement.source else ""
    return tuple(replace(finding, sentence=f"{told}{finding.sentence}") for finding in found)


def _without_spoilt(measurement: Measurement, findings: Sequence[Finding]) -> Measurement:
    """Leave the clipped, the repeated and the disturbed samples out of the fit.

    Where a motion goes on, the first values of a late channel belong to the time before the record.
    """
    driven = [name for name, channel in DISTURBED.items() if channel is measurement.input]
    spoilt = [name for name in (*SPOILING_CAUSES, *DISTURBED) if name not in driven]
    used = _outside(findings, spoilt, measurement.force.size)
    if not measurement.at_rest:
        latest = LONGEST_DELAY * measurement.scale.time
        used[: round(latest / measurement.sample_period)] = False
    steady = _outside(findings, driven, used.size)
    if steady.all() and used.all():
        return measurement
    # A spike of the input would move the tip, and a force's spike ever after: it is bridged.
    driven_by = bridge_disturbed(measurement.input_values, steady)
    force, position = measurement.force, measurement.position
    if measurement.input is FORCE:
        force = driven_by
    else:
        position = driven_by
    # The noise is estimated anew: where samples repeat there seems to be none.
    return replace(
        measurement,
        position=position,
        force=force,
        used=used & measurement.used,
        noise=UNKNOWN_NOISE,
    )


def _outside(findings: Sequence[Finding], names: Sequence[str], size: int) -> BoolArray:
    """Which samples none of these findings concerns."""
    outside = np.ones(size, dtype=bool)
    for finding in findings:
        if finding.name in names:
            for first, stop in finding.spans:
                outside[first:stop] = False
    return outside


def _finely_read(measurement: Measurement) -> Measurement:
    """Take the noise, or the rounding of a fine encoder, out of a position that drives.

    A record that begins at rest stays as it was read: there the errors differ from period to
    period, and smoothing would bend the beginning. A coarse step is for the effects to explain,
    and where a force drives, rounding is part of the noise.
    """
    if measurement.input is FORCE or measurement.at is not None:
        return measurement
    if noise := measurement.position_noise:
        told = motion(measurement.position, noise)
        same = repeats(measurement.position, told.position, measurement.scale.length)
        if same < REPEATS:  # an error of the encoder's is for an effect to explain
            return replace(measurement, position=told.position, motion=told)
    step = measurement.extent.step
    if measurement.at_rest or not 0.0 < step <= COARSE_STEP * measurement.scale.length:
        return measurement
    read = smooth_rounding(measurement.position, step, fine=True)
    return replace(measurement, position=read.course, misread=read.error)
