"""The estimator nodes: one node class, a filter by name, an estimate for each block of samples."""

from __future__ import annotations

import array

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from std_msgs.msg import Float64

from conftest import (
    collect,
    driver,
    estimator,
    fails_with,
    samples_publisher,
    site_publisher,
    stage_on_tissue,
)
from tissue_probe.configuration import stock_configuration
from tissue_probe.estimation import ESTIMATORS
from tissue_probe.nodes.conversions import from_time, samples_from_message, site_to_message
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.physics.phantom import Phantom
from tissue_probe.signals import NANOSECONDS, PalpationSite, Phase
from tissue_probe_msgs.msg import ProbeSamples, TissueEstimate

LIVE = ("robust_ekf", "ekf", "ukf", "afekf")


def connected(running, publisher, listeners: int) -> None:
    """Wait until the ekf hears the publisher, and is heard by so many listeners."""
    running.wait_until(lambda: publisher.get_subscription_count() == 1, "the estimator")
    running.wait_for_subscribers({"/probe/ekf": listeners})
    running.wait_for_publishers({"/probe/ekf": 1})


def block(sequence: int, values: list[float] | None = None, stamp: int = 0) -> ProbeSamples:
    values = array.array("d", values or [0.0] * 10)
    message = ProbeSamples(
        sequence=sequence, sample_period=0.0005, position=values, force=values, command=values
    )
    message.header.stamp.nanosec = stamp + sequence * 500_000
    return message


def health(running, received: list, node: str) -> DiagnosticStatus | None:
    statuses = [s for m in received for s in m.status if s.name == node]
    return statuses[-1] if statuses else None


def test_every_estimator_finds_the_tissue_and_publishes_an_estimate_for_each_block(session):
    running = session(driver(), stage_on_tissue(), *(estimator(name) for name in LIVE))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    estimates = {
        name: collect(running.node, TissueEstimate, f"/probe/{name}/estimate") for name in LIVE
    }
    values = {
        (name, value): collect(running.node, Float64, f"/probe/{name}/{value}")
        for name in LIVE
        for value in ("stiffness", "damping", "covariance_trace")
    }
    sites = site_publisher(running.node)
    running.activate({"/probe/driver": len(LIVE) + 1, **{f"/probe/{name}": 1 for name in LIVE}})
    running.wait_until(lambda: len(blocks) > 100, "samples, and the stage to have been heard")
    begin = samples_from_message(blocks[-1]).end + NANOSECONDS // 2
    dwell = PalpationSite(begin, 0, (0.0, 0.0, 0.0), Phase.DWELL)
    sites.publish(site_to_message(dwell, "stage"))
    running.wait_until(lambda: from_time(blocks[-1].header.stamp) > begin + NANOSECONDS, "a dwell")
    count = len(blocks)
    running.wait_until(lambda: all(len(e) >= count for e in estimates.values()), "estimates")
    running.wait_until(lambda: all(len(v) >= count for v in values.values()), "values")
    phantom = Phantom.load(stock_configuration("phantom.yaml"))
    for name in LIVE:
        for sent, estimate in zip(blocks[:count], estimates[name][:count], strict=True):
            last = sent.sequence + len(sent.position) - 1
            assert estimate.sequence == last
            assert from_time(estimate.header.stamp) == from_time(sent.header.stamp) + 4_500_000
            assert estimate.estimator == name
        last = estimates[name][count - 1]
        assert last.status == TissueEstimate.CONVERGED
        assert last.stiffness == pytest.approx(float(phantom.stiffness(0.0, 0.0)), rel=0.02)
        assert last.damping == pytest.approx(float(phantom.damping(0.0, 0.0)), rel=0.05)
        for value in ("stiffness", "damping", "covariance_trace"):
            assert values[name, value][count - 1].data == getattr(last, value)


