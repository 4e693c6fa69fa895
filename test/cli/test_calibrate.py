"""Each step of a calibration, from recordings to the file that the driver loads."""

from __future__ import annotations

import datetime

import numpy as np
import pytest
import yaml

from tissue_probe.devices.calibration import Calibration
from tissue_probe.identification.ring_down import ring_down
from tissue_probe.signals import SampleBlock

PERIOD = 5e-4
START = 1_700_000_000_000_000_000
GRAVITY = 9.80665
#: A cell whose voltage falls under load, and an encoder that counts out of the tissue.
TRUE = {
    "force_per_volt": 1.93,
    "force_offset_volts": 0.21,
    "force_polarity": "tension",
    "position_per_count": -1.02e-7,
}


@pytest.fixture
def true(nominal) -> Calibration:
    return nominal.changed(**TRUE)


@pytest.fixture
def nominal() -> Calibration:
    from tissue_probe.configuration import stock_configuration

    return Calibration.load(stock_configuration("calibration.yaml"))


@pytest.fixture
def recorded(tmp_path, messages, record, nominal):
    """Write raw volts and counts to a bag, as a driver with that calibration does."""

    def write(name, volts, counts, calibration=nominal):
        volts, counts = np.broadcast_arrays(volts, counts)
        position, force = calibration.position(counts), calibration.force(volts)
        block = SampleBlock(START, 0, PERIOD, position, force, np.zeros(force.size))
        text = yaml.safe_dump(calibration.text)
        entries = [("/probe/samples", messages.SAMPLES, START, messages.samples(block))]
        return record(tmp_path / name, entries, {"/probe/driver": {"calibration": text}})

    return write


def file(tmp_path) -> Calibration:
    return Calibration.load(tmp_path / "calibration.yaml")


def noise(seed: int, size: int = 1000) -> np.ndarray:
    return 0.003 * np.random.default_rng(seed).standard_normal(size)


def test_known_weights_give_gain_zero_and_polarity(run, tmp_path, recorded, true):
    masses = [0.0, 0.1, 0.2, 0.5, -0.1]
    weights = [
        f"{mass}={recorded(f'{mass}.mcap', true.volts(mass * GRAVITY) + noise(seed), 0.0)}"
        for seed, mass in enumerate(masses)
    ]
    outcome = run("calibrate", "force", *weights[:4], "--instrument", "load cell=LCL-005 no. 7")
    assert outcome.status == 0, outcome.err
    found = file(tmp_path)
    assert found.force_per_volt == pytest.approx(1.93, rel=0.002)
    assert found.force_offset_volts == pytest.approx(0.21, abs=0.001)
    assert found.force_polarity == "tension"
    low, high = found.intervals["force_per_volt"]
    assert low < found.force_per_volt < high
    assert high - low < 0.02
    assert found.instruments == {"load cell": "LCL-005 no. 7"}
    assert found.date == datetime.date.today()
    assert "force_per_volt = 1.9" in outcome.out
    assert "[N/V]" in outcome.out


def test_volts_may_come_from_tables(run, tmp_path, true):
    for mass in (0.0, 0.1, 0.2):
        volts = true.volts(mass * GRAVITY) + noise(3, 50)
        rows = np.column_stack([np.arange(50) * 0.01, volts])
        np.savetxt(tmp_path / f"{mass}.csv", rows, delimiter=",", header="t,V", comments="")
    run("calibrate", "force", *(f"{m}={tmp_path / f'{m}.csv'}" for m in (0.0, 0.1, 0.2)))
    assert file(tmp_path).force_per_volt == pytest.approx(1.93, rel=0.01)


def test_a_known_travel_gives_the_encoders_step_and_direction(run, tmp_path, recorded, true):
    readings = [
        f"{travel}={recorded(f'{travel}.mcap', 0.0, np.rint(true.counts(travel)) + np.arange(3))}"
        for travel in (0.0, 0.001, 0.002, 0.004)
    ]
    outcome = run("calibrate", "position", *readings)
    assert outcome.status == 0, outcome.err
    assert file(tmp_path).position_per_count == pytest.approx(-1.02e-7, rel=1e-3)


