"""Old values that a channel repeats are told from those of a coarse or a saturated one."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from tissue_probe.recording.clocks.fresh_values import drives, fresh_values


def sine(count=2000, noise=1e-3):
    rng = np.random.default_rng(0)
    return np.sin(np.arange(count) / 50.0) + noise * rng.normal(size=count)


@pytest.mark.parametrize("published", [1.25, 1.6, 2, 5, 5.3, 10])
def test_a_channel_published_faster_than_it_measures_has_its_first_values_fresh(published):
    held_since = np.floor(np.arange(2000) / published).astype(int)
    fresh = fresh_values(sine()[held_since])
    assert_array_equal(fresh, np.r_[True, np.diff(held_since) > 0])


def test_a_held_channel_of_coarse_steps_is_still_held():
    held_since = np.arange(2000) // 5
    fresh = fresh_values(np.round(sine()[5 * held_since], 2))
    assert 300 < np.count_nonzero(fresh) <= 400  # where the sine turns, fresh ones are equal


@pytest.mark.parametrize(
    "honest",
    [
        sine(),
        np.round(sine(), 2),  # a coarse converter, slow signal
        np.round(sine(noise=0.0), 2),  # without noise its steps are long at the turns
        np.round(sine(noise=0.03), 2),  # a coarse converter, noisy signal
        np.clip(sine(), -0.5, 0.5),  # at its end half of the time
        np.r_[np.zeros(1000), sine()],  # at rest at first
        np.full(100, 3.0),
        np.full(100, np.nan),
        np.array([]),
        np.array([1.0]),
    ],
)
def test_what_no_clock_holds_is_all_fresh(honest):
    assert fresh_values(honest).all()


def answered(force, period, seed):
    """The position of a mass on a spring that is driven by a force, which holds between rows."""
    from scipy.signal import cont2discrete

    stiffness, damping, mass = 500.0, 2.0, 0.05
    own = np.array([[0.0, 1.0], [-stiffness / mass, -damping / mass]])
    system = own, np.array([[0.0], [1.0 / mass]]), np.array([[1.0, 0.0]]), np.zeros((1, 1))
    a, b, *_ = cont2discrete(system, period)
    state, position = np.zeros(2), []
    for each in force:
        position.append(state[0])
        state = a @ state + b[:, 0] * each
    noise = 1e-6 * np.random.default_rng(seed).standard_normal(len(force))
    return np.array(position) + noise


@given(seed=st.integers(0, 10**6), run=st.integers(20, 150))
@settings(max_examples=30)
def test_a_command_in_steps_is_what_drives(seed, run):
    levels = np.random.default_rng(seed).uniform(-1.0, 1.0, 2000 // run)
    force = np.repeat(levels, run)
    fresh = fresh_values(force)
    assume(not fresh.all())  # levels that happen to be alike are steps of a coarse converter
    assert drives(force, fresh, answered(force, 1e-3, seed))


def test_a_command_in_steps_is_told_beside_rows_that_are_not_known():
    force = np.repeat(np.random.default_rng(0).uniform(-1.0, 1.0, 20), 100)
    position = answered(force, 1e-3, 0)
    position[501], force[[750, 751]] = np.nan, np.nan
    fresh = np.r_[True, np.diff(force) != 0.0]
    assert drives(force, fresh, position)


@given(seed=st.integers(0, 10**6), run=st.integers(3, 60), cycle=st.floats(8.0, 300.0))
@settings(max_examples=50)
def test_a_sensor_that_is_read_late_drives_nothing(seed, run, cycle):
    random, rows = np.random.default_rng(seed), np.arange(2000)
    position = np.sin(2.0 * np.pi * rows / cycle)
    force = position + 0.3 * np.cos(2.0 * np.pi * rows / cycle) + 0.1 * position**3
    noisy = position + 1e-3 * random.standard_normal(rows.size)
    held = (force + 1e-3 * random.standard_normal(rows.size))[rows // run * run]
    assert not drives(held, fresh_values(held), noisy)


def test_a_command_that_changes_twice_is_no_channel_that_repeats_old_values():
    rests = np.concatenate([np.full(30, 0.0), np.full(4000, 1.2e-3), np.full(4000, 4.1e-3)])
    assert fresh_values(rests).all()
