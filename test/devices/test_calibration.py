"""Volts and counts to SI units and back, and the file that says how."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration, Tare
from tissue_probe.settings import SettingsError

STOCK = Calibration.load(stock_configuration("calibration.yaml"))
MEASURED = STOCK.changed(
    instruments={"load cell": "LCL-005 no. 1234"},
    force_per_volt=1.987654321,
    force_offset_volts=-0.0123,
    force_polarity="tension",
    position_per_count=-9.98e-8,
    intervals={"force_per_volt": (1.98, 1.99), "load_cell_stiffness": (9650.0, 9750.0)},
)


def test_the_stock_calibration_is_the_papers():
    assert STOCK.force(0.5) == 1.0
    assert (STOCK.load_cell_stiffness, STOCK.load_cell_damping, STOCK.tip_mass) == (9700, 0.8, 0.04)


def test_a_cell_of_tension_polarity_gives_forces_positive_in_compression():
    """Its voltage falls when it is compressed."""
    assert MEASURED.force(MEASURED.force_offset_volts - 0.1) == pytest.approx(0.1987654321)


def test_an_encoder_that_counts_out_of_the_tissue_gives_positions_positive_into_it():
    assert MEASURED.position(-1000) == pytest.approx(9.98e-5)


@pytest.mark.parametrize("calibration", [STOCK, MEASURED])
@given(volts=st.floats(-10.0, 10.0), counts=st.integers(-100_000, 100_000))
def test_volts_and_counts_survive_the_way_to_si_units_and_back(calibration, volts, counts):
    assert calibration.volts(calibration.force(volts)) == pytest.approx(volts, abs=1e-12)
    assert round(float(calibration.counts(calibration.position(counts)))) == counts


def test_a_file_keeps_every_digit(tmp_path):
    MEASURED.save(tmp_path / "calibration.yaml")
    assert Calibration.load(tmp_path / "calibration.yaml") == MEASURED
    assert Calibration.parse(MEASURED.text) == MEASURED


def test_a_tare_holds_from_its_stamp_on():
    tared = STOCK.changed(tares=(Tare(stamp=100, force=0.5), Tare(stamp=300, force=-0.1)))
    stamps = np.array([99, 100, 299, 300, 500])
    assert tared.tare_at(stamps).tolist() == [0.0, 0.5, 0.5, -0.1, -0.1]
    volts = np.full(5, 1.25)
    force = tared.force(volts, tared.tare_at(stamps))
    assert force.tolist() == [2.5, 2.0, 2.0, 2.6, 2.6]
    assert tared.volts(force, tared.tare_at(stamps)) == pytest.approx(volts)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"force_per_volt": 0.0}, "force_per_volt is 0.0: give a number above 0 [N/V]"),
        ({"force_polarity": "up"}, "force_polarity is 'up': give one of compression, tension"),
        ({"position_per_count": 0.0}, "position_per_count is 0 m: give the displacement"),
        ({"tip_mass": float("nan")}, "tip_mass is nan: give a number above 0 [kg]"),
        ({"intervals": {"colour": (0, 1)}}, "'colour', which is no quantity of a calibration"),
        ({"intervals": {"tip_mass": (2, 1)}}, "the interval of tip_mass ends before it begins"),
        ({"gain": 2.0}, "there is no gain; there are date, instruments, force_per_volt"),
    ],
)
def test_a_wrong_value_is_told_in_one_sentence(change, said):
    with pytest.raises(SettingsError) as error:
        STOCK.changed(**change)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "no calibration: give one 'name: value' a line"),
        (b"date: [", "not YAML"),
        (b"date: 2026-11-20\n", "force_per_volt is missing: give a number above 0 [N/V]"),
        (b"\xff", "no UTF-8"),
    ],
)
def test_a_file_that_is_no_calibration_is_told_by_name(content, said, tmp_path):
    path = tmp_path / "probe.yaml"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"probe\.yaml") as error:
        Calibration.load(path)
    assert said in str(error.value)
