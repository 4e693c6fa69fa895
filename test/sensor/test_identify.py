"""What is found of a sensor in free air: right, within its errors, and told where it is not."""

from __future__ import annotations

import numpy as np
import pytest
from free_air_world import EPOCH, FORCE_NOISE, TORQUE_NOISE, World

from tissue_probe.errors import MeasurementError
from tissue_probe.sensor.identify import Identified, identify
from tissue_probe.sensor.sensor_tracks import Track, stretches

PAIRS = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


def identified(world: World, seconds: float = 60.0, joints: bool = False) -> Identified:
    poses, wrenches, angles, _ = world.move(0.0, seconds)
    return identify(stretches(poses, wrenches, angles if joints else None))


def truths(world: World) -> dict[str, float]:
    values = {"mass": world.mass, "delay": world.delay}
    values |= {f"centre_{letter}": c for letter, c in zip("xyz", world.centre, strict=True)}
    values |= {f"inertia_{name}": world.inertia[pair] for name, pair in PAIRS.items()}
    for axis, name in enumerate(("fx", "fy", "fz", "tx", "ty", "tz")):
        values[f"drift_{name}"] = world.drift[axis]
    return values


def off_later(world: World, found: Identified, begin: float, joints: bool = False):
    """Return how wrong, and how wrong as stated, the wrench is in another motion, (n, 6) each."""
    poses, wrenches, angles, true = world.move(begin, 20.0)
    run = stretches(poses, wrenches, angles if joints else None, EPOCH)[0]
    time, made, deviation = found.wrench(run)
    now = (poses.stamps - EPOCH) / 1e9
    expected = np.stack([np.interp(time, now, each) for each in true.T], axis=1)
    return made - expected, deviation


def test_a_minute_of_turning_tells_every_number_within_its_error():
    world = World()
    found = identified(world)
    assert found.verdict == "adequate"
    assert not found.missing_effects
    assert not found.missing_poses
    np.testing.assert_allclose(found.noise[:3], FORCE_NOISE, rtol=0.03)
    np.testing.assert_allclose(found.noise[3:], TORQUE_NOISE, rtol=0.03)
    for name, value in truths(world).items():
        number = found.number(name)
        assert abs(number.value - value) < 4.0 * number.deviation, name
    assert found.number("mass").deviation < 1e-3
    assert found.number("delay").deviation < 2e-4


@pytest.mark.battery
def test_intervals_hold_as_often_as_they_say():
    held = []
    for seed in range(24):
        world = World(seed=seed)
        found = identified(world)
        pairs = [(found.number(name), value) for name, value in truths(world).items()]
        held.append([abs(n.value - value) < 1.96 * n.deviation for n, value in pairs])
    assert 0.90 < np.mean(held) < 0.99


def test_gains_are_told_but_for_the_common_one():
    world = World(gains=np.array([1.02, 0.99, 1.0, 1.0, 1.01, 1.0]))
    found = identified(world)
    common = np.prod(world.gains[:3]) ** (1.0 / 3.0)
    for axis, name in enumerate(("gain_fx", "gain_fy", "gain_fz")):
        number = found.number(name)
        assert abs(number.value - world.gains[axis] / common) < 4.0 * number.deviation
    mass = found.number("mass")
    assert abs(mass.value - common * world.mass) < 4.0 * mass.deviation
    assert "common gain of the forces and the mass are one" in found.one_function[0]


def test_a_cable_is_taken_where_the_data_ask_for_it_and_mass_is_then_not_told():
    world = World(cable=1.0)
    found = identified(world, joints=True)
    assert found.cable is not None
    assert found.verdict == "adequate"
    assert not found.number("mass").told
    assert any("cable" in sentence for sentence in found.one_function)
    off, deviation = off_later(world, found, 60.0, joints=True)
    assert np.sqrt(np.mean(off[:, :3] ** 2)) < 0.03
    assert np.mean(np.abs(off) < 1.96 * deviation) > 0.8


def test_errors_of_the_wrench_grow_with_time_and_fall_with_a_zero_taken_anew():
    world = World()
    found = identified(world)
    _, early = off_later(world, found, 60.0)
    _, late = off_later(world, found, 660.0)
    assert late.mean() > 5.0 * early.mean()
    poses, wrenches, _, _ = world.move(660.0, 2.0)
    zeroed = found.with_zero(stretches(poses, wrenches, origin=EPOCH)[0])
    rates = [
        (zeroed.number(f"drift_{name}"), rate)
        for name, rate in zip(("fx", "fy", "fz"), world.drift, strict=False)
    ]
    assert all(abs(n.value - rate) < 4.0 * n.deviation + 1e-4 for n, rate in rates)


