"""Old values that a channel repeats are told from those of a coarse or a saturated one."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from tissue_probe.recording.fresh_values import fresh_values


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
