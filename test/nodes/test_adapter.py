"""Samples of a robot that shares no code with us: its pose and wrench over Eclipse Cyclone DDS."""

from __future__ import annotations

from collections.abc import Iterator

import foreign_presser as presser
import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition

from conftest import (
    PATIENCE,
    change_state,
    collect,
    driver,
    estimator,
    fails_with,
    foreign_process,
    samples_publisher,
    tell,
)
from tissue_probe.nodes.conversions import samples_from_message
from tissue_probe.nodes.qos import SAMPLE_BLOCKS
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.bags.reader import read_recording
from tissue_probe.recording.layout import Layout
from tissue_probe.signals import Status
from tissue_probe_msgs.msg import ProbeSamples, TissueEstimate

ROBOT = {
    "position_rate": presser.POSE_RATE,
    "force_rate": presser.WRENCH_RATE,
    "force_polarity": "tension",
    "force_rotation": list(presser.ROTATION),
    "zero": list(presser.TOUCH),
}
RIGID = {"rig": "rigid_probe", "tip_mass": 0.0, "restart_at_site": False}


def adapter(**parameters: object) -> NodeProcess:
    return NodeProcess("adapter", "adapter", parameters={**ROBOT, **parameters})


@pytest.fixture(params=["reliable", "best effort"])
def quality(request, monkeypatch) -> str:
    """How the robot that is started next publishes."""
    if request.param == "best effort":
        monkeypatch.setenv("BEST_EFFORT", "1")
    return request.param


@pytest.fixture
def robot() -> Iterator:
    with foreign_process("foreign_presser.py") as process:
        yield process


def heard_samples(running) -> list:
    return collect(running.node, ProbeSamples, "/probe/samples", SAMPLE_BLOCKS)


@pytest.mark.parametrize("name", ["robust_ekf", "ekf"])
def test_estimators_find_what_a_foreign_robot_presses_on(session, quality, robot, name):
    running = session(adapter(), estimator(name, **RIGID))
    estimates = collect(running.node, TissueEstimate, f"/probe/{name}/estimate", SAMPLE_BLOCKS)

    def found() -> bool:
        return bool(estimates) and estimates[-1].status == Status.CONVERGED

    running.wait_until(found, "a converged estimate")
    assert estimates[-1].stiffness == pytest.approx(presser.STIFFNESS, rel=0.03)
    assert estimates[-1].damping == pytest.approx(presser.DAMPING, rel=0.1)


def test_a_bag_of_the_topics_gives_the_samples_bit_for_bit(session, robot, bag, tmp_path):
    running = session(
        adapter(), NodeProcess("recorder", "recorder", parameters={"output": str(bag)})
    )
    samples = heard_samples(running)
    begun: list = []

    def enough() -> bool:
        recorded = int(running.health.get("/probe/recorder", {}).get("messages recorded", 0))
        if recorded > 500 and not begun:
            begun.append(len(samples))
        return bool(begun) and len(samples) > begun[0] + 150

    running.wait_until(enough, "samples")
    running.__exit__()
    settings = tmp_path / "robot.yaml"
    settings.write_text(yaml.safe_dump({"/**/adapter": {"ros__parameters": ROBOT}}))
    live = read_recording(bag)
    again, notes = read_any(bag, Layout(adapter=str(settings)))
    assert "as the node adapter makes them" in notes[0]
    common, of_live, of_again = np.intersect1d(live.stamps, again.stamps, return_indices=True)
    assert common.size > 300
    assert live.position[of_live].tobytes() == again.position[of_again].tobytes()
    assert live.force[of_live].tobytes() == again.force[of_again].tobytes()


class Health:
    """What the adapter says of itself from when it is waited for."""

    def __init__(self, running) -> None:
        self._running = running
        self._told = collect(running.node, DiagnosticArray, "/diagnostics")

    def wait_for(self, sentence: str) -> None:
        self._told.clear()
        self._running.wait_until(
            lambda: any(
                sentence in status.message
                for array in self._told
                for status in array.status
                if status.name == "/probe/adapter"
            ),
            sentence,
            PATIENCE,
        )


def test_what_is_wrong_with_a_robot_is_told_and_makes_no_samples(session, robot):
    running = session(adapter())
    blocks, health = heard_samples(running), Health(running)

    def goes_on(anew: bool) -> bool:
        """Whether samples have come since it was wrong; numbered from 0 where that ends a run."""
        new = [block.sequence for block in blocks[before:]]
        return len(new) > 20 and (0 in new or not anew)

    running.wait_until(lambda: len(blocks) > 5, "samples")
    for word, sentence, anew in (
        ("nan", "/robot/measured_cf is not finite; left out", False),
        ("frame", "/robot/measured_cf comes in frame 'other', not in 'ft'", False),
        (
            "silent",
            "on /robot/measured_cf: a node without a name is known to publish it, but",
            True,
        ),
        ("jump", "/robot/measured_cp jumps by", True),
        ("back", "/robot/measured_cf has stamps that go back by", True),
    ):
        before = len(blocks)
        tell(robot, word)
        health.wait_for(sentence)
        tell(robot, "well")
        running.wait_until(lambda anew=anew: goes_on(anew), f"samples after {word}", PATIENCE)
    for block in map(samples_from_message, blocks):
        # Stamps that are set back by whole periods of the motion tell the same.
        u, speed = presser.pressed(block.stamps)
        force = presser.STIFFNESS * u + presser.DAMPING * speed
        u = u + np.where(block.position > 0.04, presser.JUMP, 0.0)
        # A straight line over the longest step that is bridged, 2.5 periods, is within 13 um; noise
        # comes with weights that add up to 2 at most.
        np.testing.assert_allclose(block.position, u, atol=15e-6)
        np.testing.assert_allclose(block.force, force, atol=9.0 * presser.FORCE_NOISE)


def test_samples_of_two_nodes_are_not_mixed(session, robot):
    running = session(adapter())
    other = samples_publisher(running.node)
    Health(running).wait_for("another node publishes samples: end it")
    blocks = heard_samples(running)
    assert not blocks
    running.node.destroy_publisher(other)
    running.wait_until(lambda: len(blocks) > 5, "samples")


def test_a_driver_beside_it_is_refused(session, robot):

    running = session(adapter(), driver())
    blocks = heard_samples(running)
    running.wait_until(lambda: len(blocks) > 5, "samples")
    assert not change_state(running, Transition.TRANSITION_CONFIGURE)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"force_polarity": "''"}, "force_polarity is not stated: press on something by hand"),
        ({"axis": [0.0, 0.0, 2.0]}, "axis is [0.0, 0.0, 2.0]: give 3 numbers"),
        ({"joint": "slide", "zero": [0.0], "force_axes": "base"}, "a joint tells no orientation"),
        ({"zero": [1.0]}, "zero is [1.0]: give 3 finite numbers"),
        ({"force_rate": 5.0}, "give a number from 10 to 4000 [Hz]"),
    ],
)
def test_wrong_parameters_end_it_in_a_sentence(given, sentence):
    assert sentence in fails_with(adapter(**given))