def test_tissue_of_a_table_made_elsewhere_is_found_live(session, tmp_path):
    table = tmp_path / "felt.csv"
    table.write_text("x,y,k,beta\n0,0,300,2\n0.04,0,900,10\n0,0.04,300,2\n")
    running = session(
        driver(simulated__phantom=str(table)), stage_on_tissue(0.02, 0.01), estimator("ekf")
    )
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    estimates = collect(running.node, TissueEstimate, "/probe/ekf/estimate")
    sites = site_publisher(running.node)
    running.activate({"/probe/driver": 2, "/probe/ekf": 1})
    running.wait_until(lambda: len(blocks) > 100, "samples, and the stage to have been heard")
    begin = samples_from_message(blocks[-1]).end + NANOSECONDS // 2
    dwell = PalpationSite(begin, 0, (0.02, 0.01, 0.0), Phase.DWELL)
    sites.publish(site_to_message(dwell, "stage"))
    end = begin + NANOSECONDS
    running.wait_until(lambda: from_time(estimates[-1].header.stamp) > end, "a dwell")
    assert estimates[-1].status == TissueEstimate.CONVERGED
    assert estimates[-1].stiffness == pytest.approx(600.0, rel=0.02)
    assert estimates[-1].damping == pytest.approx(6.0, rel=0.05)


def test_an_unknown_filter_is_refused_with_the_names_of_those_there_are():
    said = fails_with(NodeProcess("estimator", "magic", parameters={"estimator": "magic"}))
    for name in ESTIMATORS:
        assert name in said


def test_a_setting_out_of_range_is_refused_with_its_unit():
    said = fails_with(estimator("ekf", force_noise=-1.0))
    assert "force_noise" in said
    assert "[N]" in said


def test_a_malformed_block_is_left_out_and_the_node_goes_on(session):
    running = session(estimator("ekf"))
    estimates = collect(running.node, TissueEstimate, "/probe/ekf/estimate")
    publisher = samples_publisher(running.node)
    connected(running, publisher, listeners=1)
    publisher.publish(block(0))
    wrong = block(10)
    wrong.force = array.array("d", [0.0] * 9)
    publisher.publish(wrong)
    publisher.publish(block(20))
    running.wait_until(lambda: len(estimates) == 2, "both good blocks")
    assert [estimate.sequence for estimate in estimates] == [9, 29]
    running.wait_until(lambda: "a block is left out" in running.whole_log("ekf"), "the log")


def test_samples_that_are_no_numbers_leave_every_estimate_a_number(session):
    running = session(estimator("ekf"))
    estimates = collect(running.node, TissueEstimate, "/probe/ekf/estimate")
    publisher = samples_publisher(running.node)
    connected(running, publisher, listeners=1)
    publisher.publish(block(0))
    publisher.publish(block(10, [float("nan")] * 5 + [float("inf")] * 5))
    publisher.publish(block(20))
    running.wait_until(lambda: len(estimates) == 3, "all blocks")
    for estimate in estimates:
        assert abs(estimate.stiffness) < 1e6
        assert estimate.stiffness_variance > 0.0


def test_lost_samples_are_counted_and_told(session):
    running = session(estimator("ekf"))
    received = collect(running.node, DiagnosticArray, "/diagnostics")
    publisher = samples_publisher(running.node)
    connected(running, publisher, listeners=0)
    for sequence in (0, 10, 50):
        publisher.publish(block(sequence))

    def told() -> bool:
        status = health(running, received, "/probe/ekf")
        return status is not None and status.level == DiagnosticStatus.WARN

    running.wait_until(told, "the warning")
    values = {v.key: v.value for v in health(running, received, "/probe/ekf").values}
    assert values["samples received"] == "30"
    assert values["samples lost"] == "30"


def test_a_repeated_block_gives_no_second_estimate(session):
    running = session(estimator("ekf"))
    estimates = collect(running.node, TissueEstimate, "/probe/ekf/estimate")
    publisher = samples_publisher(running.node)
    connected(running, publisher, listeners=1)
    for sequence in (0, 10, 10, 20):
        publisher.publish(block(sequence))
    running.wait_until(lambda: len(estimates) >= 3, "the estimates")
    assert [estimate.sequence for estimate in estimates] == [9, 19, 29]


def test_two_drivers_on_one_topic_are_told(session):
    running = session(estimator("ekf"))
    received = collect(running.node, DiagnosticArray, "/diagnostics")
    publishers = [samples_publisher(running.node) for _ in range(2)]
    assert len(publishers) == 2

    def told() -> bool:
        status = health(running, received, "/probe/ekf")
        return status is not None and status.level == DiagnosticStatus.ERROR

    running.wait_until(told, "the error")
    assert "several nodes publish samples" in health(running, received, "/probe/ekf").message
