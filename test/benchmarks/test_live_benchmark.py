"""The benchmark measures what it says: nothing here asserts a time, which others could spoil."""

import json
from io import StringIO
from itertools import count

import pytest
from domain_coordinator import domain_id
from rich.console import Console

from benchmarks import live, machine, offline, report
from benchmarks.suite import ESTIMATORS
from tissue_probe.recording.bags.summary import summarize

NODES = ("driver", "mapper", "recorder")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("benchmark")


@pytest.fixture(scope="module")
def results(folder):
    with domain_id(count(95).__next__) as domain, pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(domain))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        patch.setattr(live, "SETTLING", 0.5)
        patch.setattr(offline, "REPETITIONS", 1)
        return {
            "machine": machine.describe(),
            "live": live.measure(folder, 1.0),
            "offline": offline.measure(folder / "run.mcap"),
        }


def counted(run, node, what="samples"):
    return next(row for row in run["counts"] if (row["node"], row["what"]) == (node, what))


@pytest.mark.parametrize("mode", ["apart", *report.MODES])
def test_every_node_receives_every_message(results, mode):
    run = results["live"][mode]
    for row in run["counts"]:
        assert row["lost"] == 0, row
        assert row["received"] == row["published"] > 500, row
    assert {row["node"] for row in run["counts"]} >= {*ESTIMATORS, "mapper", "recorder"}


def test_the_subscriber_gets_every_sample_by_itself(results):
    run = results["live"]["with_subscriber"]
    each = counted(run, "subscriber", "singles")
    assert each["lost"] == 0
    assert 0.5 * counted(run, "ekf")["published"] < each["published"]


def test_latency_counts_from_the_last_and_from_the_first_sample_of_a_block(results):
    for latency in results["live"]["alone"]["latency"].values():
        assert 0.0 < latency["p50_ms"] <= latency["p99_ms"] <= latency["max_ms"]
        assert latency["first_p99_ms"] - latency["p99_ms"] == pytest.approx(4.5)


def test_cpu_and_memory_are_known_of_every_process(results):
    run = results["live"]["with_subscriber"]
    for unit in ("cpu_cores", "memory_megabytes"):
        assert set(run[unit]) == {*NODES, "estimators", "stage", "subscriber"}
        assert all(value > 0.0 for value in run[unit].values())
    assert set(results["live"]["apart"]["cpu_cores"]) == {*NODES, *ESTIMATORS, "stage"}


def test_apart_every_number_of_an_estimate_is_recorded_by_itself_and_else_none(results, folder):
    def topics(bag):
        return {topic.name for topic in summarize(folder / bag).topics}

    numbers = {
        f"/probe/{estimator}/{value}"
        for estimator in ESTIMATORS
        for value in ("stiffness", "damping", "covariance_trace")
    }
    assert numbers <= topics("run_apart.mcap")
    assert not numbers & topics("run.mcap")


def test_every_filter_is_timed_off_line(results):
    found = results["offline"]
    assert found["recording_seconds"] > 1.0
    assert set(found["warm_seconds"]) == {"read", *ESTIMATORS}
    assert set(found["command_seconds"]) == set(ESTIMATORS)


def test_the_file_holds_the_results_and_the_tables_show_them(results, folder):
    path = report.keep(results, folder)
    assert json.loads(path.read_text()) == results
    console = Console(width=80, file=StringIO())
    report.show(results, console)
    shown = console.file.getvalue()
    for title in (
        "Machine",
        "Messages",
        "latency in ms",
        "Processor",
        "both ways",
        "Off line",
        "Targets",
    ):
        assert title in shown
    assert str(counted(results["live"]["alone"], "ekf")["published"]) in shown
    assert "…" not in shown
