"""The wrench that is left, sample by sample: at any rate that is identified, for days."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from free_air_world import EPOCH, FORCE_NOISE, RATE, World

from tissue_probe.sensor.compensation import Compensation, compensation
from tissue_probe.sensor.identify import identify
from tissue_probe.sensor.live import Left, LiveCompensation
from tissue_probe.sensor.sensor_tracks import Track, stretches
from tissue_probe.signals import NANOSECONDS


@pytest.fixture(scope="module")
def model() -> Compensation:
    poses, wrenches, _, _ = World().move(0.0, 30.0)
    runs = stretches(poses, wrenches, origin=EPOCH)
    return compensation(identify(runs), runs, EPOCH)


def left_of(live: LiveCompensation, poses: Track, wrenches: Track) -> list[Left]:
    """Hand all over in the order of their stamps, a tenth of a second at a time."""
    step, found = NANOSECONDS // 10, []
    for begin in range(int(wrenches.stamps[0]), int(wrenches.stamps[-1]) + 1, step):
        for track, take in ((poses, live.take_pose), (wrenches, live.take_wrench)):
            for place in range(*np.searchsorted(track.stamps, (begin, begin + step))):
                take(int(track.stamps[place]), track.rows[place])
        found += live.take_known()
    return found


def every(track: Track, rate: float) -> Track:
    places = np.round(np.arange(0.0, len(track.stamps) - 1, RATE / rate)).astype(int)
    return Track(track.stamps[places], track.rows[places])


@pytest.mark.parametrize("rate", [250.0, 55.0, 45.0, 40.0])
def test_at_every_rate_of_poses_that_is_identified_the_wrench_is_left(model, rate):
    poses, wrenches, _, _ = World(seed=1).move(30.0, 10.0)
    left = left_of(LiveCompensation(model, late=0.06), every(poses, rate), wrenches)
    assert len(left) > 0.97 * len(wrenches.stamps)
    forces = np.array([each.wrench[:3] for each in left])
    assert np.sqrt(np.mean(forces**2)) < 1.05 * FORCE_NOISE


def test_poses_at_less_than_that_rate_leave_no_wrench(model):
    poses, wrenches, _, _ = World(seed=1).move(30.0, 4.0)
    assert not left_of(LiveCompensation(model, late=0.0), every(poses, 25.0), wrenches)


def test_a_wrench_without_poses_is_let_go(model):
    live = LiveCompensation(model, late=0.0)
    poses, wrenches, _, _ = World(seed=1).move(30.0, 1.0)
    left_of(live, poses, wrenches)
    tracemalloc.start()
    try:
        sizes = []
        for _ in range(2):
            for number in range(20_000):
                live.take_wrench(int(wrenches.stamps[-1]) + number * 4_000_000, np.zeros(6))
            assert not live.take_known()
            sizes.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    assert sizes[1] < 1.1 * sizes[0] < 2e6
