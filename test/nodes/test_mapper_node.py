"""The mapper node: the map grows site by site, for late joiners too."""

from __future__ import annotations

import signal

import numpy as np
import pytest
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

import tissue_probe as tp
from conftest import collect, site_publisher
from tissue_probe.analysis.recorded_facts import gather_sites
from tissue_probe.mapping.grid import Grid
from tissue_probe.mapping.posterior.posterior_map import map_of
from tissue_probe.mapping.posterior.results import PosteriorMap
from tissue_probe.mapping.sites import Sites
from tissue_probe.mapping.verdict import CellVerdict
from tissue_probe.nodes.conversions import site_to_message, to_time
from tissue_probe.nodes.qos import LATCHED, SAMPLE_BLOCKS, SCAN_ANNOUNCEMENTS
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.recording.bags.reader import read_estimates, read_map, read_recording
from tissue_probe.signals import PalpationSite, Phase
from tissue_probe_msgs.msg import (
    Inclusions,
    ProbeSamples,
    SiteResults,
    StiffnessMap,
    TissueEstimate,
)
from tissue_probe_msgs.msg import PalpationSite as PalpationSiteMessage

GRID = Grid((0.0, 0.0, 0.0), 0.01, rows=2, columns=3)
MAPPER = NodeProcess("mapper", "mapper", parameters={"estimators": ["ekf", "ukf"]})


def estimate(name: str, stamp: int, stiffness: float, status: int) -> TissueEstimate:
    message = TissueEstimate(
        estimator=name,
        stiffness=stiffness,
        damping=5.0,
        covariance_trace=1.0,
        stiffness_variance=4.0,
        damping_variance=0.01,
        status=status,
    )
    message.header.stamp = to_time(stamp)
    return message


@pytest.fixture(scope="module", autouse=True)
def compiled():
    """Have the map compiled and kept before a mapper has to do it while a test waits."""
    place = np.array([0.0, 0.01, 0.0, 0.01])
    map_of(Sites(place, place[::-1], np.zeros(4), None, np.full(4, 450.0), np.ones(4)))


@pytest.fixture(autouse=True)
def results_kept_here(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))


def say(publisher, stamp, site, phase, grid=GRID):
    announcement = PalpationSite(stamp, site, grid.position(site), phase)
    publisher.publish(site_to_message(announcement, "stage"))


@pytest.fixture
def mapped(session):
    """A mapper that has heard of a grid and of one dwell on it, and the test's subscriptions."""
    running = session(MAPPER)
    maps = collect(running.node, StiffnessMap, "/probe/stiffness_map", LATCHED)
    sites = site_publisher(running.node)
    publishers = {
        name: running.node.create_publisher(
            TissueEstimate, f"/probe/{name}/estimate", SAMPLE_BLOCKS
        )
        for name in ("ekf", "ukf")
    }
    running.wait_until(
        lambda: all(p.get_subscription_count() for p in (sites, *publishers.values())), "the mapper"
    )
    for site in range(len(GRID)):
        say(sites, 10 + site, site, Phase.APPROACH)
    say(sites, 1000, 4, Phase.DWELL)
    running.wait_until(lambda: sites.wait_for_all_acked(), "the announcement to arrive")
    return running, maps, sites, publishers


def test_nothing_is_published_before_a_sample_is_known_of(mapped):
    running, maps, _, publishers = mapped

    def heard() -> bool:
        publishers["ekf"].publish(estimate("ekf", 2000, 500.0, TissueEstimate.CONVERGED))
        return bool(maps)

    running.wait_until(heard, "the first map")
    assert maps[0].header.stamp.nanosec == 2000
    for layer in ("stiffness", "damping", "covariance_trace", "stiffness_stddev"):
        assert np.isnan(np.delete(getattr(maps[0], layer), 4)).all()
    assert list(np.delete(maps[0].verdict, 4)) == [StiffnessMap.NOT_PALPATED] * 5


def test_the_verdicts_are_those_of_the_message():
    for verdict in CellVerdict:
        assert getattr(StiffnessMap, verdict.name) == verdict


