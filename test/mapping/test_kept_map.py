"""Site results in a file: taken up in the same scan, and in no other."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.mapping.fusion import Dwell, Estimate, Judged, MapBuilder
from tissue_probe.mapping.grid import Grid
from tissue_probe.mapping.kept_map import KeptMap
from tissue_probe.mapping.site_results import SiteResults
from tissue_probe.signals import Leaving, PalpationSite, Phase, Status

GRID = Grid((0.0, 0.0, 0.0), 0.003, rows=2, columns=3)
#: Announcements are sent at these times after their stamps.
LATER = 7


def announcements(site):
    begin = 1000 * (site + 1)
    times = {Phase.APPROACH: begin - 500, Phase.DWELL: begin, Phase.LIFTED: begin + 400}
    return [PalpationSite(t, site, GRID.position(site), phase) for phase, t in times.items()]


def estimate(site, stiffness):
    return Estimate(1000 * (site + 1) + 100, stiffness, 5.0, 0.1, 0.09, 1e-4)


def palpate(kept, sites, sent=LATER, stiffness=100.0):
    for site in sites:
        approach, dwell, lifted = announcements(site)
        kept.announce(approach, approach.stamp + sent)
        kept.announce(dwell, dwell.stamp + sent)
        kept.add_one("ekf", Status.CONVERGED, estimate(site, stiffness * (site + 1)))
        kept.announce(lifted, lifted.stamp + sent)


def hear_again(kept, sites, sent=LATER):
    """What a late joiner hears: all announcements, no estimate."""
    for site in sites:
        for announcement in announcements(site):
            kept.announce(announcement, announcement.stamp + sent)


@pytest.fixture
def file(tmp_path):
    return tmp_path / "folder" / "results.jsonl"


def fresh(file, told=None):
    return KeptMap(SiteResults(file), [].append if told is None else told.append)


def assert_same(one, other):
    assert (one.grid, one.stamp) == (other.grid, other.stamp)
    for name in ("stiffness", "damping", "stiffness_stddev", "verdict"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("before", range(1, 6))
def test_a_map_started_again_in_a_scan_ends_as_one_that_never_ended(file, tmp_path, before):
    palpate(fresh(file), range(before))
    again = fresh(file)
    hear_again(again, range(before))
    palpate(again, range(before, len(GRID)))
    whole = fresh(tmp_path / "other")
    palpate(whole, range(len(GRID)))
    assert_same(again.map(), whole.map())


def test_results_are_taken_up_over_several_restarts(file):
    palpate(fresh(file), range(2))
    for restarts in range(2, 4):
        again = fresh(file)
        hear_again(again, range(restarts))
        palpate(again, [restarts])
    assert again.map().measured.sum() == 4


def test_an_estimate_that_comes_after_the_lift_is_kept_too(file):
    kept = fresh(file)
    hear_again(kept, [0])
    kept.add_one("ekf", Status.CONVERGED, estimate(0, 123.0))
    again = fresh(file)
    hear_again(again, [0])
    assert again.map().stiffness[0, 0] == 123.0


def test_the_same_announcements_sent_at_another_time_are_another_run(file):
    palpate(fresh(file), range(3))
    replayed = fresh(file)
    hear_again(replayed, range(3), sent=LATER + 1)
    assert not replayed.map().measured.any()
    # and what was kept is gone, since the file is the other run's now
    again = fresh(file)
    hear_again(again, range(3))
    assert not again.map().measured.any()


def test_a_line_that_was_cut_off_costs_that_line(file):
    palpate(fresh(file), range(3))
    file.write_text(file.read_text()[:-20])
    again = fresh(file)
    hear_again(again, range(3))
    assert list(again.map().stiffness[0]) == pytest.approx([100.0, 200.0, np.nan], nan_ok=True)


def test_a_file_that_cannot_be_written_is_told_once_and_the_map_goes_on(tmp_path):
    (tmp_path / "no folder").write_text("")
    told = []
    kept = fresh(tmp_path / "no folder" / "results.jsonl", told)
    palpate(kept, range(3))
    assert kept.map().measured.sum() == 3
    assert len(told) == 1
    assert "not kept" in told[0]


numbers = st.floats(allow_nan=False)


@given(
    begin=st.integers(0, 2**62),
    status=st.sampled_from(Status),
    values=st.tuples(*[numbers] * 5),
    announced=st.integers(0, 2**62),
    leaving=st.sampled_from(Leaving),
)
def test_a_dwell_reads_back_as_it_was_kept(
    tmp_path_factory, begin, status, values, announced, leaving
):
    site = PalpationSite(begin, 3, (0.001, -0.002, 0.5), Phase.DWELL)
    dwell = Dwell(site)
    dwell.end_at(begin + 10)
    dwell.leaving = leaving
    dwell.take("ekf", Judged(int(status), Estimate(begin + 1, *values)))
    results = SiteResults(tmp_path_factory.mktemp("kept") / "results.jsonl")
    results.begin({})
    results.keep(announced, dwell)
    ((sent, found),) = results.read_stored().items()
    assert (sent, found.site, found.end) == (announced, site, begin + 10)
    assert found.leaving == leaving
    assert found.last() == dwell.last()


@given(st.binary(max_size=300))
def test_any_bytes_in_the_file_are_read_or_left_out(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("kept") / "results.jsonl"
    path.write_bytes(content)
    assert isinstance(SiteResults(path).read_stored(), dict)


@st.composite
def interleavings(draw):
    """A scan's announcements and estimates, as a late or an early listener may hear them."""
    events = []
    for site in range(len(GRID)):
        approach, dwell, lifted = announcements(site)
        # Of samples that come late, the next approach may be told as before the end of the dwell.
        early = replace(approach, stamp=approach.stamp - draw(st.integers(0, 300)))
        before = [event for event in events[-7:] if event[0] == "estimate"]
        place = draw(st.integers(0, len(before)))
        events.insert(len(events) - place, ("site", early))
        events.append(("site", dwell))
        stamps = sorted(draw(st.lists(st.integers(1, 600), max_size=5, unique=True)))
        after = [("estimate", draw(st.sampled_from(Status)), dwell.stamp + s) for s in stamps]
        after.insert(draw(st.integers(0, len(after))), ("site", lifted))
        events += after
    return events


