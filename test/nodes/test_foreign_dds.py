"""A DDS client that shares no code with our stack hears every sample: Eclipse Cyclone DDS."""

from __future__ import annotations

import json

import numpy as np
import pytest
from geometry_msgs.msg import WrenchStamped
from std_msgs.msg import Float64

from conftest import (
    PATIENCE,
    collect,
    deactivate,
    driver,
    estimator,
    foreign_process,
    stage_on_tissue,
)
from tissue_probe.nodes.conversions import samples_from_message
from tissue_probe.signals import join
from tissue_probe_msgs.msg import ProbeSamples


@pytest.fixture
def foreign():
    """Start the foreign client."""
    with foreign_process("foreign_client.py") as client:
        yield client


def test_a_foreign_client_receives_every_sample_and_every_estimate(session, foreign):
    running = session(driver(), stage_on_tissue(), estimator("ekf"))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    stiffness = collect(running.node, Float64, "/probe/ekf/stiffness")
    # Beside the foreign client nobody listens to measured_cf.
    running.activate({"/probe/driver": 2}, {"/probe/ekf": 1})
    running.wait_until(
        lambda: (
            running.node.count_subscribers("/probe/measured_cf") == 1
            and running.node.count_subscribers("/probe/ekf/stiffness") == 2
        ),
        "the foreign client",
    )
    found = len(blocks)
    running.wait_until(lambda: len(blocks) > found + 600, "three seconds of samples")
    deactivate(running)
    sent = join(samples_from_message(block) for block in blocks)[0]
    running.wait_until(
        lambda: running.health["/probe/ekf"]["samples received"] == str(len(sent)), "the estimates"
    )
    heard, _ = foreign.communicate("stop\n", timeout=PATIENCE)
    received = json.loads(heard)

    begin = int(np.searchsorted(sent.stamps, received["stamps"][0]))
    assert len(received["stamps"]) > 4000
    assert received["stamps"] == sent.stamps[begin:].tolist()
    assert received["forces"] == sent.force[begin:].tolist()
    # Both have every value from the moment that they were found; that moment differs.
    values = [message.data for message in stiffness]
    common = min(len(values), len(received["stiffness"]))
    assert common > 400
    assert received["stiffness"][-common:] == values[-common:]


def test_the_foreign_type_names_are_those_of_ros(graph):
    """The names on the wire, which a foreign client must know, are fixed by ROS 2."""
    graph.node.create_publisher(WrenchStamped, "measured_cf", 10)
    info = graph.node.get_publishers_info_by_topic("/probe/measured_cf")[0]
    assert info.topic_type == "geometry_msgs/msg/WrenchStamped"
