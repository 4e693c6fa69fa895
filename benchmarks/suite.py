"""The suite as the benchmark runs it: on tissue from the start, without a scan.

Contents: starting, holding and ending one run.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tissue_probe.nodes.qos import ANNOUNCEMENTS
from tissue_probe.nodes.session import NodeProcess, Session
from tissue_probe_msgs.msg import PalpationSite

ESTIMATORS = ("ekf", "ukf", "afekf")
#: Processes that are not of the suite: a robot's side, and whoever wants single samples.
OTHERS = ("stage", "subscriber")
#: The per-sample topic whose cost is measured.
PER_SAMPLE_TOPIC = "/probe/measured_cf"
#: Time after the last sample for what is still under way: DDS sends a lost message again within
#: three seconds, the nodes sum up on /diagnostics once a second [s].
LAST_WORDS = 4.5

# Parameters given to one node by name win over those given on a command line to any.
_PARAMETERS = """
/stage/stage: {ros__parameters: {x: 0.0, y: 0.0, z: 0.0}}
/probe/driver: {ros__parameters: {excitation.frequency: 10.0, excitation.amplitude: 0.85}}
"""


class ValueRecorder(NodeProcess):
    """The recorder that records every number of an estimate once more."""

    def command(self, parameter_file: Path) -> list[str]:
        """Return the command line."""
        python, flag, _, *rest = super().command(parameter_file)
        return [python, flag, "benchmarks.value_recorder", *rest]


def processes(bag: Path, *, apart: bool) -> list[NodeProcess]:
    """Return the suite's processes, in the order of their ending.

    ``apart``, each estimator has a process and sends all its numbers one by one, too, since a
    recorder takes them, as the suite did before estimators could share a process.
    """
    together = NodeProcess("estimators", "estimators", parameters={"estimators": list(ESTIMATORS)})
    each = [NodeProcess("estimator", name, parameters={"estimator": name}) for name in ESTIMATORS]
    output = {"output": str(bag)}
    return [
        NodeProcess("driver", "driver"),
        NodeProcess("stage", "stage", "/stage"),
        *(each if apart else [together]),
        NodeProcess("mapper", "mapper", parameters={"estimators": list(ESTIMATORS)}),
        (ValueRecorder if apart else NodeProcess)("recorder", "recorder", parameters=output),
    ]


def with_one_estimator(bag: Path, name: str) -> list[NodeProcess]:
    """Return the suite's processes with one estimator, in the order of their ending."""
    return [
        NodeProcess("driver", "driver"),
        NodeProcess("stage", "stage", "/stage"),
        NodeProcess("estimator", name, parameters={"estimator": name}),
        NodeProcess("mapper", "mapper", parameters={"estimators": [name]}),
        NodeProcess("recorder", "recorder", parameters={"output": str(bag)}),
    ]


@contextmanager
def acquiring(
    bag: Path, chosen: list[NodeProcess], *, subscribed: bool = False
) -> Iterator[Session]:
    """Start the suite, yield while it acquires and records, and leave the bag complete.

    Parameters
    ----------
    bag : path
        The file that is recorded to; must not exist.
    chosen : list of NodeProcess
        The suite's processes.
    subscribed : bool
        Whether a subscriber must have joined ``PER_SAMPLE_TOPIC`` before acquisition starts.

    Raises
    ------
    SessionError
        If a process ends or does not answer.
    """
    parameters = bag.with_suffix(".yaml")
    parameters.write_text(_PARAMETERS)
    hearing = [each for each in chosen if each.module in ("estimator", "estimators", "monitor")]
    names = next(each for each in chosen if each.module == "mapper").parameters["estimators"]
    subscribers = {
        "/probe/driver": len(hearing) + 1,  # and the recorder
        **{f"/probe/{name}": 2 for name in names},  # the mapper and the recorder
    }
    with Session(chosen, parameters) as session:
        announce_dwell(session)
        if subscribed:
            session.wait_until(
                lambda: session.node.count_subscribers(PER_SAMPLE_TOPIC) > 0, "the subscriber"
            )
        session.activate(subscribers)
        yield session
        session.deactivate()
        spend(session, LAST_WORDS)


def announce_dwell(session: Session) -> None:
    """Say that the probe stands on site 0, so that the mapper has a site to map."""
    publisher = session.node.create_publisher(PalpationSite, "palpation_site", ANNOUNCEMENTS)
    message = PalpationSite(phase=PalpationSite.DWELL)
    message.header.stamp = session.node.get_clock().now().to_msg()
    publisher.publish(message)


def spend(session: Session, seconds: float) -> None:
    """Let time pass; breaks off if a process ends."""
    end = time.monotonic() + seconds
    session.wait_until(lambda: time.monotonic() >= end, "time to pass", timeout=float("inf"))


@contextmanager
def subscriber(output: Path) -> Iterator[subprocess.Popen]:
    """Run a subscriber of ``PER_SAMPLE_TOPIC``; at its end ``output`` holds what it received."""
    environment = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", **os.environ}
    command = [sys.executable, "-m", "benchmarks.subscriber", PER_SAMPLE_TOPIC, str(output)]
    process = subprocess.Popen(
        command, cwd=Path(__file__).parents[1], env=environment, start_new_session=True
    )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        process.wait()