@given(interleavings())
def test_the_map_does_not_depend_on_when_the_estimates_come(events):
    live, off_line = MapBuilder(), MapBuilder()
    for _, site in (event for event in events if event[0] == "site"):
        off_line.announce(site)
    for kind, *content in events:
        if kind == "site":
            live.announce(*content)
        else:
            status, stamp = content
            one = Estimate(stamp, 400.0 + stamp % 100, 5.0, 0.1, 0.09, 1e-4)
            live.add_one("ekf", status, one)
            off_line.add_one("ekf", status, one)
    assert_same(live.map(), off_line.map())


def test_results_of_visits_are_those_before_the_restart(file):
    before = fresh(file)
    palpate(before, [0, 1, 2])
    after = fresh(file)
    hear_again(after, [0, 1, 2])
    assert after.results(under_way=False) == before.results(under_way=False)
    assert [one.stiffness for one in after.results()] == [100.0, 200.0, 300.0]


def test_a_site_without_a_surface_is_one_after_the_restart_too(file):
    approach, _, lifted = announcements(0)
    left = replace(lifted, leaving=Leaving.NO_CONTACT)
    before, after = fresh(file), fresh(file)
    for kept in (before, after):
        kept.announce(approach, approach.stamp + LATER)
        kept.announce(left, left.stamp + LATER)
        (palpate if kept is before else hear_again)(kept, [1])
    # Values that are not numbers are unequal to themselves: texts are compared.
    assert repr(after.results(under_way=False)) == repr(before.results(under_way=False))
    assert [one.leaving for one in after.results()] == [Leaving.NO_CONTACT, Leaving.UNTOLD]
    assert after.results()[1].stiffness == 200.0
