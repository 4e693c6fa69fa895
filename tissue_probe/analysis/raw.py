"""The volts and counts behind a recording, by the calibration that is in it."""

from __future__ import annotations

from dataclasses import replace

from tissue_probe.alignment import Alignment
from tissue_probe.analysis.recorded_facts import metadata_value
from tissue_probe.devices.calibration import Calibration, Tare
from tissue_probe.settings import SettingsError
from tissue_probe.signals import FloatArray, Recording, SampleBlock


def find_calibration(recording: Recording) -> Calibration:
    """Return the calibration by which the recording's volts and counts became SI units.

    Raises
    ------
    ValueError
        If the recording has none that can be read.
    """
    for parameters in recording.metadata.values():
        text = metadata_value(parameters.get("calibration"))
        if isinstance(text, str) and text:
            try:
                return Calibration.parse(text)
            except SettingsError as error:
                raise ValueError(f"the recording's calibration cannot be read: {error}") from None
    raise ValueError("the recording has no calibration: it cannot be read in volts and counts")


def raw_volts(recording: Recording) -> FloatArray:
    """Return the load cell's volts at each sample, shape (n,)."""
    return _volts(find_calibration(recording), recording)


def raw_counts(recording: Recording) -> FloatArray:
    """Return the encoder's counts at each sample, shape (n,).

    Whole numbers but for rounding, where no delay was taken out and no position interpolated.
    """
    return find_calibration(recording).counts(recording.position)


def recalibrate(recording: Recording, calibration: Calibration) -> Recording:
    """Return the recording in SI units by another calibration.

    The zero tared off in the run is the same number of volts in both. The force's delay that the
    driver took out by the former calibration is taken out by the other one instead.
    """
    before = find_calibration(recording)
    tares = [
        Tare(stamp=tare.stamp, force=float(calibration.force(before.volts(tare.force))))
        for tare in before.tares
    ]
    after = calibration.changed(tares=tares)
    return replace(
        recording, blocks=tuple(_scale_block(b, before, after) for b in recording.blocks)
    )


def _scale_block(block: SampleBlock, before: Calibration, after: Calibration) -> SampleBlock:
    more = (after.force_delay - before.force_delay) / block.sample_period
    position, force = Alignment(more).apply(
        after.position(before.counts(block.position)),
        after.force(_volts(before, block), after.tare_at(block.stamps)),
    )
    return replace(block, position=position, force=force)


def _volts(calibration: Calibration, samples: Recording | SampleBlock) -> FloatArray:
    return calibration.volts(samples.force, calibration.tare_at(samples.stamps))
