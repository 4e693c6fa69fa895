"""The run on the DAQ counts what was recorded, and what was not."""

from __future__ import annotations

from itertools import count

import pytest
from domain_coordinator import domain_id

from benchmarks import daq

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("daq")
    with domain_id(count(97).__next__) as domain, pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(domain))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        counted = daq.measure(folder, 0.5, say=lambda words: None, readings=20)
        return folder / "daq.mcap", counted


def test_every_published_sample_is_counted(run):
    _, counted = run
    assert counted["samples"] == counted["published"] > 4000
    assert counted["lost"] == 0
    assert f"{counted['samples']} samples, 0 lost" in daq.sentence(counted)


def test_what_was_published_but_not_recorded_is_lost(run):
    bag, counted = run
    assert daq.count(bag, counted["published"] + 10)["lost"] == 10


def test_the_papers_own_daq_gives_the_stiffness_behind_its_channels(run):
    _, counted = run
    slow = counted["slow"]
    assert slow["stiffness"] == pytest.approx(daq.SLOW_TISSUE[0], rel=0.1)  # after half a second
    assert 0.0 < slow["stiffness_sd"] < 0.1 * slow["stiffness"]
    assert f"stiffness {slow['stiffness']:.1f} ±" in daq.sentence(counted)