def test_a_flange_that_turns_about_one_axis_is_told_which_to_turn_about():
    world = World(swing=np.array([0.0, 0.0, 0.9]), seed=3)
    found = identified(world, 40.0)
    assert found.verdict == "cannot tell"
    assert any("about its x axis" in s or "about its y axis" in s for s in found.missing_poses)
    assert not found.number("mass").told or not found.number("inertia_xx").told


def test_a_touch_is_told_with_its_time():
    poses, wrenches, _, _ = World().move(0.0, 60.0)
    rows = wrenches.rows.copy()
    rows[5000:5200, 2] -= 1.5
    found = identify(stretches(poses, Track(wrenches.stamps, rows)))
    assert found.verdict == "missing"
    assert "touched" in found.missing_effects[0]
    assert "about 20." in found.missing_effects[0]


def test_a_bias_that_settles_is_told_as_one_that_wanders():
    poses, wrenches, _, _ = World().move(0.0, 60.0)
    time = (wrenches.stamps - wrenches.stamps[0])[:, None] / 1e9
    settling = np.exp(-time / 15.0) * np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    found = identify(stretches(poses, Track(wrenches.stamps, wrenches.rows + settling)))
    assert found.verdict == "missing"
    assert "wanders in time" in found.missing_effects[0]


def test_a_sensor_that_tells_the_reaction_has_a_mass_all_the_same():
    poses, wrenches, _, _ = World().move(0.0, 30.0)
    found = identify(stretches(poses, Track(wrenches.stamps, -wrenches.rows)))
    assert found.number("mass").value == pytest.approx(0.8, rel=0.01)


def test_topics_at_other_rates_and_with_jitter_tell_the_same():
    world = World()
    poses, wrenches, _, _ = world.move(0.0, 60.0)
    random = np.random.default_rng(1)
    kept = np.sort(random.choice(len(poses.stamps), len(poses.stamps) // 2, replace=False))
    kept = np.unique(np.concatenate([np.arange(0, len(poses.stamps), 2), kept[::50]]))
    found = identify(stretches(Track(poses.stamps[kept], poses.rows[kept]), wrenches))
    mass = found.number("mass")
    assert abs(mass.value - world.mass) < 5.0 * mass.deviation
    assert found.number("delay").value == pytest.approx(world.delay, abs=5e-4)


def _nan(poses, wrenches):
    wrenches.rows[500, 1] = np.nan


def _stops(poses, wrenches):
    wrenches.rows[2000:2300] = wrenches.rows[2000]


def _jumps(poses, wrenches):
    poses.rows[3000:, 0] += 0.2


def _saturates(poses, wrenches):
    np.clip(wrenches.rows, None, np.quantile(wrenches.rows[:, 2], 0.9), out=wrenches.rows)


def _no_turn(poses, wrenches):
    poses.rows[100, 3:] = 0.0


def _back(poses, wrenches):
    poses.stamps[100] = poses.stamps[99]


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (_nan, "the wrench is not finite at 2.00 s: leave such samples out"),
        (_stops, "the wrench stops at 8.00 s: for 1.2 s it repeats one value"),
        (_jumps, "the pose jumps at 12.00 s, by 200 mm"),
        (_saturates, "is in saturation at"),
        (_no_turn, "the orientation is none at 0.40 s"),
        (_back, "the times of the pose do not ascend at 0.40 s"),
    ],
)
def test_what_is_wrong_with_samples_is_told_in_a_sentence(spoil, sentence):
    poses, wrenches, _, _ = World().move(0.0, 20.0)
    spoil(poses, wrenches)
    with pytest.raises(MeasurementError, match=sentence):
        stretches(poses, wrenches)


@pytest.mark.parametrize("missing", [0, 1, 2])
def test_a_topic_without_a_sample_is_told(missing):
    tracks = list(World().move(0.0, 10.0)[:3])
    tracks[missing] = Track(tracks[missing].stamps[:0], tracks[missing].rows[:0])
    with pytest.raises(MeasurementError, match="has 0 samples: record a minute"):
        stretches(*tracks)


def test_a_sensor_without_torques_is_identified_by_its_forces():
    poses, wrenches, _, _ = World().move(0.0, 40.0)
    wrenches.rows[:, 3:] = 0.0
    with np.errstate(all="raise"):
        found = identify(stretches(poses, wrenches))
    assert (found.noise > 0.0).all()
    assert found.number("mass").value == pytest.approx(World().mass, rel=0.02)
    assert all(np.isfinite([each.value, each.deviation]).all() for each in found.numbers)


def test_too_short_a_run_is_refused():
    poses, wrenches, _, _ = World().move(0.0, 5.0)
    with pytest.raises(MeasurementError, match="record 30 to 60 s in which the flange turns"):
        identify(stretches(poses, wrenches))
