"""Volts and counts of a recording, from nothing but the recording; and SI units by another file."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from tissue_probe.analysis.raw import find_calibration, raw_counts, raw_volts, recalibrate
from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration, Tare
from tissue_probe.signals import Recording, SampleBlock

OLD = Calibration.load(stock_configuration("calibration.yaml"))
NEW = OLD.changed(
    force_per_volt=2.2, force_offset_volts=0.1, force_polarity="tension", position_per_count=2e-7
)
START = 1_000_000_000
VOLTS = np.array([0.3, 0.5, 0.9, 0.4, 0.5])
COUNTS = np.array([0, 10, -20, 30, 5])
#: Sample 3 is the first one after a tare at 0.4 V.
TARED = OLD.changed(tares=(Tare(stamp=START + 3_000_000, force=float(OLD.force(0.4))),))


def recorded(calibration: Calibration) -> Recording:
    """Five samples, 1 ms apart, in two blocks, as a driver with this calibration publishes them."""
    stamps = START + 1_000_000 * np.arange(5)
    force = calibration.force(VOLTS, calibration.tare_at(stamps))
    position, command = calibration.position(COUNTS), np.zeros(5)
    blocks = tuple(
        SampleBlock(START + 1_000_000 * first, first, 1e-3, position[s], force[s], command[s])
        for first, s in ((0, slice(0, 2)), (2, slice(2, 5)))
    )
    text = yaml.safe_dump(calibration.text)
    return Recording(blocks, metadata={"/probe/ekf": {}, "/probe/driver": {"calibration": text}})


@pytest.mark.parametrize("calibration", [OLD, NEW, TARED])
def test_volts_and_counts_come_back(calibration):
    recording = recorded(calibration)
    assert find_calibration(recording) == calibration
    assert raw_volts(recording) == pytest.approx(VOLTS)
    assert raw_counts(recording) == pytest.approx(COUNTS)


def test_another_calibration_gives_what_the_driver_would_have_published_with_it():
    again = recalibrate(recorded(OLD), NEW)
    assert again.force == pytest.approx(NEW.force(VOLTS))
    assert again.position == pytest.approx(NEW.position(COUNTS))


def test_what_was_tared_off_stays_off():
    again = recalibrate(recorded(TARED), NEW)
    assert again.force[:3] == pytest.approx(NEW.force(VOLTS[:3]))
    assert again.force[3:] == pytest.approx([0.0, -0.22])


def test_a_recording_without_calibration_is_told():
    with pytest.raises(ValueError, match="has no calibration"):
        raw_volts(Recording(recorded(OLD).blocks))
