"""The zero of a position, of a force in each part, and uneven times are no tissue."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tissue_probe as tp
from tissue_probe.diagnosis.inspection.contact import touch_within

pytestmark = pytest.mark.timeout(900)

NOISE = 4e-3
STATED = {"rig": "rigid_probe", "constants": {"tip_mass": 0.0}}


def motion(time):
    """Return a depth [m] that never comes near 0."""
    return 3e-3 + 1e-3 * np.sin(2 * np.pi * 1.3 * time) + 4e-4 * np.sin(2 * np.pi * 7.1 * time)


def speed(time):
    return (motion(time + 1e-6) - motion(time - 1e-6)) / 2e-6


def read(time, position, force, seed=0):
    noise = NOISE * np.random.default_rng(seed).standard_normal(time.size)
    table = {"t": time, "u": position, "F": force + noise}
    return tp.read(table, force_polarity="compression")


def even(count=3000, rate=500.0):
    return np.arange(count) / rate


@pytest.mark.parametrize("off", [13e-3, pytest.param(-2e-3, marks=pytest.mark.battery)])
def test_where_the_positions_zero_is_changes_nothing_of_plain_tissue(off):
    time = even()
    found = tp.diagnose(
        read(time, motion(time) + off, 400.0 * motion(time) + 2.0 * speed(time)), **STATED
    )
    assert (found.verdict, found.effects) == ("adequate", ())
    (touch,) = found.answer.instrument
    assert touch.value == pytest.approx(off, abs=4.0 * touch.deviation)
    assert touch.degenerate_with == ["force_bias"]
    assert any("one and the same" in note for note in found.notes)
    assert found.found.ladder.base.named()["stiffness"] == pytest.approx(400.0, rel=5e-3)


def test_a_curved_law_tells_where_it_touches():
    time, off = even(), 8e-3
    force = 9000.0 * motion(time) ** 1.5 + 1.5 * speed(time)
    found = tp.diagnose(read(time, motion(time) + off, force), **STATED)
    assert (found.verdict, found.effects) == ("missing", ("hertz_contact",))
    (touch,) = found.answer.instrument
    assert touch.value == pytest.approx(off, abs=4.0 * touch.deviation)
    assert touch.degenerate_with == []
    assert any("The tip touches at" in note for note in found.notes)


def test_a_place_of_touch_that_is_given_is_kept():
    time = even()
    force = 400.0 * motion(time) + 2.0 * speed(time) + 0.1
    stated = {"rig": "rigid_probe", "constants": {"tip_mass": 0.0, "contact_position": 0.0}}
    found = tp.diagnose(read(time, motion(time), force), **stated)
    assert (found.verdict, found.effects) == ("missing", ("force_bias",))
    (zero,) = found.answer.instrument
    assert (zero.name, zero.unit, zero.part) == ("force_bias", "N", None)
    assert zero.value == pytest.approx(0.1, abs=2e-3)


def test_a_delay_between_the_channels_is_a_value_of_the_instrument():
    time, late = even(), 4e-3
    force = 400.0 * motion(time - late) + 2.0 * speed(time - late)
    constants = {"tip_mass": 0.0, "contact_position": 0.0}
    found = tp.diagnose(read(time, motion(time), force), rig="rigid_probe", constants=constants)
    assert (found.verdict, found.effects) == ("missing", ("channel_delay",))
    (delay,) = found.answer.instrument
    assert (delay.name, delay.unit, delay.recording) == ("channel_delay", "s", "")
    assert delay.value == pytest.approx(late, abs=4.0 * delay.deviation)


def test_a_bias_that_is_asked_for_is_fitted():
    time = even()
    force = 400.0 * motion(time) + 2.0 * speed(time) + 0.1
    found = tp.diagnose(read(time, motion(time), force), add=["force_bias"], **STATED)
    assert found.found.ladder.final.named()["force_bias"] == pytest.approx(0.1, abs=2e-3)


@pytest.mark.parametrize("zero", [-1.0, pytest.param(0.05, marks=pytest.mark.battery)])
def test_a_zero_that_is_set_anew_after_a_gap_is_no_relaxation(zero):
    time = np.concatenate([even(), 6.3 + even()])
    force = 320.0 * motion(time) + 6.0 * speed(time) + np.where(time > 6.2, zero, 0.0)
    found = tp.diagnose(read(time, motion(time), force), **STATED)
    assert (found.verdict, found.effects) == ("missing", ("zero_by_part",))
    part = next(each for each in found.answer.instrument if each.name == "zero_by_part")
    assert (part.part, part.unit) == (2, "N")
    assert part.value == pytest.approx(zero, abs=2e-3)
    assert found.found.ladder.final.named()["stiffness"] == pytest.approx(320.0, rel=5e-3)


def test_one_part_has_no_zero_of_parts():
    time = even()
    force = 320.0 * motion(time) + 6.0 * speed(time)
    found = tp.diagnose(read(time, motion(time), force), **STATED)
    assert "zero_by_part" not in [row.effect for row in found.answer.ranking]


def test_outliers_at_uneven_times_stay_single_samples():
    random = np.random.default_rng(1)
    time = (np.arange(1600) + random.uniform(-0.02, 0.02, 1600)) / 80.0
    depth = 2e-3 + 1e-3 * np.sin(2 * np.pi * 0.6 * time) + 4e-4 * np.sin(2 * np.pi * 2.3 * time)
    rate = np.gradient(depth, time)
    force = 320.0 * depth + 6.0 * rate
    force = np.where(random.random(1600) < 0.015, -force, force)
    found = tp.diagnose(read(time, depth, force), **STATED)
    assert (found.verdict, found.effects) == ("adequate", ())
    fit = found.found.ladder.base
    assert fit.ratio < 1.1
    assert fit.named()["stiffness"] == pytest.approx(320.0, abs=4.0 * fit.deviations()["stiffness"])
    assert any("stand alone" in note for note in found.notes)


def test_two_rates_in_one_table_are_read_and_fitted():
    """Fast on ramps, slow on holds; the tissue relaxes."""
    blocks = [(0.1, 40), (0.25, 30)] * 6
    steps = np.concatenate([np.full(count, step) for step, count in blocks])
    time = np.concatenate([[0.0], np.cumsum(steps)])
    ends = np.cumsum([0.0, *(count * step for step, count in blocks)])
    depths = np.repeat(np.array([0.0, 1.0, 0.4, 1.3, 0.6, 1.6, 0.9]) * 1e-3, 2)[1:-1]
    depth = 1e-3 + np.interp(time, ends, np.append(depths, depths[-1])[: ends.size])
    branch, rate, fine = np.zeros(time.size), 0.5, 400
    for i in range(time.size - 1):
        part = (time[i + 1] - time[i]) / fine
        slope = (depth[i + 1] - depth[i]) / (time[i + 1] - time[i])
        decay = np.exp(-rate * part * fine)
        branch[i + 1] = branch[i] * decay + slope / rate * (1.0 - decay)
    force = 300.0 * depth + 250.0 * branch
    recording = read(time, depth, force)
    assert any("rates from 4 to 10 Hz" in note for note in recording.notes)
    found = tp.diagnose(recording, **STATED)
    assert found.verdict == "missing"
    assert found.effects[0] in ("standard_linear_solid", "generalized_maxwell")


@given(
    seed=st.integers(0, 1000),
    drift=st.floats(-1.0, 1.0),
    depth=st.floats(0.2, 2.0),
)
@settings(max_examples=30)
def test_the_air_is_told_from_contact(seed, drift, depth):
    random = np.random.default_rng(seed)
    time = even(2000)
    position = 1e-3 * np.sin(2 * np.pi * 1.1 * time)
    zero = 0.2 + 5e-3 * drift * time + NOISE * random.standard_normal(time.size)
    pressed = 800.0 * np.maximum(position + 2e-4, 0.0)
    assert np.isfinite(touch_within(position, zero + pressed, NOISE))
    assert np.isinf(touch_within(position, zero + 800.0 * depth * (position + 1e-3), NOISE))
