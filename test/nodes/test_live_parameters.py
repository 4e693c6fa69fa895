"""Parameters that may change while a node runs take effect; others are refused, with the reason."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from lifecycle_msgs.msg import Transition
from rcl_interfaces.srv import DescribeParameters
from rclpy.serialization import serialize_message
from std_msgs.msg import String

from conftest import (
    activate,
    ask,
    change_state,
    collect,
    deactivate,
    driver,
    set_parameter,
    stage_on_tissue,
)
from tissue_probe.nodes.conversions import samples_to_message
from tissue_probe.nodes.qos import LATCHED
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.recording.bags.definitions import message_definition
from tissue_probe.recording.writing.writer import McapWriter
from tissue_probe.signals import NANOSECONDS, SampleBlock
from tissue_probe_msgs.msg import ProbeSamples

SAMPLES = "tissue_probe_msgs/msg/ProbeSamples"


def test_a_limit_lowered_below_the_motion_stops_the_coil(session):
    running = session(driver())
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    activate(running)
    assert set_parameter(running, "/probe/driver", "limits.travel_limit", 1e-4) == (True, "")
    running.wait_until(lambda: bool(faults) and bool(faults[-1].data), "the trip")
    assert "beyond its limit of 0.0001 m" in faults[-1].data


def test_the_excitation_changes_while_inactive_and_not_while_it_is_on_the_coil(session):
    running = session(driver())
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    accepted, reason = set_parameter(running, "/probe/driver", "excitation.amplitude", 0.2)
    assert not accepted
    assert reason == "excitation.amplitude holds from activation on: deactivate first"
    deactivate(running)
    assert set_parameter(running, "/probe/driver", "excitation.amplitude", 0.2)[0]
    blocks.clear()
    assert change_state(running, Transition.TRANSITION_ACTIVATE)
    running.wait_until(lambda: len(blocks) > 60, "samples")
    highest = max(max(block.command) for block in blocks)
    assert highest == pytest.approx(0.2, rel=0.01)


def test_what_would_not_take_effect_is_refused(session):
    running = session(driver())
    activate(running)
    for name, value, said in (
        ("simulated.force_noise", 0.1, "holds from configuration on: deactivate and clean up"),
        ("block_size", 20, "holds from configuration on: deactivate and clean up"),
        ("calibration", "{}", "is told by the driver, not set"),
    ):
        accepted, reason = set_parameter(running, "/probe/driver", name, value)
        assert not accepted, name
        assert said in reason


def test_the_device_may_be_set_before_it_is_configured(session):
    running = session(driver(), stage_on_tissue())
    assert set_parameter(running, "/probe/driver", "simulated.force_noise", 0.1)[0]
    assert set_parameter(running, "/probe/driver", "block_size", 20)[0]
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    running.wait_until(lambda: bool(blocks), "samples")
    assert len(blocks[0].force) == 20


def test_the_rate_of_a_replay_changes_at_once(session, bag):
    with McapWriter(bag, {}) as writer:
        definition = message_definition(SAMPLES, [Path(sys.prefix, "share")])
        channel = writer.add_topic("/probe/samples", SAMPLES, definition, "")
        for sequence, log_time in ((0, 1), (10, 20 * NANOSECONDS)):
            block = SampleBlock(log_time, sequence, 0.0005, *np.zeros((3, 10)))
            message = serialize_message(samples_to_message(block, "probe"))
            writer.write(channel, log_time, log_time, message)
    # At this rate the second block is 2000 s away.
    slow = {"bag": str(bag), "rate": 0.01, "loop": True}
    running = session(NodeProcess("replay", "replay", parameters=slow))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    running.wait_until(lambda: running.node.count_publishers("/probe/samples") == 1, "the replay")
    assert set_parameter(running, "/probe/replay", "rate", 1000.0) == (True, "")
    running.wait_until(lambda: any(block.sequence == 10 for block in blocks), "the second block")


def test_what_holds_for_a_whole_run_is_declared_read_only(session):
    running = session(NodeProcess("scan", "scan"))
    wanted = DescribeParameters.Request(names=["robot", "lift_height"])
    answer = ask(running, DescribeParameters, "/probe/scan/describe_parameters", wanted)
    robot, lift_height = answer.descriptors
    assert robot.read_only
    assert not lift_height.read_only
    assert set_parameter(running, "/probe/scan", "lift_height", 0.002) == (True, "")
    accepted, reason = set_parameter(running, "/probe/scan", "lift_height", -1.0)
    assert not accepted
    assert reason
