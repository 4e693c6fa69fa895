"""Several estimators in one process: each says what it says alone."""

from __future__ import annotations

import numpy as np
import pytest
from rclpy.parameter_client import AsyncParameterClient
from std_msgs.msg import Float64

from conftest import collect, fails_with, samples_publisher, site_publisher
from tissue_probe.nodes.conversions import samples_to_message, site_to_message
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.signals import PalpationSite, Phase, SampleBlock
from tissue_probe_msgs.msg import TissueEstimate

TOGETHER = ["robust_ekf", "ekf"]


def estimators(names: list[str]) -> NodeProcess:
    return NodeProcess("estimators", "estimators", parameters={"estimators": names})


def alone(name: str) -> NodeProcess:
    """The same filter in a process and a namespace of its own."""
    return NodeProcess("estimator", name, "/alone", parameters={"estimator": name})


def test_estimators_that_share_a_process_say_bit_for_bit_what_they_say_alone(session):
    running = session(estimators(TOGETHER), *(alone(name) for name in TOGETHER))
    found = {
        (namespace, name): collect(running.node, TissueEstimate, f"/{namespace}/{name}/estimate")
        for namespace in ("probe", "alone")
        for name in TOGETHER
    }
    topics = ("/probe", "/alone")
    samples = [samples_publisher(running.node, namespace) for namespace in topics]
    sites = [site_publisher(running.node, namespace) for namespace in topics]
    names = [f"/{namespace}/{name}" for namespace, name in found]
    running.wait_for_subscribers(dict.fromkeys(names, 1))
    running.wait_for_publishers(dict.fromkeys(names, 2))
    running.wait_until(
        lambda: [each.get_subscription_count() for each in (*samples, *sites)] == [1, 2, 1, 2],
        "the estimators",
    )
    generator = np.random.default_rng(0)
    time = np.arange(4000) * 5e-4
    position = 1e-3 * np.sin(2 * np.pi * 10 * time) + 1e-6 * generator.normal(size=4000)
    # The tip, behind the load cell, follows the coil as one with this tissue does at 10 Hz.
    tissue = 460.0 * 9700.0 / (9700.0 - 460.0) + 0.04 * (2 * np.pi * 10) ** 2
    force = 460.0 * position + 5e-3 * generator.normal(size=4000)
    whole = SampleBlock(10**18, 0, 5e-4, position, force, np.zeros(4000))
    dwell = PalpationSite(10**18 + 10**9 + 123, 0, (0.0, 0.0, 0.0), Phase.DWELL)
    for publisher in sites:
        publisher.publish(site_to_message(dwell, "stage"))
    # The site's announcement must be there before the samples that it is for.
    for half, due in ((range(0, 2000, 10), 200), (range(2000, 4000, 10), 400)):
        for first in half:
            for publisher in samples:
                publisher.publish(samples_to_message(whole[first : first + 10], "probe"))
        running.wait_until(
            lambda due=due: all(len(each) == due for each in found.values()), "all estimates"
        )
    for name in TOGETHER:
        assert found["probe", name] == found["alone", name]
        assert found["probe", name][-1].stiffness == pytest.approx(tissue, rel=0.02)


def test_each_keeps_its_own_parameters(session, tmp_path):
    file = tmp_path / "parameters.yaml"
    file.write_text("/**/robust_ekf: {ros__parameters: {restart_at_site: false}}\n")
    with_file = NodeProcess("estimators", "estimators", parameters={"estimators": TOGETHER})
    running = session(with_file, parameter_file=file)
    answers = []
    for name in TOGETHER:
        client = AsyncParameterClient(running.node, f"/probe/{name}")
        running.wait_until(client.services_are_ready, name)
        answers.append(client.get_parameters(["restart_at_site", "estimator"]))
        running.wait_until(answers[-1].done, "its parameters")
    values = [answer.result().values for answer in answers]
    assert [restart.bool_value for restart, _ in values] == [False, True]
    assert [estimator.string_value for _, estimator in values] == TOGETHER


def test_numbers_go_out_one_by_one_only_to_who_subscribes(session):
    running = session(estimators(TOGETHER))
    estimates = collect(running.node, TissueEstimate, "/probe/ekf/estimate")
    damping = collect(running.node, Float64, "/probe/ekf/damping")
    samples = samples_publisher(running.node)
    running.wait_for_subscribers({"/probe/ekf": 1})
    running.wait_for_publishers({"/probe/ekf": 1})
    running.wait_until(
        lambda: running.node.count_publishers("/probe/ekf/damping") == 1, "its numbers"
    )
    sequence = 0

    def heard() -> bool:
        nonlocal sequence
        block = SampleBlock(500_000 * sequence, sequence, 5e-4, *np.zeros((3, 10)))
        samples.publish(samples_to_message(block, "probe"))
        sequence += 10
        return len(damping) >= 10

    running.wait_until(heard, "numbers")
    assert damping[-1].data in [estimate.damping for estimate in estimates]


@pytest.mark.parametrize(
    ("names", "said"), [(["magic"], "robust_ekf"), (["ekf", "ekf"], "each only once")]
)
def test_a_wrong_list_of_estimators_is_refused_with_what_is_right(names, said):
    assert said in fails_with(estimators(names))