@pytest.mark.drawn
def test_an_impulse_gives_the_tool_with_intervals_and_a_picture(run, tmp_path, recorded, true):
    time = np.arange(1800) * PERIOD
    force = np.concatenate([np.zeros(200), ring_down(time, 9500.0, 0.9, 0.041, 8e-3)])
    path = recorded("impulse.mcap", true.volts(force) + noise(5, 2000) / 2, 0.0)
    outcome = run("calibrate", "tool", path, "--tip-mass", 0.041, "--tip-mass-error", 0.0001)
    assert outcome.status == 0, outcome.err
    found = file(tmp_path)
    low, high = found.intervals["load_cell_stiffness"]
    assert low < 9500.0 < high
    assert high - low < 150.0
    low, high = found.intervals["load_cell_damping"]
    assert low < 0.9 < high
    assert found.tip_mass == 0.041
    assert found.intervals["tip_mass"] == pytest.approx((0.040804, 0.041196))
    assert "Resonance: 76.6" in outcome.out
    assert (tmp_path / "ring_down.png").read_bytes().startswith(b"\x89PNG")


def in_free_air(nominal, delay: float = 0.0, seconds: float = 10.0):
    """Position [m] and force [N] of the nominal tool, driven at 12 and 20 Hz."""
    time = np.arange(round(seconds / PERIOD)) * PERIOD
    position, force = np.zeros(time.size), np.zeros(time.size)
    for frequency, amplitude in ((12.0, 5e-4), (20.0, 2e-4)):
        s = 2.0j * np.pi * frequency
        m, k0, beta0 = nominal.tip_mass, nominal.load_cell_stiffness, nominal.load_cell_damping
        position += amplitude * np.sin(s.imag * time)
        ratio = k0 * m * s**2 / (m * s**2 + beta0 * s + k0)
        force += amplitude * (ratio * np.exp(s * (time - delay))).imag
    return position, force


def test_the_delay_of_the_force_is_found(run, tmp_path, recorded, nominal):
    position, force = in_free_air(nominal, delay=2e-4)
    path = recorded(
        "air.mcap", nominal.volts(force) + noise(1, force.size), nominal.counts(position)
    )
    assert run("calibrate", "delay", path).status == 0
    found = file(tmp_path)
    assert found.force_delay == pytest.approx(2e-4, abs=1e-5)
    low, high = found.intervals["force_delay"]
    assert low < 2e-4 < high


def test_a_delay_that_was_taken_out_already_counts(run, tmp_path, recorded, nominal):
    """The driver left 0.05 ms of it by what the file had, and the recording says so."""
    known = nominal.changed(force_delay=1.5e-4)
    known.save(tmp_path / "calibration.yaml")
    position, force = in_free_air(nominal, delay=5e-5)
    path = recorded("air.mcap", nominal.volts(force), nominal.counts(position), known)
    assert run("calibrate", "delay", path).status == 0
    assert file(tmp_path).force_delay == pytest.approx(2e-4, abs=1e-5)
    # Whatever the file had meanwhile, the recording tells what was taken out of it.
    nominal.save(tmp_path / "calibration.yaml")
    assert run("calibrate", "delay", path).status == 0
    assert file(tmp_path).force_delay == pytest.approx(2e-4, abs=1e-5)


def test_a_run_in_free_air_gives_the_volts_without_load(run, tmp_path, recorded, nominal):
    position, force = in_free_air(nominal, seconds=2.0)
    path = recorded("air.mcap", 0.13 + nominal.volts(force), nominal.counts(position))
    assert run("calibrate", "tare", path).status == 0
    assert file(tmp_path).force_offset_volts == pytest.approx(0.13, abs=0.002)


def test_a_tare_in_contact_is_refused_and_no_file_is_made(fails, tmp_path, recorded, nominal):
    position, force = in_free_air(nominal, seconds=2.0)
    on_tissue = nominal.volts(force + 450.0 * position)
    path = recorded("contact.mcap", on_tissue, nominal.counts(position))
    assert "the probe is in contact" in fails("calibrate", "tare", path)
    assert not (tmp_path / "calibration.yaml").exists()


