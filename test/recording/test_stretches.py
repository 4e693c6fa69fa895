"""Holes in a block are filled where they are small, and cut out where they are not."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from tissue_probe.recording.clocks.stretches import cut_known, dwell_blocks, unknown_runs
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import PalpationSite, Phase, Recording, SampleBlock

PERIOD = 1e-3


def block(samples=400):
    wave = np.sin(2.0 * np.pi * 5.0 * PERIOD * np.arange(samples))
    return SampleBlock(10**9, 7, PERIOD, 1e-3 * wave, 0.5 * wave, np.full(samples, np.nan))


def test_small_holes_are_filled_in():
    whole, holed = block(), block()
    holed.position[50] = np.nan
    holed.force[100:103] = np.inf
    (stretch,), filled = cut_known(holed)
    assert filled == 4
    assert_allclose(stretch.position, whole.position, atol=1e-9)
    assert_allclose(stretch.force, whole.force, atol=1e-6)


def test_what_is_known_beside_a_hole_stays_as_it_was_measured():
    holed = block()
    holed.force[100:103] = np.nan
    rough = holed.position[101] = 5e-4
    (stretch,), _ = cut_known(holed)
    assert stretch.position[101] == rough
    assert list(np.flatnonzero(~stretch.measured)) == [100, 101, 102]


def test_runs_that_no_stretch_holds_are_told():
    holed = block()
    for unknown in (slice(0, 2), slice(100, 110), slice(399, 400)):
        holed.force[unknown] = np.nan
    stretches, _ = cut_known(holed)
    assert unknown_runs(holed, stretches) == [(0, 2), (100, 110), (399, 400)]
    assert unknown_runs(holed, []) == [(0, 400)]
    assert unknown_runs(block(), cut_known(block())[0]) == []


def test_large_holes_cut():
    holed = block()
    holed.force[:10] = np.nan
    holed.position[100:104] = np.nan
    first, second = cut_known(holed)[0]
    assert (first.sequence, len(first)) == (17, 90)
    assert (second.sequence, len(second), second.stamp) == (111, 296, 10**9 + 104 * 10**6)


@given(known=st.lists(st.booleans(), min_size=1, max_size=60))
@settings(max_examples=100, deadline=None)
def test_stretches_are_finite_and_hold_every_known_sample(known):
    holed = block(len(known))
    holed.force[~np.array(known)] = np.nan
    stretches, filled = cut_known(holed)
    assert all(np.isfinite(stretch.force).all() for stretch in stretches)
    assert sum(map(len, stretches)) == sum(known) + filled
    assert [s.sequence for s in stretches] == sorted({s.sequence for s in stretches})


def recording(sites):
    starts = [10**9 + number * 10**8 for number in range(len(sites) + 1)]
    announced = [
        PalpationSite(stamp, site, (0.0, 0.0, 0.0), Phase.DWELL)
        for stamp, site in zip(starts, sites, strict=False)
    ]
    lifted = PalpationSite(starts[-1], 0, (0.0, 0.0, 0.0), Phase.LIFTED)
    return Recording((block(),), (*announced, lifted) if sites else ())


def test_without_sites_everything_counts():
    (whole,) = dwell_blocks(recording([]), None)
    assert len(whole) == 400


def test_of_one_site_only_the_dwell_counts():
    (part,) = dwell_blocks(recording([4]), None)
    assert (part.sequence, len(part)) == (7, 100)


def test_of_several_sites_one_is_chosen():
    (part,) = dwell_blocks(recording([4, 5]), 5)
    assert (part.sequence, len(part)) == (107, 100)
    with pytest.raises(RecordingError, match=r"palpates 2 sites, .* with `site`, from 4 to 5"):
        dwell_blocks(recording([4, 5]), None)
    with pytest.raises(RecordingError, match="no samples at site 9; it palpates 4, 5"):
        dwell_blocks(recording([4, 5]), 9)
