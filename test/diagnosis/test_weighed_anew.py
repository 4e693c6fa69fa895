"""What the best model shows of the samples: which hang on noise, how much noise there is."""

import numpy as np
import pytest
from scipy.signal import cont2discrete, dlsim

import tissue_probe as tp

STIFFNESS, DAMPING, FRICTION, NOISE = 700.0, 34.0, 0.18, 0.01


def palpated(seed, position_noise, period=0.015, hand=1.3):
    """A hand's palpation of tissue that rubs, slow beside the samples, with a pause."""
    random, time = np.random.default_rng(seed), period * np.arange(1600)
    phase = 2.0 * np.pi * hand * np.where(time < 9.0, time, np.maximum(time - 3.0, 9.0))
    moving = (time < 9.0) | (time > 12.0)
    depth = 1e-3 * (1.0 - np.cos(phase) + 0.3 * np.sin(0.37 * phase))
    speed = 1e-3 * (np.sin(phase) + 0.111 * np.cos(0.37 * phase)) * 2.0 * np.pi * hand * moving
    force = STIFFNESS * depth + DAMPING * speed + FRICTION * np.sign(speed)
    return {
        "t": time,
        "u": depth + position_noise * random.standard_normal(time.size),
        "F": force + NOISE * random.standard_normal(time.size),
    }


def diagnosed(position_noise):
    first, second = (palpated(seed, position_noise) for seed in (1, 2))
    return tp.diagnose(
        first, validate=second, rig="rigid_probe", constants={"tip_mass": 0.0}
    ).to_dict()


@pytest.mark.battery
def test_friction_is_found_where_noise_hides_which_way_the_tip_moves():
    answer = diagnosed(position_noise=1.5e-6)
    assert (answer["verdict"], answer["effects"]) == ("missing", ["coulomb_friction"])
    (told,) = [each for each in answer["findings"] if "which way the tip moves" in each]
    assert "A finer encoder, or a quicker motion, tells more." in told
    values = answer["ladder"][-1]["parameters"]
    assert values["coulomb_force"]["value"] == pytest.approx(FRICTION, rel=0.03)
    assert values["damping"]["value"] == pytest.approx(DAMPING, rel=0.03)


def test_a_force_that_jumps_as_friction_does_is_no_noise():
    """Eleven samples between two turns: all windows of the noise floor, of twelve, have a jump."""
    time = 0.02 * np.arange(800)
    rate = 2.0 * np.pi * 2.33
    depth, speed = 1e-3 * np.sin(rate * time), 1e-3 * rate * np.cos(rate * time)
    random = np.random.default_rng(3)
    force = STIFFNESS * depth + 3.0 * speed + 0.06 * np.sign(speed)
    record = {"t": time, "u": depth, "F": force + 1.5e-3 * random.standard_normal(time.size)}
    answer = tp.diagnose(record, rig="rigid_probe", constants={"tip_mass": 0.0}).to_dict()
    assert (answer["verdict"], answer["effects"]) == ("missing", ["coulomb_friction"])
    assert answer["noise_floor"] == pytest.approx(1.5e-3, rel=0.1)


@pytest.mark.battery
@pytest.mark.parametrize("second", [False, True])
def test_a_value_that_one_part_alone_tells_asks_for_a_second_record(second):
    """A ramp, and a long hold: only the ramp has a speed."""
    time = 0.01 * np.arange(3000)
    depth = 1e-3 * np.clip(time / 2.0, 0.0, 1.0)
    force = STIFFNESS * depth + 300.0 * np.where(time < 2.0, 0.5e-3, 0.0)

    def record(seed):
        noise = 1e-3 * np.random.default_rng(seed).standard_normal(time.size)
        return {"t": time, "u": depth, "F": force + noise}

    answer = tp.diagnose(
        record(0),
        validate=record(1) if second else None,
        rig="rigid_probe",
        constants={"tip_mass": 0.0},
    ).to_dict()
    told = [each for each in answer["findings"] if "One part of the record alone tells" in each]
    assert bool(told) is not second
    assert all("damping" in each and "`validate`" in each for each in told)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.battery)])
def test_squares_so_quick_that_their_jumps_pass_for_noise_of_the_force_are_none(seed):
    random, period = np.random.default_rng(seed), 1e-3
    force = 2.0 * np.where((np.arange(1800) // 9 + np.arange(1800) // 23) % 2, 1.0, -1.0)
    mass, stiffness, damping = 0.15, 1400.0, 3.6
    held = cont2discrete(([1.0], [mass, damping, stiffness]), period)
    _, position = dlsim(held, force)
    noise = 3e-6 * random.standard_normal(force.size)
    table = {"t": period * np.arange(force.size), "u": position[:, 0] + noise, "F": force}
    found = tp.diagnose(table, rig="force_driven", starts="at-rest")
    assert found.verdict == "adequate"
