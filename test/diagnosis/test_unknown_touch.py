"""Where the tip touches first is known only as well as the samples tell it."""

import numpy as np
import pytest

import tissue_probe as tp

pytestmark = pytest.mark.timeout(900)

NOISE = 4e-3
STATED = {"rig": "rigid_probe", "constants": {"tip_mass": 0.0}}
TIME = np.arange(4000) / 200.0


def read(depth, force, seed=0, time=TIME):
    noise = NOISE * np.random.default_rng(seed).standard_normal(time.size)
    return tp.read({"t": time, "u": depth, "F": force + noise}, force_polarity="compression")


def cycles(slack):
    """Press in from zero and come back, five times; the touch is ``slack`` above zero."""
    depth = 1e-3 * (1.5 - 1.5 * np.cos(2 * np.pi * 0.25 * TIME))
    pressed = np.maximum(depth - slack, 0.0)
    return depth, 400.0 * pressed + 3.0 * np.gradient(pressed, TIME)


def value(found, name):
    return next(each for each in found.answer.values if each.name == name)


def test_slack_before_the_touch_is_no_play_and_no_other_zero_of_the_force():
    found = tp.diagnose(read(*cycles(0.3e-3)), **STATED)
    assert found.effects in ((), ("contact_loss",))
    assert value(found, "stiffness").value == pytest.approx(400.0, rel=5e-3)
    touch = value(found, "contact_position")
    assert touch.low - 2e-5 <= 0.3e-3 <= touch.high + 2e-5


def test_at_one_speed_a_damping_is_not_told_from_the_place_of_touch():
    time = np.arange(3000) / 1000.0
    depth = -1e-3 + 1e-3 * time
    force = np.where(depth > 0.0, 300.0 * depth + 2.0 * 1e-3, 0.0)
    found = tp.diagnose(read(depth, force, time=time), **STATED)
    damping = value(found, "damping")
    assert damping.low < 2.0 < damping.high
    assert "does not tell apart contact_position and damping" in found.text
    assert value(found, "stiffness").value == pytest.approx(300.0, rel=0.01)
    assert any("goes one way" in note for note in found.notes)


def bent(depth):
    speed = np.gradient(depth, TIME)
    return 300.0 * depth + 2e7 * depth**3 + 2.0 * speed


def pressed(rate):
    return 3e-3 + 1e-3 * np.sin(2 * np.pi * rate * TIME) + 8e-4 * np.sin(2 * np.pi * 0.3 * TIME)


def test_a_second_recording_with_another_zero_of_the_position_carries_over():
    first, second = pressed(1.3), pressed(2.1)
    validate = read(second + 12e-3, bent(second), 1)
    found = tp.diagnose(read(first, bent(first)), validate=validate, **STATED)
    assert found.verdict == "missing"
    assert found.effects == ("cubic_stiffening",)
    assert found.answer.errors.second < 1.1 * NOISE


@pytest.mark.parametrize("off", [-6e-3, pytest.param(10e-3, marks=pytest.mark.battery)])
def test_a_zero_of_the_position_that_differs_between_parts_is_no_tissue(off):
    later = np.where(TIME > 8.0, TIME + 0.7, TIME)
    depth = pressed(1.3)
    force = 300.0 * depth + 2.0 * np.gradient(depth, TIME)
    found = tp.diagnose(read(np.where(TIME > 8.0, depth + off, depth), force, time=later), **STATED)
    assert (found.verdict, found.effects) == ("missing", ("zero_by_part",))
    assert value(found, "stiffness").value == pytest.approx(300.0, rel=0.01)


def test_a_relaxation_is_one_with_a_lag_where_nobody_weighed_the_tip():
    """Whether the mass that fits ends at zero, or near it, is chance."""
    depth = 3e-3 + 1e-3 * np.sin(2 * np.pi * 0.2 * TIME) + 7e-4 * np.sin(2 * np.pi * 1.1 * TIME)
    step, branch = TIME[1], np.zeros(TIME.size)
    fine = 50
    for n in range(TIME.size - 1):
        slope = (depth[n + 1] - depth[n]) / step
        for _ in range(fine):
            branch[n + 1] = branch[n] if _ == 0 else branch[n + 1]
            branch[n + 1] += step / fine * (slope - 2.0 * branch[n + 1])
    force = 300.0 * depth + 4.0 * np.gradient(depth, step) + 250.0 * branch
    for seed in range(2):
        found = tp.diagnose(read(depth, force, seed), rig="rigid_probe")
        named = {name for each in found.found.ladder.alternatives for name in each}
        assert "standard_linear_solid" in named | set(found.effects)


def test_a_ramp_that_begins_in_contact_is_not_taken_for_a_drift_in_the_air():
    """The crosshead's reading is anywhere; the load's zero is right, and the specimen is taut."""
    ramp = np.minimum(TIME, 4.0) * 1e-3
    wave = np.where(TIME > 6.0, 6e-4 * np.sin(2 * np.pi * 0.7 * (TIME - 6.0)), 0.0)
    depth = ramp + wave
    force = 300.0 * depth + 3.0 * np.gradient(depth, TIME)
    found = tp.diagnose(read(depth + 37e-3, force), **STATED)
    assert (found.verdict, found.effects) == ("adequate", ())
    assert value(found, "stiffness").value == pytest.approx(300.0, rel=0.01)


@pytest.mark.battery
def test_the_answer_stays_when_one_of_the_effects_that_it_names_is_added(tmp_path):
    """The place of touch stays as unknown as it was, though the model was fitted with it."""
    branch, depth, step, added = np.zeros(TIME.size), pressed(1.3), TIME[1], "standard_linear_solid"
    for n in range(TIME.size - 1):  # by the exact step of a branch whose spring is stretched evenly
        fade = np.exp(-2.0 * step)
        slope = (depth[n + 1] - depth[n]) / step
        branch[n + 1] = fade * branch[n] + 250.0 * slope * (1.0 - fade) / 2.0
    measured = read(depth + 2e-3, bent(depth) + branch)
    first = tp.diagnose(measured, **STATED)
    improved = tp.improve(measured, add=[added], output=tmp_path / "kept", **STATED)
    again = tp.diagnose(measured, model=improved.model, constants=STATED["constants"])
    assert {*again.effects, added} == {*first.effects}
    of = {each.effect: each.probability for each in first.answer.ranking}
    for each in again.answer.ranking[:2]:
        assert each.probability == pytest.approx(of[each.effect], abs=0.05)
    assert again.answer.errors.fitted == pytest.approx(first.answer.errors.fitted, rel=1e-3)
