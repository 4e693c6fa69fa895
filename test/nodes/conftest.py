"""Real nodes as real processes over DDS: each test has its own domain, on this host only."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import domain_coordinator
import pytest
import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import GetState
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import QoSProfile, ReliabilityPolicy
from warm import popen

from crtk_msgs.msg import OperatingState, StringStamped
from domains import domains_of
from tissue_probe.nodes import asking
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATCHED, POSES, SAMPLE_BLOCKS
from tissue_probe.nodes.session import NodeProcess, Session, SessionError
from tissue_probe_msgs.action import ScanGrid
from tissue_probe_msgs.msg import PalpationSite, ProbeSamples

PATIENCE = 40.0

STAGE = NodeProcess("stage", "stage", "/stage")
#: Where a test is of something else, a busy machine may be later than a theatre could allow: with
#: samples, poses, and the stage's motion, which must have reached the tip as a dwell begins.
PATIENT = {"samples_timeout": 10.0, "poses_timeout": 10.0, "settle_time": 0.3}
SCAN = NodeProcess("scan", "scan", parameters=PATIENT)


#: Which of those that test side by side this is, and how many they are.
WORKER = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
WORKERS = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
#: Domains are taken in turn, each worker its own: what a test leaves behind dies before its domain
#: comes round again.
DOMAINS = itertools.cycle(domains_of(WORKER, WORKERS))


def own_domain():
    """A DDS domain that nothing else on this machine uses, as a context manager."""
    return domain_coordinator.domain_id(selector=lambda: next(DOMAINS))


@pytest.fixture(autouse=True)
def domain(monkeypatch) -> Iterator[int]:
    """The test's own DDS domain."""
    with own_domain() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        yield number


@pytest.fixture(scope="session", autouse=True)
def warm() -> Iterator[None]:
    """Processes of nodes are forked from one that has imported what they need."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tissue_probe.nodes.session.Popen", popen)
        yield


@pytest.fixture
def cold(warm, monkeypatch) -> None:
    """Processes of nodes are started from nothing: for a test of what the loader reads."""
    monkeypatch.setattr("tissue_probe.nodes.session.Popen", subprocess.Popen)


@pytest.fixture
def session() -> Iterator[Callable[..., Session]]:
    """Start node processes; they are ended with the test."""
    opened: list[Session] = []

    def start(*processes: NodeProcess, parameter_file: Path | None = None) -> Session:
        opened.append(Session(processes, parameter_file).__enter__())
        return opened[-1]

    yield start
    for each in opened:
        each.__exit__()


@contextmanager
def session_of_a_module(*processes: NodeProcess) -> Iterator[Session]:
    """Start node processes for several tests, in a domain of their own."""
    with own_domain() as number:
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("ROS_DOMAIN_ID", str(number))
            running = Session(processes).__enter__()
        try:
            yield running
        finally:
            running.__exit__()


@pytest.fixture
def graph() -> Iterator[Graph]:
    """A node of the test's own in the graph, without any other process."""
    rclpy.init()
    found = Graph()
    yield found
    found.close()
    rclpy.try_shutdown()


class Graph:
    """A node, and bounded waits on what comes to it."""

    def __init__(self) -> None:
        self.node = rclpy.create_node("test", namespace="/probe")
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)

    def close(self) -> None:
        self.node.destroy_node()

    def wait_until(self, condition: Callable[[], object], timeout: float = PATIENCE) -> None:
        deadline = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < deadline, "waited in vain"
            self.spin_once()

    def spin_once(self) -> None:
        self._executor.spin_once(timeout_sec=0.02)


#: A test's own process may be kept waiting for longer than any node of ours.
EVERYTHING = QoSProfile(depth=100_000, reliability=ReliabilityPolicy.RELIABLE)


def collect(node, message_type, topic: str, qos=EVERYTHING) -> list:
    """Subscribe, and return the list to which every message is added."""
    received: list = []
    node.create_subscription(message_type, topic, received.append, qos)
    return received


def driver(**parameters: object) -> NodeProcess:
    """A driver whose parameters are given with '__' for '.'; patient with a scan and its samples.

    A process that a busy machine held up would else stop the coil, for a reason of its own.
    """
    named = {name.replace("__", "."): value for name, value in parameters.items()}
    patient = {"limits.palpation_timeout": 5.0, "limits.stale_limit": 5.0, **named}
    return NodeProcess("driver", "driver", parameters=patient)


def stage_on_tissue(x: float = 0.0, y: float = 0.0) -> NodeProcess:
    """A stage that holds the tip on the phantom's surface."""
    return NodeProcess("stage", "stage", "/stage", {"x": x, "y": y, "z": 0.0})


def estimator(name: str, **parameters: object) -> NodeProcess:
    return NodeProcess("estimator", name, parameters={"estimator": name, **parameters})


def ask(running: Session, kind, service: str, request=None):
    """Ask a service until it answers; return its answer."""

    def wait(condition) -> None:
        running.wait_until(condition, f"the answer of {service}")

    return asking.ask(running.node, kind, service, request or kind.Request(), wait)


def change_state(session: Session, transition: int, node: str = "/probe/driver") -> bool:
    def wait(condition) -> None:
        session.wait_until(condition, f"the answer of {node}")

    return asking.change_state(session.node, node, transition, wait)


def state_of(running, node: str = "/probe/driver") -> int:
    return ask(running, GetState, f"{node}/get_state").current_state.id


def activate(session: Session) -> None:
    for transition in (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE):
        assert change_state(session, transition), driver_log(session)