def test_converged_estimates_are_fused_into_the_cell_of_the_site(mapped):
    running, maps, _, publishers = mapped
    converged = TissueEstimate.CONVERGED

    def value() -> float:
        # Sent again until the announcement, which comes on another topic, was heard.
        publishers["ekf"].publish(estimate("ekf", 2000, 500.0, converged))
        publishers["ukf"].publish(estimate("ukf", 2000, 600.0, converged))
        return maps[-1].stiffness[4] if maps else np.nan

    running.wait_until(lambda: value() == 550.0, "the cell")
    # Two estimators on the same samples are no more certain than one, and these differ by 100.
    assert maps[-1].stiffness_stddev[4] == np.hypot(2.0, 50.0)
    assert maps[-1].verdict[4] == StiffnessMap.MEASURED
    assert list(maps[-1].dwell_begin) == [0, 0, 0, 0, 1000, 0]
    assert np.isnan(np.delete(maps[-1].stiffness, 4)).all()
    assert (maps[-1].rows, maps[-1].columns, maps[-1].spacing) == (2, 3, 0.01)


def test_a_visit_is_told_with_its_place_and_error_for_late_joiners(mapped):
    running, maps, _, publishers = mapped

    def measured() -> bool:
        publishers["ekf"].publish(estimate("ekf", 2000, 500.0, TissueEstimate.CONVERGED))
        return bool(maps) and maps[-1].stiffness[4] == 500.0

    running.wait_until(measured, "the cell")
    told = collect(running.node, SiteResults, "/probe/sites", LATCHED)
    running.wait_until(lambda: bool(told), "the results, after they were published")
    (result,) = told[0].results
    assert (result.site, result.repeat, result.verdict) == (4, 0, StiffnessMap.MEASURED)
    assert (result.position.x, result.position.y) == GRID.position(4)[:2]
    assert (result.normal.x, result.normal.y, result.normal.z) == (0.0, 0.0, 1.0)
    assert (result.stiffness, result.stiffness_stddev) == (500.0, 2.0)
    assert (result.damping, result.damping_stddev) == (5.0, 0.1)


def test_a_place_that_is_visited_again_has_two_results_and_the_cloud_shows_both(mapped):
    running, maps, sites, publishers = mapped
    told = collect(running.node, SiteResults, "/probe/sites", LATCHED)
    clouds = collect(running.node, PointCloud2, "/probe/stiffness_cloud", LATCHED)
    publisher = publishers["ekf"]

    def measured(stamp: int, stiffness: float) -> bool:
        publisher.publish(estimate("ekf", stamp, stiffness, TissueEstimate.CONVERGED))
        return bool(maps) and maps[-1].stiffness[4] == stiffness

    running.wait_until(lambda: measured(2000, 500.0), "the cell")
    say(sites, 3000, 4, Phase.LIFTED)
    say(sites, 4000, 4, Phase.DWELL)
    running.wait_until(lambda: measured(5000, 520.0), "the cell again")
    say(sites, 6000, 4, Phase.LIFTED)
    running.wait_until(lambda: told and len(told[-1].results) == 2, "both results")
    assert [(one.repeat, one.stiffness) for one in told[-1].results] == [(0, 500.0), (1, 520.0)]
    running.wait_until(lambda: clouds and clouds[-1].header.stamp.nanosec == 4000, "the cloud")
    names = [field.name for field in clouds[-1].fields]
    assert names == ["x", "y", "z", "stiffness", "stiffness_stddev", "probability"]
    points = np.frombuffer(clouds[-1].data, np.float32).reshape(-1, len(names))
    middle = points[np.hypot(*(points[:, :2] - [0.01, 0.01]).T).argmin()]
    assert middle[3] == pytest.approx(510.0, rel=0.05)
    assert middle[4] > 0.0


