"""Deadlines lie at start + n * period, whatever was late before."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe import pacing
from tissue_probe.pacing import WAKE_UPS_REMEMBERED, Pacer

PERIOD = 5e-4


class LateClock:
    """A clock whose sleeps end late, each by as much as it is told."""

    def __init__(self, delays):
        self.now = 7.0
        self._delays = iter(delays)

    def monotonic(self):
        return self.now

    def sleep(self, duration):
        assert duration > 0.0
        self.now += duration + next(self._delays)


def paced(delays, busy=()):
    """Wait for one deadline more than there are delays; return when each wait ended, how late."""
    clock = LateClock(delays)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pacing, "time", clock)
        pacer = Pacer(PERIOD)
        wakes, lateness = [], []
        for number in range(len(delays) + 1):
            lateness.append(pacer.wait_for(number))
            wakes.append(clock.now - 7.0)
            clock.now += busy[number] if number < len(busy) else 0.0
    return wakes, lateness, pacer


small_delays = st.lists(st.floats(0.0, 0.9 * PERIOD), min_size=1, max_size=50)


@given(small_delays)
def test_a_late_wake_up_does_not_shift_those_that_follow(delays):
    wakes, lateness, _ = paced(delays)
    for number, (wake, late) in enumerate(zip(wakes, lateness, strict=True)):
        assert wake == pytest.approx(number * PERIOD + [0.0, *delays][number], abs=1e-9)
        assert late == pytest.approx(wake - number * PERIOD, abs=1e-9)


@given(st.lists(st.floats(0.0, 10 * PERIOD), min_size=2, max_size=50))
def test_no_wait_ends_before_its_deadline_and_what_is_missed_is_caught_up(busy):
    wakes, _, _ = paced([0.0] * len(busy), busy)
    # Each wait ends at its deadline, or at once where the work before lasted longer.
    expected, now = [], 0.0
    for number, duration in enumerate([*busy, 0.0]):
        now = max(now, number * PERIOD)
        expected.append(now)
        now += duration
    assert wakes == pytest.approx(expected, abs=1e-9)


def test_a_million_late_deadlines_later_the_clock_has_not_drifted():
    clock = LateClock(iter(lambda: 1e-4, None))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pacing, "time", clock)
        pacer = Pacer(PERIOD)
        for number in range(0, 1_000_000, 997):
            pacer.wait_for(number)
            assert clock.now - 7.0 - number * PERIOD < 1.1e-4


@given(small_delays)
def test_the_worst_lateness_is_that_of_the_latest_wake_up(delays):
    _, lateness, pacer = paced(delays)
    assert pacer.worst_lateness == max(lateness)
    assert list(pacer.recent) == lateness


def test_only_the_latest_wake_ups_are_remembered(clock):
    pacer = Pacer(PERIOD)
    for number in range(WAKE_UPS_REMEMBERED + 10):
        pacer.wait_for(number)
    assert len(pacer.recent) == WAKE_UPS_REMEMBERED


def test_a_restart_counts_deadlines_from_now_and_forgets_lateness(clock):
    pacer = Pacer(PERIOD)
    clock.now += 3.0
    assert pacer.wait_for(0) == 3.0
    pacer.restart()
    assert pacer.worst_lateness == 0.0
    assert not pacer.recent
    assert pacer.wait_for(0) == 0.0
    assert pacer.wait_for(4) == 0.0
    assert clock.now == 1003.0 + 4 * PERIOD
