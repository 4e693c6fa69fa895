"""Blocks of samples are checked, and can be cut and joined without changing a bit or a stamp."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal

from tissue_probe.signals import (
    NANOSECONDS,
    TEXT,
    PalpationSite,
    Phase,
    Recording,
    SampleBlock,
    Status,
    TissueEstimates,
    join,
    sample_offsets,
)

EPOCH = 1_700_000_000_000_000_000
WHOLE_PERIODS = [5e-4, 1e-3, 2e-3, 1e-4]  # each a whole number of nanoseconds
#: Any period, also those that are no whole number of nanoseconds.
periods = st.one_of(
    st.sampled_from(WHOLE_PERIODS), st.integers(500, 10000).map(lambda rate: 1.0 / rate)
)


@st.composite
def sample_blocks(draw, periods=periods, min_size=1):
    size = draw(st.integers(min_size, 40))
    return SampleBlock(
        stamp=draw(st.integers(0, EPOCH)),
        sequence=draw(st.integers(0, 10**12)),
        sample_period=draw(periods),
        position=draw(arrays(np.float64, size)),
        force=draw(arrays(np.float64, size)),
        command=draw(arrays(np.float64, size)),
    )


def block(size=10, **changes):
    ramp = np.arange(float(size))
    values = {"stamp": EPOCH, "sequence": 0, "sample_period": 5e-4}
    values |= {"position": ramp, "force": 10.0 * ramp, "command": 100.0 * ramp}
    return SampleBlock(**(values | changes))


def assert_same(one, other):
    assert (one.stamp, one.sequence, one.sample_period) == (
        other.stamp,
        other.sequence,
        other.sample_period,
    )
    for name in ("position", "force", "command"):
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes()


def cut(whole, places):
    bounds = [0, *sorted(places), len(whole)]
    return [whole[a:b] for a, b in pairwise(bounds) if b > a]


@given(sample_blocks(periods=st.sampled_from(WHOLE_PERIODS)), st.lists(st.integers(0, 40)))
def test_a_block_cut_anywhere_and_joined_is_what_it_was(whole, places):
    parts = cut(whole, [min(place, len(whole)) for place in places])
    (joined,) = join(parts)
    assert_same(joined, whole)


@given(sample_blocks(), st.integers(0, 40))
def test_a_part_keeps_the_stamps_of_its_samples_at_any_sample_period(whole, place):
    first = min(place, len(whole) - 1)
    part = whole[first:]
    assert part.stamp == whole.stamps[first]
    assert part.sequence == whole.sequence + first
    # Stamps are rounded to nanoseconds, each for itself.
    assert np.abs(part.stamps - whole.stamps[first:]).max() <= 1
    assert abs(part.end - whole.end) <= 1


@given(sample_blocks(), st.lists(st.integers(0, 40)))
def test_a_block_cut_anywhere_and_joined_is_what_it_was_at_any_sample_period(whole, places):
    parts = cut(whole, [min(place, len(whole)) for place in places])
    (joined,) = join(parts)
    assert_same(joined, whole)


@pytest.mark.parametrize("size", [1, 7, 10])
@pytest.mark.parametrize("rate", [600.0, 700.0, 3000.0])
def test_blocks_of_a_rate_without_exact_stamps_join_too(rate, size):
    whole = block(2000, sample_period=1.0 / rate)
    (joined,) = join([whole[first : first + size] for first in range(0, 2000, size)])
    assert_same(joined, whole)
    # A recording that misses the first samples, whose stamps were rounded from another zero.
    for missed in (1, 2, 3):
        (joined,) = join([whole[first : first + size] for first in range(missed, 2000, size)])
        assert np.abs(joined.stamps - whole.stamps[missed:]).max() <= 1


def test_stamps_that_drift_by_a_nanosecond_a_block_do_not_join_for_ever():
    blocks = [
        block(sequence=10 * number, stamp=EPOCH + 5_000_001 * number) for number in range(100)
    ]
    joined = join(blocks)
    stamps = np.concatenate([each.stamps for each in blocks])
    assert np.abs(np.concatenate([each.stamps for each in joined]) - stamps).max() <= 1


@given(periods, st.integers(1, 10**6))
def test_offsets_do_not_drift(period, count):
    offsets = sample_offsets(count, period)
    assert offsets[0] == 0
    assert abs(int(offsets[-1]) - (count - 1) * period * 1e9) <= 0.5 + 1e-9 * count
    assert offsets.dtype == np.int64


def test_samples_at_2_khz_are_stamped_every_half_millisecond_exactly():
    hour = sample_offsets(7_200_000, 5e-4)
    assert_array_equal(hour, np.arange(7_200_000) * 500_000)


def test_the_end_is_the_stamp_of_the_next_sample():
    assert block(10).end == EPOCH + 10 * 500_000
    assert block(10).end == block(11).stamps[-1]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"position": []}, r"position has shape \(0,\); give one value a sample, at least one"),
        ({"position": [[1.0]]}, r"position has shape \(1, 1\)"),
        ({"position": 1.0}, r"position has shape \(\)"),
        ({"force": np.zeros(9)}, "position, force and command have 10, 9 and 10 values"),
        ({"command": np.zeros(11)}, "position, force and command have 10, 10 and 11 values"),
        ({"force": np.zeros((10, 1))}, "give one of each for every sample"),
        ({"sample_period": 0.0}, "sample_period is 0.0 s; it must be positive"),
        ({"sample_period": -5e-4}, "sample_period is -0.0005 s"),
        ({"sample_period": float("inf")}, "sample_period is inf s"),
        ({"sample_period": float("nan")}, "sample_period is nan s"),
        ({"sequence": -1}, "sequence is -1; samples are numbered from 0"),
    ],
)
def test_a_block_that_makes_no_sense_is_refused(changes, said):
    with pytest.raises(ValueError, match=said):
        block(**changes)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_samples_that_are_not_finite_are_what_was_measured(value):
    assert_array_equal(block(2, force=[value, 1.0]).force, [value, 1.0])


def test_values_of_any_number_type_become_double_precision():
    made = block(2, position=[1, 2], force=np.float32([3, 4]), command=(5, 6))
    assert {made.position.dtype, made.force.dtype, made.command.dtype} == {np.dtype("f8")}


@pytest.mark.parametrize("wrong", [slice(None, None, 2), slice(None, None, -1)])
def test_only_consecutive_samples_can_be_cut_out(wrong):
    with pytest.raises(ValueError, match="step 1"):
        block()[wrong]


def test_a_slice_without_samples_is_refused():
    with pytest.raises(ValueError, match="at least one"):
        block()[4:4]


def test_negative_places_count_from_the_end():
    last = block()[-3:]
    assert (last.sequence, len(last), last.stamp) == (7, 3, EPOCH + 7 * 500_000)


@pytest.mark.parametrize(
    "changes",
    [
        {"sequence": 11},  # a sample is missing
        {"sequence": 9},  # the last came again
        {"sequence": 0},  # activated anew
        {"stamp": EPOCH + 10 * 500_000 + 2},  # the clock stepped
        {"stamp": EPOCH},
        {"sample_period": 1e-3},
        {"sample_period": 5.000000001e-4},
    ],
)
def test_what_does_not_continue_a_block_begins_a_new_one(changes):
    first = block()
    following = block(stamp=first.end, sequence=10)
    assert following.continues(first)
    other = replace(following, **changes)
    assert not other.continues(first)
    kept = join([first, other])
    assert len(kept) == 2
    assert_same(kept[0], first)
    assert_same(kept[1], other)


def test_nothing_joined_is_nothing():
    assert join([]) == []


@given(st.lists(st.integers(1, 5), min_size=1, max_size=20), st.sets(st.integers(0, 19)))
def test_each_gap_begins_one_new_block_and_no_sample_is_lost(sizes, gaps):
    blocks, sequence, stamp = [], 0, EPOCH
    for number, size in enumerate(sizes):
        if number in gaps and number > 0:
            sequence, stamp = sequence + 3, stamp + 3 * 500_000
        blocks.append(block(size, sequence=sequence, stamp=stamp))
        sequence, stamp = sequence + size, stamp + size * 500_000
    joined = join(iter(blocks))
    assert len(joined) == 1 + len({gap for gap in gaps if 0 < gap < len(sizes)})
    assert_array_equal(
        np.concatenate([each.position for each in joined]),
        np.concatenate([each.position for each in blocks]),
    )
    assert_array_equal(
        np.concatenate([each.stamps for each in joined]),
        np.concatenate([each.stamps for each in blocks]),
    )


def site(stamp, number, phase):
    return PalpationSite(stamp, number, (0.0, 0.0, 0.0), phase)


def test_a_recording_strings_its_blocks_together():
    run = Recording((block(3), block(2, sequence=5, stamp=EPOCH + 5 * 500_000)))
    assert len(run) == 5
    assert run.position.tolist() == [0.0, 1.0, 2.0, 0.0, 1.0]
    assert run.force.tolist() == [0.0, 10.0, 20.0, 0.0, 10.0]
    assert run.command.tolist() == [0.0, 100.0, 200.0, 0.0, 100.0]
    assert ((run.stamps - EPOCH) // 500_000).tolist() == [0, 1, 2, 5, 6]


def test_a_dwell_ends_with_the_next_announcement():
    sites = (
        site(EPOCH, 0, Phase.APPROACH),
        site(EPOCH + 10, 0, Phase.DWELL),
        site(EPOCH + 20, 0, Phase.LIFTED),
        site(EPOCH + 30, 1, Phase.APPROACH),
        site(EPOCH + 40, 1, Phase.DWELL),
        site(EPOCH + 55, 1, Phase.LIFTED),
    )
    dwells = list(Recording((block(),), sites).dwells())
    assert dwells == [(sites[1], EPOCH + 20), (sites[4], EPOCH + 55)]


def test_a_dwell_cut_short_ends_with_the_recording():
    dwell = site(EPOCH + 10, 0, Phase.DWELL)
    assert list(Recording((block(),), (dwell,)).dwells()) == [(dwell, block().end)]


@pytest.mark.parametrize(
    ("pause", "sequence"),
    [(60.0, 1000), (0.1, 0)],
    ids=["a silence", "a new activation"],
)
def test_a_dwell_that_nothing_ended_ends_with_the_run_of_samples_it_began_in(pause, sequence):
    first = SampleBlock(EPOCH, 500, 0.0005, *np.zeros((3, 100)))
    later = first.end + round(pause * NANOSECONDS)
    second = SampleBlock(later, sequence, 0.0005, *np.zeros((3, 100)))
    dwells = [site(EPOCH + 10, 0, Phase.DWELL), site(later + 10, 1, Phase.DWELL)]
    both = Recording((first, second), tuple(dwells))
    assert list(both.dwells()) == [(dwells[0], first.end), (dwells[1], second.end)]
    silent = site(first.end + 10, 0, Phase.DWELL)
    assert list(Recording((first, second), (silent,)).dwells()) == [(silent, silent.stamp)]


def test_samples_that_were_lost_end_no_dwell():
    first = SampleBlock(EPOCH, 0, 0.0005, *np.zeros((3, 100)))
    second = SampleBlock(first.end + NANOSECONDS // 4, 600, 0.0005, *np.zeros((3, 100)))
    dwell = site(EPOCH + 10, 0, Phase.DWELL)
    assert list(Recording((first, second), (dwell,)).dwells()) == [(dwell, second.end)]


def test_a_recording_without_sites_has_no_dwells():
    assert list(Recording((block(),)).dwells()) == []


COLUMNS = [entry.name for entry in fields(TissueEstimates)][1:]


def estimates(size, first=0, name="ekf"):
    columns = [first + np.arange(size) + 1000.0 * number for number in range(len(COLUMNS))]
    columns[0], columns[1] = columns[0].astype(np.int64), columns[1].astype(np.int64)
    status = np.full(size, Status.CONVERGED, dtype=np.uint8)
    model = np.array([f"model {first + row}" for row in range(size)], dtype=TEXT)
    return TissueEstimates(name, *columns[:-2], status, model)


@given(st.integers(0, 20), st.lists(st.integers(0, 20), max_size=4))
def test_estimates_cut_anywhere_and_concatenated_are_what_they_were(size, places):
    whole = estimates(size)
    bounds = [0, *sorted(min(place, size) for place in places), size]
    joined = TissueEstimates.concatenate([whole[a:b] for a, b in pairwise(bounds)])
    assert joined.estimator == "ekf"
    for name in COLUMNS:
        assert_array_equal(getattr(joined, name), getattr(whole, name))
        assert getattr(joined, name).dtype == getattr(whole, name).dtype


@given(arrays(np.bool_, 12))
def test_a_mask_selects_the_same_rows_of_every_column(mask):
    whole = estimates(12)
    selected = whole[mask]
    assert len(selected) == mask.sum()
    for name in COLUMNS:
        assert_array_equal(getattr(selected, name), getattr(whole, name)[mask])


def test_the_arrays_are_in_the_order_of_the_fields():
    whole = estimates(3)
    for name, array in zip(COLUMNS, whole.arrays(), strict=True):
        assert array is getattr(whole, name)