def test_sites_on_no_grid_have_a_map(session):
    running = session(MAPPER)
    found = collect(running.node, Inclusions, "/probe/inclusions", LATCHED)
    marks = collect(running.node, MarkerArray, "/probe/inclusion_markers", LATCHED)
    sites = site_publisher(running.node)
    publisher = running.node.create_publisher(TissueEstimate, "/probe/ekf/estimate", SAMPLE_BLOCKS)
    both = (sites, publisher)
    running.wait_until(lambda: all(p.get_subscription_count() for p in both), "the mapper")
    rng = np.random.default_rng(2)
    places = rng.uniform(0.0, 0.03, (60, 2))
    for number, (x, y) in enumerate(places):
        begin = (number + 1) * 1_000_000
        position = (float(x), float(y), 0.001)
        for stamp, phase in ((begin, Phase.DWELL), (begin + 400_000, Phase.LIFTED)):
            sites.publish(site_to_message(PalpationSite(stamp, number, position, phase), "stage"))
    running.wait_until(lambda: sites.wait_for_all_acked(), "the announcements to arrive")
    for number, (x, y) in enumerate(places):
        k = 450.0 * (1.0 + 1.5 * 0.5 ** (((x - 0.012) ** 2 + (y - 0.017) ** 2) / 0.005**2))
        publisher.publish(estimate("ekf", (number + 1) * 1_000_000 + 300_000, k, 1))

    def sure() -> list:
        return [one for one in (found[-1].inclusions if found else []) if one.probability > 0.9]

    running.wait_until(lambda: len(sure()) == 1, "the inclusion")
    (one,) = sure()
    assert (one.position.x, one.position.y) == pytest.approx((0.012, 0.017), abs=0.001)
    assert one.position.z == pytest.approx(0.001)
    assert one.contrast == pytest.approx(2.5, rel=0.1)
    assert len(one.boundary_95) > 10
    running.wait_until(lambda: marks and len(marks[-1].markers) >= 4, "its markers")
    lines = [mark for mark in marks[-1].markers if mark.type == mark.LINE_STRIP]
    assert {mark.ns for mark in lines} == {"boundary_50", "boundary_95"}


def test_a_model_that_is_rejected_at_the_end_takes_the_value_out_of_the_cell(mapped):
    running, maps, _, publishers = mapped

    def verdict() -> int:
        publishers["ekf"].publish(estimate("ekf", 2000, 500.0, TissueEstimate.CONVERGED))
        publishers["ekf"].publish(estimate("ekf", 3000, 500.0, TissueEstimate.MODEL_REJECTED))
        return maps[-1].verdict[4] if maps else 0

    running.wait_until(lambda: verdict() == StiffnessMap.MODEL_REJECTED, "the verdict")
    assert np.isnan(maps[-1].stiffness).all()


def test_a_site_at_no_place_is_told_and_harms_nothing(mapped):
    running, maps, sites, publishers = mapped
    off = PalpationSite(5000, 5, (np.nan, 1.0, 0.0), Phase.DWELL)
    sites.publish(site_to_message(off, "stage"))
    running.wait_until(
        lambda: "an announcement is left out: (nan" in running.whole_log("mapper"), "the log"
    )

    def measured() -> bool:
        publishers["ekf"].publish(estimate("ekf", 2000, 500.0, TissueEstimate.CONVERGED))
        return bool(maps) and maps[-1].stiffness[4] == 500.0

    running.wait_until(measured, "the cell")


def end_recording(running) -> None:
    recorder = running.processes.pop("recorder")
    recorder.send_signal(signal.SIGINT)
    recorder.wait(20.0)


def told_of(results) -> list[str]:
    """Return results of sites as texts, in which NaN is like NaN."""
    names = ("site", "repeat", "stiffness", "stiffness_stddev", "damping", "damping_stddev")
    return [
        repr([int(one.verdict), *(float(getattr(one, name)) for name in names)]) for one in results
    ]


def numbers_of(message: Inclusions) -> list[tuple]:
    return [
        (message.background,),
        *(
            (
                *(one.position.x, one.position.y, one.probability, one.stiffness, one.contrast),
                *((point.x, point.y) for point in one.boundary_95),
            )
            for one in message.inclusions
        ),
    ]