@pytest.mark.parametrize("stiffness", [0.0, 200.0])
def test_a_tare_judges_contact_by_the_file_not_by_what_the_driver_had(
    run, tmp_path, recorded, nominal, true, stiffness
):
    """The nominal calibration in the bag has the opposite polarity and direction."""
    true.save(tmp_path / "calibration.yaml")
    position, force = in_free_air(nominal, seconds=2.0)
    volts, counts = true.volts(force + stiffness * position + 0.5), true.counts(position)
    outcome = run("calibrate", "tare", recorded("run.mcap", volts, counts))
    assert outcome.status == (1 if stiffness else 0), outcome.err
    expected = true.force_offset_volts if stiffness else float(true.volts(0.5))
    assert file(tmp_path).force_offset_volts == pytest.approx(expected, abs=0.002)


def test_the_delay_is_found_by_the_file_not_by_what_the_driver_had(
    run, tmp_path, recorded, nominal, true
):
    true.changed(position_per_count=1e-7).save(tmp_path / "calibration.yaml")
    position, force = in_free_air(nominal, delay=2e-4)
    path = recorded("air.mcap", true.volts(force), position / 1e-7)
    outcome = run("calibrate", "delay", path)
    assert outcome.status == 0, outcome.err
    assert file(tmp_path).force_delay == pytest.approx(2e-4, abs=1e-5)


def test_steps_update_one_file_and_keep_what_the_others_found(run, tmp_path, recorded, nominal):
    nominal.changed(
        force_offset_volts=0.5,
        intervals={"force_offset_volts": (0.4, 0.6), "tip_mass": (0.039, 0.041)},
        instruments={"encoder": "LIDA 47"},
    ).save(tmp_path / "calibration.yaml")
    position, force = in_free_air(nominal, seconds=2.0)
    path = recorded("air.mcap", 0.13 + nominal.volts(force), nominal.counts(position))
    run("calibrate", "tare", path)
    found = file(tmp_path)
    assert found.instruments == {"encoder": "LIDA 47"}
    # The zero is another one now: its old interval went with it.
    assert found.intervals == {"tip_mass": (0.039, 0.041)}


def test_export_reads_a_recording_again_by_another_calibration(run, tmp_path, recorded, true):
    volts, counts = np.array([0.1, 0.4, -0.2]), np.array([5.0, -7.0, 100.0])
    path = recorded("run.mcap", volts, counts)
    true.save(tmp_path / "better.yaml")
    assert run("export", path, "--calibration", tmp_path / "better.yaml").status == 0
    table = np.genfromtxt(tmp_path / "samples.csv", delimiter=",", names=True)
    assert table["force"] == pytest.approx(true.force(volts))
    assert table["position"] == pytest.approx(true.position(counts))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["force", "0.1"], "0.1: write KNOWN=SAMPLES, such as 0.1=hundred_grams.mcap"),
        (["force", "heavy=x.mcap"], "heavy=x.mcap: write KNOWN=SAMPLES"),
        (["force", "0={bag}", "0.1={bag}"], "there are 2 readings: give at least 3"),
        (["force", "0={bag}", "1={bag}", "2={bag}"], "do not follow the known values"),
        (["tool", "{bag}", "--tip-mass", "0.04"], "strike the tip once, in free air"),
        (["delay", "{bag}"], "the run is too short: record 5 s or more"),
        (["delay", "none.mcap"], "none.mcap: No such file or directory"),
    ],
)
def test_what_cannot_be_calibrated_is_told_in_one_line(fails, recorded, arguments, said):
    path = recorded("still.mcap", noise(1, 100), 0.0)
    assert said in fails("calibrate", *(each.format(bag=path) for each in arguments))


def test_an_instrument_without_a_serial_is_told(fails, recorded, nominal):
    position, force = in_free_air(nominal)
    path = recorded("air.mcap", nominal.volts(force), nominal.counts(position))
    said = fails("calibrate", "delay", path, "--instrument", "DAQ")
    assert "--instrument DAQ: write NAME=SERIAL" in said
