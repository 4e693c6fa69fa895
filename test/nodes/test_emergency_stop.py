"""Emergency stop, fault and reset of the driver, as others in the graph see them."""

from __future__ import annotations

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from lifecycle_msgs.msg import State, Transition
from std_msgs.msg import Bool, String
from std_srvs.srv import Trigger

from conftest import activate, ask, change_state, collect, deactivate, driver, state_of
from tissue_probe.nodes.conversions import samples_from_message
from tissue_probe.nodes.qos import LATCHED, POSES
from tissue_probe.signals import join
from tissue_probe_msgs.msg import ProbeSamples


def call(running, service: str) -> Trigger.Response:
    return ask(running, Trigger, f"/probe/{service}")


def stop_by_service(running) -> str:
    response = call(running, "emergency_stop")
    assert response.success
    return "the service emergency_stop was called"


def stop_by_topic(running) -> str:
    publisher = running.node.create_publisher(Bool, "/probe/emergency_stop", POSES)
    running.wait_until(lambda: publisher.get_subscription_count() > 0, "the driver")
    publisher.publish(Bool(data=True))
    return "true came on the topic emergency_stop"


@pytest.mark.parametrize("stop", [stop_by_service, stop_by_topic])
def test_an_emergency_stop_ends_the_samples_says_why_and_holds_until_the_reset(session, stop):
    running = session(driver())
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    health = collect(running.node, DiagnosticArray, "/diagnostics")
    activate(running)
    running.wait_until(lambda: len(blocks) >= 20, "samples")
    reason = stop(running)
    running.wait_until(lambda: state_of(running) == State.PRIMARY_STATE_INACTIVE, "inactivity")
    running.wait_until(lambda: faults and reason in faults[-1].data, "the reason")
    assert faults[0].data == ""
    running.wait_until(
        lambda: any(
            status.level == DiagnosticStatus.ERROR and status.message.startswith("FAULT: ")
            for array in health
            for status in array.status
            if reason in status.message
        ),
        "diagnostics",
    )
    assert len(join(samples_from_message(block) for block in blocks)) == 1
    count = len(blocks)
    assert not change_state(running, Transition.TRANSITION_ACTIVATE)
    assert "first call the service reset" in running.whole_log("driver")
    assert change_state(running, Transition.TRANSITION_CLEANUP)
    assert change_state(running, Transition.TRANSITION_CONFIGURE)
    assert not change_state(running, Transition.TRANSITION_ACTIVATE)  # a new device, an old fault
    assert len(blocks) == count
    assert reason in call(running, "reset").message
    running.wait_until(lambda: faults[-1].data == "", "the end of the fault")
    assert change_state(running, Transition.TRANSITION_ACTIVATE)
    running.wait_until(lambda: len(blocks) >= count + 20, "samples")
    refused = call(running, "reset")
    assert not refused.success
    assert "deactivate it first" in refused.message
    deactivate(running)


def test_an_emergency_stop_counts_before_there_is_a_device(session):
    running = session(driver())
    stop_by_service(running)
    assert change_state(running, Transition.TRANSITION_CONFIGURE)
    assert not change_state(running, Transition.TRANSITION_ACTIVATE)
    call(running, "reset")
    assert change_state(running, Transition.TRANSITION_ACTIVATE)


def test_false_on_the_topic_neither_stops_nor_resets(session):
    running = session(driver())
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    publisher = running.node.create_publisher(Bool, "/probe/emergency_stop", POSES)
    activate(running)
    running.wait_until(lambda: publisher.get_subscription_count() > 0, "the driver")
    publisher.publish(Bool(data=False))
    count = len(blocks)
    running.wait_until(lambda: len(blocks) >= count + 50, "samples")
    assert [fault.data for fault in faults] == [""]
    stop_by_topic(running)
    running.wait_until(lambda: faults[-1].data != "", "the fault")
    publisher.publish(Bool(data=False))
    running.wait_until(lambda: state_of(running) == State.PRIMARY_STATE_INACTIVE, "inactivity")
    assert not change_state(running, Transition.TRANSITION_ACTIVATE)


def test_the_samples_that_passed_a_limit_are_published_and_the_last(session):
    running = session(driver(limits__travel_limit=0.0005, block_size=7))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    running.wait_until(lambda: state_of(running) == State.PRIMARY_STATE_INACTIVE, "inactivity")
    running.wait_until(
        lambda: max(abs(position) for position in blocks[-1].position) > 0.0005, "the reason"
    )
    run = join(samples_from_message(block) for block in blocks)
    assert len(run) == 1
    assert abs(run[0].position[:-7]).max() <= 0.0005