def numbers_of_map(found: PosteriorMap) -> list[tuple]:
    return [
        (found.background.stiffness,),
        *(
            (
                *(one.x, one.y, one.probability, one.stiffness, one.contrast),
                *map(tuple, one.boundary_95.tolist()),
            )
            for one in found.inclusions
        ),
    ]


def test_live_and_recorded_map_of_any_grid_are_the_same(session, tmp_path):
    bag = tmp_path / "run.mcap"
    running = session(MAPPER, NodeProcess("recorder", "recorder", parameters={"output": str(bag)}))
    maps = collect(running.node, StiffnessMap, "/probe/stiffness_map", LATCHED)
    told = collect(running.node, SiteResults, "/probe/sites", LATCHED)
    inclusions = collect(running.node, Inclusions, "/probe/inclusions", LATCHED)
    clouds = collect(running.node, PointCloud2, "/probe/stiffness_cloud", LATCHED)
    sites = site_publisher(running.node)
    samples = running.node.create_publisher(ProbeSamples, "/probe/samples", SAMPLE_BLOCKS)
    publishers = {
        name: running.node.create_publisher(
            TissueEstimate, f"/probe/{name}/estimate", SAMPLE_BLOCKS
        )
        for name in ("ekf", "ukf")
    }
    everyone = [sites, *publishers.values()]
    running.wait_until(lambda: all(p.get_subscription_count() == 2 for p in everyone), "both")
    running.wait_until(lambda: samples.get_subscription_count() == 1, "the recorder")
    grid = Grid((0.001, -0.002, 0.0), 0.003, rows=4, columns=4)
    rng = np.random.default_rng(5)
    block = ProbeSamples(sample_period=5e-4, position=[0.0], force=[0.0], command=[0.0])
    block.header.stamp = to_time(1)
    samples.publish(block)
    for site in range(len(grid)):
        begin = (site + 1) * 1_000_000
        say(sites, begin - 500_000, site, Phase.APPROACH, grid)
        say(sites, begin, site, Phase.DWELL, grid)
        say(sites, begin + 400_000, site, Phase.LIFTED, grid)
    running.wait_until(lambda: sites.wait_for_all_acked(), "the announcements to arrive")
    for begin in range(1_000_000, 17_000_000, 1_000_000):
        for name, publisher in publishers.items():
            for step in range(1, 12):
                status = int(rng.choice([0, 1, 1, 1, 1, 2, 3, 4]))
                k = float(rng.normal(450.0, 30.0))
                publisher.publish(estimate(name, begin + 50_000 * step, k, status))
    publishers["ekf"].publish(estimate("ekf", 16_950_000, 450.0, 1))
    # The map has the stamp of the estimate that came last, and topics do not wait for one another.

    def received() -> int:
        return int(running.health.get("/probe/mapper", {}).get("estimates received", 0))

    running.wait_until(lambda: received() == 2 * 16 * 11 + 1, "all but one")
    publishers["ukf"].publish(estimate("ukf", 16_350_001, 450.0, 1))
    running.wait_until(lambda: maps and maps[-1].header.stamp.nanosec == 16_350_001, "all")
    arrived = [publisher.wait_for_all_acked() for publisher in everyone]
    assert all(arrived)
    end_recording(running)
    live, recorded = read_map(bag), read_recording(bag)
    off_line = tp.map(bag)
    running.wait_until(
        lambda: told and told_of(told[-1].results) == told_of(off_line.results),
        "the results, alike to the last bit",
    )
    running.wait_until(
        lambda: inclusions and numbers_of(inclusions[-1]) == numbers_of_map(off_line.map),
        "the inclusions, alike to the last bit",
    )
    surface = off_line.map.surface.mean
    drawn = surface[np.isfinite(surface)].astype(np.float32)

    def points() -> np.ndarray:
        return np.frombuffer(clouds[-1].data, np.float32).reshape(clouds[-1].width, -1)

    # The cloud before the last estimate has as many points.
    running.wait_until(
        lambda: clouds and clouds[-1].width == drawn.size and np.array_equal(points()[:, 3], drawn),
        "the cloud, alike to the last bit",
    )
    off_line = gather_sites(recorded, list(read_estimates(bag).values())).map()
    assert live.origin == off_line.grid.origin
    assert live.spacing == off_line.grid.spacing
    assert live.stamp == off_line.stamp
    assert set(live.verdict.ravel()) > {CellVerdict.MEASURED}
    for name in (
        "stiffness",
        "damping",
        "covariance_trace",
        "stiffness_stddev",
        "verdict",
        "dwell_begin",
    ):
        np.testing.assert_array_equal(getattr(live, name), getattr(off_line, name))