def driver_log(session: Session) -> str:
    """What the driver said last; nothing where a test runs it outside the session."""
    return session.log("driver") if "driver" in session.processes else ""


def deactivate(session: Session) -> None:
    assert change_state(session, Transition.TRANSITION_DEACTIVATE)


def say(running, namespace: str, word: str, is_done: Callable[[], bool]) -> None:
    """Say a word on state_command until it is done, as an operator at a console does.

    A word that is sent while two nodes still find each other is lost.
    """
    publisher = running.node.create_publisher(StringStamped, f"{namespace}/state_command", POSES)
    said_at = float("-inf")

    def pursued() -> bool:
        nonlocal said_at
        if publisher.get_subscription_count() and time.monotonic() - said_at > asking.REPEAT:
            said_at = time.monotonic()
            publisher.publish(StringStamped(string=word))
        return is_done()

    running.wait_until(pursued, f"{word} to be done")
    running.node.destroy_publisher(publisher)


def command(running, namespace: str, word: str, state: str) -> None:
    """Say a word on state_command until the robot is in the state that follows."""
    states = collect(running.node, OperatingState, f"{namespace}/operating_state", LATCHED)
    say(running, namespace, word, lambda: bool(states) and states[-1].state == state)


def set_parameter(session: Session, node: str, name: str, value: object) -> tuple[bool, str]:
    """Set a parameter as `ros2 param set` does; return success and the node's reason."""
    client = AsyncParameterClient(session.node, node)
    session.wait_until(client.services_are_ready, node, PATIENCE)
    answer = client.set_parameters([rclpy.parameter.Parameter(name, value=value)])
    session.wait_until(answer.done, "the answer", PATIENCE)
    result = answer.result().results[0]
    return result.successful, result.reason


def goal(rows: int = 1, columns: int = 2, dwell_time: float = 0.2) -> ScanGrid.Goal:
    return ScanGrid.Goal(rows=rows, columns=columns, spacing=0.01, dwell_time=dwell_time)


class Acting:
    """An action that was asked for."""

    def __init__(self, running, kind, name: str, wanted) -> None:
        self.running = running
        self.feedback: list = []
        client = ActionClient(running.node, kind, f"/probe/{name}")
        asked = asking.to_action(client, wanted, lambda m: self.feedback.append(m.feedback))
        running.wait_until(asked.is_answered, "the scan node's answer")
        self.handle = asked.answer()

    def result(self, timeout: float = 4 * PATIENCE):
        answer = self.handle.get_result_async()
        self.running.wait_until(answer.done, "the scan's end", timeout)
        return answer.result()

    def dwells(self) -> list[PalpationSite]:
        return [f.site for f in self.feedback if f.site.phase == PalpationSite.DWELL]

    def wait_for(self, phase: int) -> None:
        self.running.wait_until(
            lambda: any(f.site.phase == phase for f in self.feedback), "the phase"
        )


class Scanning(Acting):
    """A scan of a grid that was asked for."""

    def __init__(self, running, wanted: ScanGrid.Goal) -> None:
        super().__init__(running, ScanGrid, "scan_grid", wanted)


def fails_with(process: NodeProcess) -> str:
    """Start a process that must end by itself; return what it said."""
    with Session([process]) as running:
        with pytest.raises(SessionError) as failure:
            running.wait_until(lambda: False, "its end", PATIENCE)
        assert running.processes[process.name].wait() == 1
    return str(failure.value)


def site_publisher(node, namespace: str = "/probe"):
    return node.create_publisher(PalpationSite, f"{namespace}/palpation_site", ANNOUNCEMENTS)


def samples_publisher(node, namespace: str = "/probe"):
    return node.create_publisher(ProbeSamples, f"{namespace}/samples", SAMPLE_BLOCKS)


#: Cyclone is to look for others on this host only, and without multicast, as our nodes do. Until a
#: writer's first heartbeat it keeps 128 samples by default and loses the next (a relative of
#: rmw_cyclonedds issue 367): too few at 2 kHz, where that may be .3 s away.
CYCLONE_CONFIGURATION = """
<CycloneDDS><Domain>
  <General>
    <Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
    <AllowMulticast>false</AllowMulticast>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex>
    <MaxAutoParticipantIndex>120</MaxAutoParticipantIndex>
    <Peers><Peer address="127.0.0.1"/></Peers>
  </Discovery>
  <Internal>
    <PrimaryReorderMaxSamples>4000</PrimaryReorderMaxSamples>
    <SecondaryReorderMaxSamples>4000</SecondaryReorderMaxSamples>
  </Internal>
</Domain></CycloneDDS>
"""


@contextmanager
def foreign_process(program: str) -> Iterator[subprocess.Popen]:
    """Start a program of this folder that speaks DDS without ROS, in the test's domain.

    It ends when its standard input does, or here.
    """
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("ROS", "RMW", "AMENT", "LD_"))
    }
    process = subprocess.Popen(
        [sys.executable, str(Path(__file__).parent / program)],
        env={
            **environment,
            "CYCLONEDDS_URI": CYCLONE_CONFIGURATION,
            "DOMAIN": os.environ["ROS_DOMAIN_ID"],
        },
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def tell(process: subprocess.Popen, word: str) -> None:
    """Say a word to a program of ``foreign_process``, a line on its standard input."""
    process.stdin.write(f"{word}\n")
    process.stdin.flush()


@pytest.fixture
def robot() -> Iterator[subprocess.Popen]:
    """Start a robot that shares no code with us."""
    with foreign_process("foreign_robot.py") as process:
        yield process


@pytest.fixture
def bag(tmp_path) -> Path:
    return tmp_path / "run.mcap"
