"""Two topics of a robot on one even grid: causal, and the same to the last bit however cut."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.recording.clocks.channel import MessageChannel
from tissue_probe.recording.clocks.common_grid import CommonGrid
from tissue_probe.recording.clocks.local_cubic import local_cubic
from tissue_probe.signals import join

MILLISECOND = 1_000_000
BEGIN = 1_700_000_000 * 1000 * MILLISECOND
SECOND = 1000 * MILLISECOND


def position_at(stamps) -> np.ndarray:
    return 1e-3 * np.sin(2.0 * np.pi * 3.0 * (np.asarray(stamps) - BEGIN) / SECOND)


def force_at(stamps) -> np.ndarray:
    return 2.0 + 1.5 * np.cos(2.0 * np.pi * 3.0 * (np.asarray(stamps) - BEGIN) / SECOND)


def stamps_of(rate: float, duration: float, jitter: float = 0.0, seed: int = 0) -> np.ndarray:
    """Stamps [ns] at a rate [Hz], each off by up to a share of half the period."""
    period = SECOND / rate
    off = np.random.default_rng(seed).uniform(-0.5, 0.5, round(duration * rate)) * jitter * period
    return BEGIN + np.rint(np.arange(off.size) * period + off).astype(np.int64)


def messages(stamps, values) -> list[tuple[int, tuple[float, ...], tuple[float, ...]]]:
    """Messages of the position where a value is alone, of the force in one axis likewise."""
    return [(int(t), (float(v),), ()) for t, v in zip(stamps, values, strict=True)]


def positions(stamps) -> list:
    """Of a place that may not jump."""
    return [(int(t), (float(u), 1.0), (float(u),)) for t, u in
            zip(stamps, position_at(stamps), strict=True)]  # fmt: skip


class Joined:
    """Both channels, and the samples so far."""

    def __init__(self, position_rate: float = 250.0, force_rate: float = 500.0) -> None:
        self.position = MessageChannel("pose", position_rate, fastest=1.0)
        self.force = MessageChannel("wrench", force_rate, hangs=True)
        self.grid = CommonGrid(round(SECOND / force_rate), self.position, self.force)
        self.blocks: list = []

    def take(self, position=(), force=()) -> Joined:
        for each in position:
            self.position.take(*each)
        for each in force:
            self.force.take(*each)
        self.blocks += self.grid.take()
        return self

    @property
    def runs(self):
        return join(self.blocks)


def whole(position, force) -> Joined:
    """All at once."""
    return Joined().take(position, force)


def same(one, other) -> bool:
    """Whether samples are the same to the last bit, however they were cut."""
    return len(one) == len(other) and all(
        (a.stamp, a.sequence, a.sample_period) == (b.stamp, b.sequence, b.sample_period)
        and a.position.tobytes() == b.position.tobytes()
        and a.force.tobytes() == b.force.tobytes()
        for a, b in zip(one, other, strict=True)
    )


def usual(seed: int = 0):
    at_u, at_f = stamps_of(250.0, 1.0, 0.6, seed), stamps_of(500.0, 1.0, 0.6, seed + 1)
    return positions(at_u), messages(at_f, force_at(at_f))


@pytest.mark.parametrize(("position_rate", "force_rate"), [(250, 500), (100, 2000), (2000, 100)])
def test_samples_are_those_of_the_signals_at_whole_periods(position_rate, force_rate):
    at_u, at_f = stamps_of(position_rate, 1.0, 0.5, 2), stamps_of(force_rate, 1.0, 0.5, 3)
    joined = Joined(position_rate, force_rate).take(positions(at_u), messages(at_f, force_at(at_f)))
    (run,) = joined.runs
    assert np.all(run.stamps % round(SECOND / force_rate) == 0)
    assert np.all(np.diff(run.stamps) == round(SECOND / force_rate))
    # 3 Hz: 33 messages a period of the slower one, whose steps jitter by a half.
    np.testing.assert_allclose(run.position, position_at(run.stamps), atol=1e-3 * 5e-4)
    np.testing.assert_allclose(run.force, force_at(run.stamps), atol=1.5 * 5e-4)
    slower = SECOND / min(position_rate, force_rate)
    assert run.stamp - BEGIN <= 3 * slower
    assert max(at_u[-1], at_f[-1]) - run.stamps[-1] <= 4 * slower


def test_a_sample_is_known_two_messages_later():
    at_u, at_f = stamps_of(500.0, 0.2), stamps_of(500.0, 0.2)
    joined = Joined(500.0, 500.0)
    for u, f in zip(positions(at_u), messages(at_f, force_at(at_f)), strict=True):
        joined.take([u], [f])
        if joined.blocks:
            behind = f[0] - int(joined.runs[-1].stamps[-1])
            assert behind <= 2 * SECOND / 500


def test_a_parabola_is_met_to_rounding_where_stamps_jitter_and_a_line_by_any():
    rng = np.random.default_rng(4)
    for stamps, degree in (
        (BEGIN + np.cumsum(rng.integers(2_000_000, 4_000_000, 30)), 2),
        (BEGIN + np.cumsum(rng.integers(1, 5_000_000, 30)), 1),
    ):
        at = np.arange(stamps[1] + 1, stamps[-2] + 1, 333_333)
        x, s = ((each - stamps[0]) / SECOND for each in (stamps, at))
        found = local_cubic(stamps, np.stack([x**degree - 2.0 * x, x], axis=1), at)
        np.testing.assert_allclose(found, np.stack([s**degree - 2.0 * s, s], axis=1), atol=1e-14)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(1, 4_000_000), min_size=3, max_size=3), st.floats(0.0, 1.0))
def test_noise_is_hardly_amplified_however_close_two_stamps_come(steps, share):
    stamps = BEGIN + np.cumsum([0, *steps])
    at = np.array([stamps[1] + max(1, int(share * steps[1]))])
    weights = local_cubic(stamps, np.eye(4), at)[0]
    assert np.abs(weights).sum() < 2.01
    assert weights.sum() == pytest.approx(1.0)


FAULTS = st.sampled_from(["lost", "lost2", "late", "twice", "far", "past", "jump", "pause", "back"])


def spoilt(stream: list, faults) -> list:
    """Spoil a stream of messages by faults (kind, place)."""
    found = list(stream)
    for kind, place in faults:
        at = min(int(place * len(found)), len(found) - 3)
        t, row, spot = found[at]
        match kind:
            case "lost":
                del found[at]
            case "lost2":
                del found[at : at + 3]
            case "late":
                found[at], found[at + 1] = found[at + 1], found[at]
            case "twice":
                found.insert(at, found[at])
            case "far":
                found[at] = t + 3600 * SECOND, row, spot
            case "past":
                found[at] = t - 3600 * SECOND, row, spot
            case "jump":
                moved = tuple(each + 0.05 for each in spot)
                found[at] = t, row, moved
            case "pause" | "back":
                by = 2 * SECOND if kind == "pause" else -3 * SECOND
                found[at:] = [(stamp + by, *rest) for stamp, *rest in found[at:]]
    return found


@settings(max_examples=150, deadline=None)
@given(
    st.lists(st.tuples(FAULTS, st.floats(0.0, 1.0)), max_size=4),
    st.lists(st.tuples(FAULTS, st.floats(0.0, 1.0)), max_size=4),
    st.lists(st.tuples(st.integers(0, 60), st.integers(0, 60)), max_size=40),
    st.integers(0, 5),
)
def test_however_the_messages_come_between_one_another_the_samples_are_the_same(
    position_faults, force_faults, cuts, seed
):
    position, force = usual(seed)
    position, force = spoilt(position, position_faults), spoilt(force, force_faults)
    expected = whole(position, force).runs
    joined, u, f = Joined(), 0, 0
    for more_u, more_f in cuts:
        joined.take(position[u : u + more_u], force[f : f + more_f])
        u, f = u + more_u, f + more_f
    joined.take(position[u:], force[f:])
    assert same(joined.runs, expected)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(FAULTS, st.floats(0.0, 1.0)), min_size=1, max_size=4),
    st.lists(st.tuples(FAULTS, st.floats(0.0, 1.0)), max_size=4),
)
def test_whatever_is_wrong_no_sample_is(position_faults, force_faults):
    # A clock that was set moves the signals with it: then there is no truth to compare with.
    kept = [each for each in position_faults if each[0] not in ("pause", "back")]
    kept_f = [each for each in force_faults if each[0] not in ("pause", "back")]
    position, force = usual()
    joined = whole(spoilt(position, kept), spoilt(force, kept_f))
    assert joined.runs or joined.grid.clocks_apart  # two strays in a row are a clock
    for run in joined.runs:
        # Beside a lost message there are more than 25 a period of the sine still: the cubic is
        # within .7 % however their stamps jitter.
        np.testing.assert_allclose(run.position, position_at(run.stamps), atol=1e-3 * 7e-3)
        np.testing.assert_allclose(run.force, force_at(run.stamps), atol=1.5 * 1e-3)


def test_a_lost_message_is_bridged_and_more_are_a_hole_across_which_the_numbers_go_on():
    position, force = usual()
    del force[100]
    assert len(whole(position, force).runs) == 1
    del force[200:210]
    before, after = whole(position, force).runs
    assert after.sequence - before.sequence == (after.stamp - before.stamp) // (2 * MILLISECOND)
    assert (before.sequence, len(before)) < (0, after.sequence)


def test_a_silence_begins_another_run():
    position, force = usual()
    force = spoilt(force, [("pause", 0.5)])
    position = spoilt(position, [("pause", 0.5)])
    assert [run.sequence for run in whole(position, force).runs] == [0, 0]


def test_a_jump_of_the_place_begins_another_run_and_is_told():
    position, force = usual()
    position[125:] = [(t, (u + 0.05, d), (p + 0.05,)) for t, (u, d), (p,) in position[125:]]
    joined = whole(position, force)
    assert [run.sequence for run in joined.runs] == [0, 0]
    assert "pose jumps by 49.9 mm" in joined.position.faults["jumps"].sentence


def test_a_clock_that_both_topics_share_may_be_set_back():
    position, force = (spoilt(each, [("back", 0.5)]) for each in usual())
    joined = whole(position, force)
    assert [run.sequence for run in joined.runs] == [0, 0]
    assert joined.runs[1].stamp < joined.runs[0].stamp
    assert not joined.grid.clocks_apart
    assert "go back by" in joined.force.faults["clock set back"].sentence


def test_where_one_clock_alone_was_set_back_there_are_no_samples():
    position, force = usual()
    joined = whole(position, spoilt(force, [("back", 0.5)]))
    assert len(joined.runs) == 1
    assert joined.runs[0].end < BEGIN + 0.51 * SECOND
    assert joined.grid.clocks_apart


def test_a_sensor_that_hangs_is_left_out_after_a_while():
    at_u, at_f = stamps_of(250.0, 3.0), stamps_of(500.0, 3.0)
    values = force_at(at_f)
    values[500:] = values[500]
    position = positions(at_u)
    joined = whole(position, messages(at_f, values))
    assert joined.runs[-1].end < BEGIN + 1.6 * SECOND
    assert "hang" in joined.force.faults["hanging"].sentence
    values[500:] = 0.0
    assert whole(position, messages(at_f, values)).runs[-1].end > BEGIN + 2.9 * SECOND


def test_a_topic_that_ended_fills_no_memory():
    at_f = stamps_of(500.0, 30.0)
    joined = Joined()
    for first in range(0, at_f.size, 500):
        part = at_f[first : first + 500]
        joined.take([], messages(part, force_at(part)))
    assert sum(len(piece.stamps) for piece in joined.force.pieces) <= 5000
    assert math.isclose(joined.force.pieces[-1].stamps[-1], at_f[-1])