def test_a_mapper_started_again_in_a_scan_takes_up_its_cells(session, tmp_path):
    running = session(MAPPER)
    maps = collect(running.node, StiffnessMap, "/probe/stiffness_map", LATCHED)
    sites = site_publisher(running.node)
    publisher = running.node.create_publisher(TissueEstimate, "/probe/ekf/estimate", SAMPLE_BLOCKS)
    both = (sites, publisher)
    running.wait_until(lambda: all(p.get_subscription_count() for p in both), "the mapper")

    def palpate(site: int) -> None:
        begin = (site + 1) * 1_000_000
        say(sites, begin - 500_000, site, Phase.APPROACH)
        say(sites, begin, site, Phase.DWELL)

        def measured() -> bool:
            message = estimate("ekf", begin + 1000, 100.0 * (site + 1), TissueEstimate.CONVERGED)
            publisher.publish(message)
            return bool(maps) and 100.0 * (site + 1) in maps[-1].stiffness

        running.wait_until(measured, "the cell")
        say(sites, begin + 400_000, site, Phase.LIFTED)

    for site in range(3):
        palpate(site)
    before = sorted(k for k in maps[-1].stiffness if np.isfinite(k))
    (kept,) = (tmp_path / "tissue_probe").iterdir()
    running.wait_until(lambda: kept.read_text().count("\n") >= 3, "the results to be kept")
    running.processes["mapper"].kill()
    running.processes.pop("mapper").wait()
    del maps[:]
    # That the first one has gone is known only after DDS's lease, of 20 s: ask the second itself.
    again = session(MAPPER)
    again.wait_for_publishers({"/probe/mapper": len(both)})
    running.wait_until(lambda: bool(maps), "the map")
    assert sorted(k for k in maps[0].stiffness if np.isfinite(k)) == before
    palpate(3)
    assert sorted(k for k in maps[-1].stiffness if np.isfinite(k)) == [*before, 400.0]


def test_a_scan_that_dies_in_a_dwell_leaves_the_cell_as_it_was_then(mapped):
    """Where another's driver measures on: nobody tells of the end but the scan's silence."""
    running, maps, sites, publishers = mapped
    running.node.destroy_publisher(sites)
    begin, step, count = 10**9, 5_000_000, 0
    scan = running.node.create_publisher(
        PalpationSiteMessage, "/probe/palpation_site", SCAN_ANNOUNCEMENTS
    )
    running.wait_until(lambda: scan.get_subscription_count() == 2, "the mapper and its watch")
    say(scan, begin - 1000, 4, Phase.APPROACH)
    say(scan, begin, 4, Phase.DWELL)

    def measures(stiffness: float) -> None:
        nonlocal count
        message = estimate("ekf", begin + step * count, stiffness, TissueEstimate.CONVERGED)
        publishers["ekf"].publish(message)
        count += 1

    def shows(stiffness: float) -> bool:
        return bool(maps) and maps[-1].stiffness[4] == stiffness

    def in_contact() -> bool:
        for _ in range(5):
            measures(450.0)
        scan.assert_liveliness()
        return count > 200 and shows(450.0)

    running.wait_until(in_contact, "the cell")

    def dies() -> bool:
        measures(1046.0)
        return "the scan node fell silent in a dwell at site 4" in running.whole_log("mapper")

    running.wait_until(dies, "the mapper to notice")
    running.wait_until(lambda: shows(450.0), "the cell as it was")
    for _ in range(200):
        measures(1046.0)
    heard = count
    running.wait_until(
        lambda: int(running.health["/probe/mapper"]["estimates received"]) >= heard, "all"
    )
    assert shows(450.0)
