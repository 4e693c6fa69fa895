"""No message ends a node: whatever comes on any topic, all go on with their work."""

from __future__ import annotations

import math
from collections.abc import Iterator

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from lifecycle_msgs.msg import State
from rcl_interfaces.msg import ParameterEvent
from rclpy.serialization import serialize_message
from std_msgs.msg import String

from conftest import (
    PATIENT,
    Scanning,
    activate,
    collect,
    deactivate,
    driver,
    estimator,
    goal,
    stage_on_tissue,
    state_of,
)
from crtk_msgs.msg import OperatingState, StringStamped
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATCHED, POSES, SAMPLE_BLOCKS
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.recording.bags.reader import read_recording
from tissue_probe.signals import MOST_SAMPLES
from tissue_probe_msgs.msg import PalpationSite, ProbeSamples, StiffnessMap, TissueEstimate

LAST_SECOND = 2**31 - 1
NO_NUMBERS = (math.nan, math.inf, -1e300, 1e308)


def damaged(message) -> Iterator[bytes]:
    """Bytes that are no message of this type: cut off, or senseless."""
    sound = bytes(serialize_message(message))
    yield from (b"", sound[:3], sound[:-2], sound[: len(sound) // 2])
    yield sound[:4] + b"\xff" * (len(sound) - 4)


def block(**changes: object) -> ProbeSamples:
    values = [0.0] * 10
    message = ProbeSamples(sample_period=5e-4, position=values, force=values, command=values)
    for name, value in changes.items():
        setattr(message, name, value)
    return message


def late(message):
    """The message, at the end of what a ROS time can say."""
    message.header.stamp.sec, message.header.stamp.nanosec = LAST_SECOND, 2**32 - 1
    return message


def samples() -> Iterator[object]:
    yield from (block(sample_period=period) for period in (1e300, 1e9, 0.0, -1.0, math.nan, 5e-324))
    yield from (block(sequence=number) for number in (2**63, 2**63 - 5, 2**64 - 1))
    yield from (late(block()), block(force=[0.0] * 9), block(position=[]), ProbeSamples())
    yield block(**dict.fromkeys(("position", "force", "command"), [0.0] * (MOST_SAMPLES + 1)))
    yield from damaged(block())
    yield b"\x00\x00" + bytes(serialize_message(block()))[2:]  # of the other byte order


def sites() -> Iterator[object]:
    yield PalpationSite(phase=99)
    yield late(PalpationSite(phase=PalpationSite.DWELL))
    for value in NO_NUMBERS:
        message = PalpationSite(phase=PalpationSite.DWELL)
        message.position.x = value
        yield message
    yield from damaged(PalpationSite())


def estimates() -> Iterator[object]:
    yield TissueEstimate(estimator="ekf", status=99)
    for status in (TissueEstimate.CONVERGED, TissueEstimate.MODEL_REJECTED):
        yield late(TissueEstimate(estimator="ekf", status=status, stiffness=math.nan))
    yield from damaged(TissueEstimate(estimator="ekf"))


def poses() -> Iterator[object]:
    for value in NO_NUMBERS:
        for axis in "xyz":
            message = PoseStamped()
            setattr(message.pose.position, axis, value)
            yield message
    turned = PoseStamped()
    turned.pose.orientation.w = math.nan
    yield turned
    yield from damaged(PoseStamped())


def words() -> Iterator[object]:
    yield from (StringStamped(string=word) for word in ("", "explode", "\x00", "ä" * 10_000))
    yield from damaged(StringStamped(string="enable"))


#: What is said on each topic that a node of the suite hears; none of it is what it should be. But
#: for emergency_stop: there the middleware may read damaged bytes as true, which is the safe side.
FLOOD = {
    "/probe/samples": (ProbeSamples, SAMPLE_BLOCKS, samples),
    "/probe/palpation_site": (PalpationSite, ANNOUNCEMENTS, sites),
    "/probe/ekf/estimate": (TissueEstimate, SAMPLE_BLOCKS, estimates),
    "/stage/servo_cp": (PoseStamped, POSES, poses),
    "/stage/measured_cp": (PoseStamped, POSES, poses),
    "/stage/operating_state": (OperatingState, LATCHED, lambda: damaged(OperatingState())),
    "/probe/state_command": (StringStamped, POSES, words),
    "/stage/state_command": (StringStamped, POSES, words),
    "/parameter_events": (ParameterEvent, 100, lambda: damaged(ParameterEvent(node="/probe/x"))),
    "/probe/stiffness_map": (StiffnessMap, LATCHED, lambda: damaged(StiffnessMap())),
}


def as_bytes(message) -> bytes:
    return message if isinstance(message, bytes) else bytes(serialize_message(message))


class Flood:
    """Publishers of everything above."""

    def __init__(self, node) -> None:
        self._said = [
            (node.create_publisher(kind, topic, qos), list(map(as_bytes, make())))
            for topic, (kind, qos, make) in FLOOD.items()
        ]

    def heard(self) -> bool:
        return all(publisher.get_subscription_count() for publisher, _ in self._said)

    def go_on(self) -> None:
        for publisher, messages in self._said:
            for message in messages:
                publisher.publish(message)


def test_a_flood_of_malformed_messages_ends_no_node_and_no_scan(session, bag):
    running = session(
        driver(),
        stage_on_tissue(),
        NodeProcess("scan", "scan", parameters={**PATIENT, "lift_height": 0.002}),
        estimator("ekf"),
        NodeProcess("estimators", "estimators", parameters={"estimators": ["robust_ekf"]}),
        NodeProcess("mapper", "mapper", parameters={"estimators": ["ekf", "robust_ekf"]}),
        NodeProcess("recorder", "recorder", parameters={"output": str(bag)}),
    )
    told = collect(running.node, DiagnosticArray, "/diagnostics")
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    found = collect(running.node, TissueEstimate, "/probe/ekf/estimate")
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    activate(running)
    flood = Flood(running.node)
    running.wait_until(flood.heard, "everyone to hear the flood")
    running.wait_until(lambda: len(blocks) > 10, "samples")

    def values_of(node: str) -> dict[str, str]:
        statuses = [status for message in told for status in message.status if status.name == node]
        return {value.key: value.value for value in statuses[-1].values} if statuses else {}

    def counts(node: str, value: str, more_than: int) -> bool:
        return int(values_of(node).get(value, 0)) > more_than

    scan = Scanning(running, goal(dwell_time=1.0)).handle.get_result_async()
    last = 0

    def flooded() -> bool:
        nonlocal last
        if len(blocks) > last + 50:  # four times a second
            last = len(blocks)
            flood.go_on()
        return scan.done()

    running.wait_until(flooded, "the scan to go through the flood")
    result = scan.result().result
    assert result.sites_visited == 2, result.message
    assert state_of(running) == State.PRIMARY_STATE_ACTIVE, faults
    for node, counted in {
        "/probe/driver": "stage poses malformed",
        "/probe/scan": "messages malformed",
        "/probe/ekf": "messages malformed",
        "/probe/robust_ekf": "messages malformed",
    }.items():
        running.wait_until(lambda n=node, c=counted: counts(n, c, 0), f"the count of {node}")
    # All of them still do what they are for.
    estimated, recorded = len(found), int(values_of("/probe/recorder")["messages recorded"])
    mapped = int(values_of("/probe/mapper")["estimates received"])
    running.wait_until(lambda: len(found) > estimated + 100, "estimates after the flood")
    running.wait_until(
        lambda: (
            counts("/probe/mapper", "estimates received", mapped + 100)
            and counts("/probe/recorder", "messages recorded", recorded + 100)
        ),
        "mapper and recorder after the flood",
    )
    assert values_of("/probe/ekf")["samples lost"] == "0"
    deactivate(running)
    running._end()
    assert [process.returncode for process in running.processes.values()] == [0] * 7
    recording = read_recording(bag)
    assert len(recording.blocks) == 1
    assert {site.phase for site in recording.sites} == {0, 1, 2}
