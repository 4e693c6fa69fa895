"""The simulated probe obeys its equations, senses as its sensors do, and stops when told."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from reference_probe import integrate

from tissue_probe.devices import simulated
from tissue_probe.devices.device import DeviceError
from tissue_probe.devices.simulated import SimulatedProbe
from tissue_probe.devices.simulated_settings import SimulatedProbeSettings
from tissue_probe.excitation import Chirp, Multisine, Sine

ENCODER_STEP = 1e-7
FORCE_NOISE = 0.005
SILENCE = Sine(amplitude=0.0)
IN_TISSUE = -0.001  # z [m]


def largest_errors(probe, excitation, tissue, samples, z=IN_TISSUE):
    """Return the largest errors of position [m] and force [N] against the reference."""
    probe.place(0.0, 0.0, z)
    probe.start(excitation)
    taken = probe.read(samples)
    settings = probe._settings
    voltages = excitation(np.arange(samples) * probe.sample_period)
    position, force = integrate(settings, tissue, np.full(samples, -z), voltages)
    assert np.abs(position).max() > 1e-4
    return np.abs(taken.position - position).max(), np.abs(taken.force - force).max()


@pytest.mark.parametrize("rate", [500.0, 700.0, 2000.0, 10000.0])
def test_every_sample_rate_is_far_more_accurate_than_the_sensors(probe, rate):
    position, force = largest_errors(
        probe(exact=True, sample_rate=rate),
        Multisine(amplitude=1.0, start=5.0, stop=30.0, spacing=5.0),
        (450.0, 5.0),
        samples=int(0.1 * rate),
    )
    assert position < 0.02 * ENCODER_STEP
    assert force < 0.002 * FORCE_NOISE


@pytest.mark.parametrize(
    "settings",
    [
        {"coil_resistance": 50.0, "coil_inductance": 3e-4},
        {"load_cell_stiffness": 1e6, "tip_mass": 0.005},
        {"load_cell_damping": 100.0, "tip_mass": 0.01},
    ],
    ids=lambda settings: " ".join(settings),
)
def test_a_faster_probe_is_integrated_in_shorter_steps(probe, settings):
    position, force = largest_errors(
        probe(exact=True, **settings), Sine(amplitude=5.0, frequency=30.0), (450.0, 5.0), 40
    )
    assert position < 0.02 * ENCODER_STEP
    assert force < 0.02 * FORCE_NOISE


def test_halving_the_step_divides_the_error_by_sixteen(probe, monkeypatch):
    errors = []
    excitation = Sine(amplitude=1.0, frequency=30.0)
    for step in (0.8, 0.4, 0.2):
        monkeypatch.setattr(simulated, "STEP_OF_TIME_CONSTANT", step)
        # At a low rate there are so many steps in a sample that rounding them up matters little.
        device = probe(exact=True, sample_rate=500.0)
        errors.append(largest_errors(device, excitation, (450.0, 5.0), samples=50))
    falls = np.array(errors[:-1]) / np.array(errors[1:])
    assert falls == pytest.approx(np.full((2, 2), 16.0), rel=0.35)


def test_a_stage_that_moves_while_in_contact_indents_the_tissue_with_its_lag(probe):
    device = probe(exact=True)
    device.place(0.0, 0.0, -0.0005)
    excitation = Sine(amplitude=0.5)
    device.start(excitation)
    before = device.read(60)
    device.place(0.0, 0.0, -0.0015)
    after = device.read(140)
    depths = np.repeat([0.0005, 0.0015], [60, 140])
    voltages = excitation(np.arange(200) * 5e-4)
    position, force = integrate(device._settings, (450.0, 5.0), depths, voltages)
    assert np.r_[before.position, after.position] == pytest.approx(position, abs=1e-9)
    assert np.r_[before.force, after.force] == pytest.approx(force, abs=1e-5)


def test_in_free_air_the_load_cell_feels_the_tip_alone(probe):
    position, force = largest_errors(
        probe(exact=True), Sine(amplitude=0.85), (0.0, 0.0), samples=200, z=0.01
    )
    assert position < 0.02 * ENCODER_STEP
    assert force < 0.002 * FORCE_NOISE


def test_in_free_air_the_tissue_makes_no_difference(probe):
    taken = []
    for stiffness in (450.0, 40000.0):
        device = probe(stiffness, exact=True)
        device.place(0.0, 0.0, 0.001)
        device.start(Sine(amplitude=0.85))
        taken.append(device.read(300).position)
    # The steps of the integration differ with the stiffest tissue, and nothing else.
    assert taken[0] == pytest.approx(taken[1], abs=1e-9)


def test_the_stock_excitation_moves_the_coil_by_about_a_millimetre_on_soft_tissue(probe):
    device = probe(450.0, 5.0)
    device.place(0.0, 0.0, 0.0)
    device.start(Sine(amplitude=0.85, frequency=10.0))
    device.read(1000)
    last = device.read(2000).position  # ten whole periods
    amplitude = 2.0 * np.abs(np.fft.rfft(last)[10]) / 2000
    assert 0.8e-3 < amplitude < 1.2e-3


def test_the_command_is_the_excitation_at_the_time_of_each_sample(probe):
    device = probe(sample_rate=1000.0)
    excitation = Chirp(amplitude=0.7, start=2.0, stop=20.0, duration=0.8)
    device.start(excitation)
    commands = np.concatenate([device.read(count).command for count in (1, 1, 7, 500, 491)])
    assert commands == pytest.approx(excitation(np.arange(1000) * 1e-3), abs=1e-12)


def test_reading_in_blocks_of_any_size_gives_the_same_samples(probe):
    taken = []
    for counts in ((600,), (1,) * 600, (1, 199, 250, 150)):
        device = probe()
        device.place(0.0, 0.0, IN_TISSUE)
        device.start(Sine(amplitude=0.85))
        parts = [device.read(count) for count in counts]
        taken.append(
            [np.concatenate([getattr(p, n) for p in parts]) for n in ("position", "force")]
        )
    np.testing.assert_array_equal(taken[0], taken[1])
    np.testing.assert_array_equal(taken[0], taken[2])


def steady_force(device, z):
    """Return the force at rest after the stage went to z [m], with no excitation."""
    device.place(0.0, 0.0, z)
    device.read(3000)
    return device.read(1).force[0]


def static_force(depth, k=450.0, suspension=800.0, k0=9700.0):
    """Return k, the load cell and the suspension in series, times the indentation."""
    return depth / (1 / k + 1 / suspension + 1 / k0)


def test_suction_attaches_at_the_surface_and_lets_go_when_pulled(probe):
    device = probe(exact=True)
    device.place(0.0, 0.0, 0.01)
    device.start(SILENCE)
    for z, force in [
        (0.0001, 0.0),  # near, but not touching
        (0.0, 0.0),  # attached, at rest
        (-0.001, static_force(0.001)),
        (0.0004, static_force(-0.0004)),  # holds against the pull
        (0.0006, 0.0),  # let go
        (0.0001, 0.0),  # still free
        (-0.0005, static_force(0.0005)),  # attached again
    ]:
        assert steady_force(device, z) == pytest.approx(force, abs=1e-6), f"at z = {z} m"


def test_the_encoder_shows_whole_steps_nearest_to_the_position(probe):
    taken = []
    for resolution in (1e-5, 0.0):
        device = probe(force_noise=0.0, encoder_resolution=resolution)
        device.place(0.0, 0.0, IN_TISSUE)
        device.start(Sine(amplitude=0.85))
        taken.append(device.read(1000).position)
    shown, true = taken
    steps = shown / 1e-5
    assert steps == pytest.approx(np.round(steps), abs=1e-9)
    assert np.unique(np.round(steps)).size > 100
    assert np.abs(shown - true).max() == pytest.approx(0.5e-5, rel=0.1)
    assert np.abs(shown - true).max() <= 0.5e-5 * (1.0 + 1e-9)


@pytest.mark.parametrize("deviation", [0.005, 0.1])
def test_the_noise_of_the_force_is_white_and_as_strong_as_stated(probe, deviation):
    taken = []
    for noise in (deviation, 0.0):
        device = probe(force_noise=noise)
        device.start(Sine(amplitude=0.85))
        taken.append(device.read(20000).force)
    noise = taken[0] - taken[1]
    assert noise.std() == pytest.approx(deviation, rel=0.02)
    assert abs(noise.mean()) < 4.0 * deviation / np.sqrt(20000)
    neighbours = np.corrcoef(noise[1:], noise[:-1])[0, 1]
    assert abs(neighbours) < 4.0 / np.sqrt(20000)


def test_the_noise_is_the_same_for_the_same_seed_and_only_then(probe):
    taken = []
    for seed in (3, 3, 4):
        device = probe(seed=seed)
        device.start(SILENCE)
        taken.append(device.read(100).force)
    np.testing.assert_array_equal(taken[0], taken[1])
    assert not np.any(taken[0] == taken[2])


def test_a_second_start_begins_at_rest_again(probe):
    device = probe()
    device.place(0.0, 0.0, IN_TISSUE)
    device.start(Sine(amplitude=0.85))
    first = device.read(333)
    device.start(Sine(amplitude=0.85))
    again = device.read(333)
    np.testing.assert_array_equal(first.position, again.position)
    np.testing.assert_array_equal(first.force, again.force)


def test_the_tissue_is_that_of_the_phantom_under_the_probe():
    stock = SimulatedProbe(SimulatedProbeSettings(force_noise=0.0))
    forces = []
    for x, y in [(0.010, 0.031), (0.0, 0.0)]:  # over the shallow nodule, and far from all
        stock.place(x, y, 0.0)
        stock.start(SILENCE)
        forces.append(steady_force_at(stock, x, y, -0.001))
    phantom = stock._phantom
    expected = [static_force(0.001, phantom.stiffness(*at)) for at in [(0.010, 0.031), (0.0, 0.0)]]
    assert forces == pytest.approx(expected, rel=1e-3)
    assert forces[0] > 1.5 * forces[1]


def steady_force_at(device, x, y, z):
    device.place(x, y, z)
    device.read(3000)
    return device.read(1).force[0]


def test_samples_come_at_the_sample_rate_of_the_clock_and_never_drift(probe, clock):
    device = probe()
    assert device.sample_period == 0.0005
    device.start(SILENCE)
    begin = clock.now
    for number in range(5000):
        device.read(1)
        # A read returns when its sample is due; the time it takes itself is caught up.
        assert clock.now == pytest.approx(begin + number * 0.0005, abs=2e-4)
        clock.now += 1e-4


@pytest.mark.parametrize(
    ("rate", "nanoseconds"), [(2000, 500_000), (700, 1_428_571), (600, 1_666_667)]
)
def test_the_sample_period_is_a_whole_number_of_nanoseconds(probe, rate, nanoseconds):
    assert probe(sample_rate=rate).sample_period == nanoseconds / 1e9


def test_reading_before_the_start_is_refused(probe):
    with pytest.raises(DeviceError, match="start it before you read"):
        probe().read(1)


def test_reading_after_the_stop_is_refused(probe):
    device = probe()
    device.start(SILENCE)
    device.read(1)
    device.stop()
    with pytest.raises(DeviceError, match="start it before you read"):
        device.read(1)


def test_samples_that_wait_too_long_are_lost_and_that_is_said(probe, clock):
    device = probe()
    device.start(SILENCE)
    clock.now += 2.01
    with pytest.raises(DeviceError, match="samples are lost"):
        device.read(1)


def test_samples_that_wait_less_are_all_there(probe, clock):
    device = probe()
    device.place(0.0, 0.0, IN_TISSUE)
    device.start(Sine(amplitude=0.85))
    prompt = device.read(4000)
    device.start(Sine(amplitude=0.85))
    clock.now += 1.99
    late = [device.read(1) for _ in range(4000)]
    np.testing.assert_array_equal(prompt.force, np.concatenate([each.force for each in late]))
    assert device.worst_lateness == pytest.approx(1.99)
    assert device.worst_lateness == 0.0  # since last asked


def test_the_coil_is_at_zero_after_each_of_many_stops(probe):
    device = probe()
    device.stop()
    assert device.commanded_voltage == 0.0
    device.start(Sine(amplitude=0.85))
    device.read(30)
    assert device.commanded_voltage == pytest.approx(0.85 * np.sin(2 * np.pi * 10 * 29 * 5e-4))
    for _ in range(3):
        device.stop()
        assert device.commanded_voltage == 0.0
    device.close()
    assert device.commanded_voltage == 0.0


def test_no_command_follows_a_stop_that_comes_while_a_read_waits(probe, clock):
    device = probe()
    device.start(Sine(amplitude=0.85))
    device.read(30)
    clock.while_asleep = device.stop
    with pytest.raises(DeviceError, match="stopped while it was read"):
        device.read(1)
    assert device.commanded_voltage == 0.0


def test_a_probe_too_fast_to_simulate_is_refused_with_what_to_change(probe):
    with pytest.raises(DeviceError, match=r"time constant is 2e-07 s.*more mass") as raised:
        probe(tip_mass=1e-6)
    assert "1e-06 s" in str(raised.value)


def test_the_description_is_the_phantom_in_yaml(probe):
    description = yaml.safe_load(probe(321.0, 4.0).description)
    assert description["phantom"]["background_stiffness"] == 321.0
    assert description["phantom"]["background_damping"] == 4.0


def test_a_phantom_that_is_not_there_is_named(tmp_path):
    missing = tmp_path / "none.yaml"
    with pytest.raises(OSError, match=r"none\.yaml"):
        SimulatedProbe(SimulatedProbeSettings(phantom=str(missing)))


def test_a_table_made_elsewhere_is_felt_at_the_height_that_it_has(tmp_path):
    table = tmp_path / "felt.csv"
    table.write_text("x,y,z,k\n0,0,0.001,300\n0.04,0,0.001,700\n0,0.04,0.001,300\n")
    felt = SimulatedProbe(SimulatedProbeSettings(phantom=str(table), force_noise=0.0))
    for x, stiffness in [(0.01, 400.0), (0.02, 500.0)]:
        felt.place(x, 0.005, 0.001)  # on the surface: the tip takes hold
        felt.start(SILENCE)
        pressed = steady_force_at(felt, x, 0.005, 0.0)  # 1 mm below it
        assert pressed == pytest.approx(static_force(0.001, stiffness), rel=1e-3)
    felt.place(0.01, 0.005, 0.0015)
    felt.start(SILENCE)
    assert abs(felt.read(500).force).max() < 1e-9  # half a millimetre above it: nothing
