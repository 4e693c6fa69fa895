"""Records of a rigid probe whose encoder is noisy: what shakes the force is no effect.

The records are made by SciPy's integrators and closed forms alone.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tissue_probe as tp

RATE, STIFFNESS, DAMPING, MASS = 2000.0, 450.0, 4.0, 0.03
BRANCH, RELAXATION = 300.0, 2.0
FORCE_NOISE = 5e-3


def motion(time, frequency=15.0):
    """Depth [m], its speed and acceleration: pressed in within 0.3 s, and a sine about that."""
    p = np.clip(time / 0.3, 0.0, 1.0)
    pressed = p**3 * (10 - 15 * p + 6 * p**2), p**2 * (30 - 60 * p + 30 * p**2) / 0.3
    bent = p * (60 - 180 * p + 120 * p**2) / 0.3**2
    rate = 2.0 * np.pi * frequency
    wave, slope = 1.0 + 0.8 * np.sin(rate * time), 0.8 * rate * np.cos(rate * time)
    bend = -0.8 * rate**2 * np.sin(rate * time)
    depth = pressed[0] * wave
    speed = pressed[1] * wave + pressed[0] * slope
    return 1e-3 * np.array([depth, speed, bent * wave + 2 * pressed[1] * slope + pressed[0] * bend])


def record(seed, position_noise, relaxes=True):
    """Kelvin-Voigt tissue with a mass on it, and perhaps a Maxwell branch, of 2.5 s."""
    random, fine = np.random.default_rng(seed), np.arange(0.0, 2.5, 1e-4)
    depth, speed, acceleration = motion(fine)
    force = STIFFNESS * depth + DAMPING * speed + MASS * acceleration
    if relaxes:
        solution = solve_ivp(
            lambda t, e: np.interp(t, fine, speed) - RELAXATION * e,
            (0.0, fine[-1]), [0.0], t_eval=fine, rtol=1e-8, atol=1e-12, max_step=2e-3,
        )  # fmt: skip
        force += BRANCH * solution.y[0]
    every = round(1e4 / RATE)
    time = fine[::every]
    return {
        "t": time,
        "u": depth[::every] + position_noise * random.standard_normal(time.size),
        "F": force[::every] + FORCE_NOISE * random.standard_normal(time.size),
    }


@pytest.mark.battery
@pytest.mark.parametrize("position_noise", [2e-8, 3e-7])
def test_relaxation_alone_is_found_where_the_encoder_shakes_the_mass(position_noise):
    """The plain model has hardly a mass, so that only the right one tells of that noise."""
    first, second = (record(seed, position_noise) for seed in (11, 12))
    answer = tp.diagnose(first, validate=second, rig="rigid_probe").to_dict()
    assert answer["verdict"] in ("missing", "ambiguous")
    assert answer["effects"] == ["standard_linear_solid"]
    assert answer["carries_over"]
    values = answer["ladder"][-1]["parameters"]
    assert values["tip_mass"]["value"] == pytest.approx(MASS, rel=0.02)
    assert values["relaxing_stiffness"]["value"] == pytest.approx(BRANCH, rel=0.03)


def test_nothing_is_missing_in_a_sine_that_is_smoother_than_its_noise_lets_expect():
    first, second = (record(seed, 3e-7, relaxes=False) for seed in (13, 14))
    found = tp.diagnose(first, validate=second, rig="rigid_probe")
    answer = found.to_dict()
    assert (answer["verdict"], answer["effects"]) == ("adequate", [])
    assert "where the force that errors of the position make counts as noise" in found.text
    assert not [told for told in answer["findings"] if "disturbances" in told]


def test_noise_of_a_position_that_goes_by_steps_is_told_between_the_steps():
    """More than half of all windows have a step, which the force feels; the others tell the noise.

    The force is that of a solid that relaxes by a power of time between a hundredth of a second and
    a thousand: forty Maxwell branches.
    """
    random, time = np.random.default_rng(5), 0.15 * np.arange(180)
    corners = 2.4 + 2.7 * np.arange(9)
    depth = sum(2e-4 * np.clip((time - each) / 0.75, 0.0, 1.0) for each in corners)
    force, rates = 1000.0 * depth, np.geomspace(1e-3, 1e2, 40)
    for rate in rates:
        branch = np.zeros_like(time)
        for n in range(1, time.size):
            # Exact for a motion that is straight between two samples.
            forgotten, speed = np.exp(-0.15 * rate), (depth[n] - depth[n - 1]) / 0.15
            branch[n] = forgotten * branch[n - 1] + speed * (1.0 - forgotten) / rate
        force = force + 400.0 * rate**0.3 * branch
    read = {
        "t": time,
        "u": depth + 15e-6 * random.standard_normal(time.size),
        "F": force + 4e-3 * random.standard_normal(time.size),
    }
    answer = tp.diagnose(read, rig="rigid_probe", constants={"tip_mass": 0.0}).to_dict()
    assert answer["verdict"] in ("missing", "ambiguous")
    assert "relaxation" in (answer["family"], *[each["family"] for each in answer["ranking"][:1]])
