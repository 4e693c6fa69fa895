"""The monitor node: the model is tested while samples come, and a diagnosis never ends the node."""

from __future__ import annotations

import array
import os
import signal
from pathlib import Path

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from std_srvs.srv import Trigger

from conftest import ask, collect, fails_with, samples_publisher, set_parameter
from tissue_probe.nodes.qos import LATCHED
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.model_file import load, save
from tissue_probe_msgs.msg import ModelVerdict, ProbeSamples

RATE = 250
BLOCK = 25
DIAGNOSE = "/probe/monitor/diagnose"
#: A diagnosis on a busy machine that finds no machine code of an earlier one [s].
LONG = 280.0


def monitor(**parameters: object) -> NodeProcess:
    given = {"rig": "rigid_probe", "window": 1.5, "kept": 2.0, "band": 30.0, **parameters}
    return NodeProcess("monitor", "monitor", parameters=given)


def tissue(seconds: float = 6.0, cubic: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Position [m] and force [N] of a spring beside a damper, maybe stiffening, led rigidly."""
    time = np.arange(round(seconds * RATE)) / RATE
    frequencies, phases = np.array([1.3, 2.9, 5.3, 8.9]), np.array([0.4, 2.0, 4.1, 5.5])
    angle = 2.0 * np.pi * np.multiply.outer(time, frequencies) + phases
    depth = 2e-3 + 4e-4 * np.sin(angle).sum(axis=1)
    speed = 4e-4 * (2.0 * np.pi * frequencies * np.cos(angle)).sum(axis=1)
    force = 400.0 * depth + cubic * depth**3 + 2.0 * speed
    return depth, force + 0.005 * np.random.default_rng(5).standard_normal(time.size)


def messages(position: np.ndarray, force: np.ndarray) -> list[ProbeSamples]:
    """Blocks of samples, stamped from 100 s on."""
    unknown = array.array("d", [float("nan")] * BLOCK)
    made = []
    for first in range(0, position.size, BLOCK):
        here = slice(first, first + BLOCK)
        block = ProbeSamples(
            sequence=first,
            sample_period=1.0 / RATE,
            position=array.array("d", position[here]),
            force=array.array("d", force[here]),
            command=unknown,
        )
        block.header.stamp.sec, rest = divmod(100 * RATE + first, RATE)
        block.header.stamp.nanosec = round(1e9 * rest / RATE)
        made.append(block)
    return made


def heard(running, publisher, sent: list[ProbeSamples]) -> None:
    running.wait_until(lambda: publisher.get_subscription_count() == 1, "the monitor")
    for each in sent:
        publisher.publish(each)


def health(received: list) -> DiagnosticStatus | None:
    told = [s for m in received for s in m.status if s.name == "/probe/monitor"]
    return told[-1] if told else None


def wait_for(running, received: list, words: str) -> DiagnosticStatus:
    def said() -> bool:
        last = health(received)
        return last is not None and words in last.message

    running.wait_until(said, words)
    return health(received)


def written(path: Path, effect: str) -> str:
    """A model file of an effect on tissue that is led rigidly, with default values."""
    composition = Composition("rigid_probe", effects=(EFFECTS[effect],))
    save(path, composition, {entry.name: entry.default for entry in composition.values}, {})
    return str(path)


def child_of(process: int) -> int:
    """The one process that another has started."""
    (child,) = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return int(child)


def test_a_missing_effect_is_told_with_a_model_that_has_it(session, tmp_path):
    running = session(monitor())
    publisher = samples_publisher(running.node)
    heard(running, publisher, messages(*tissue(cubic=3e7)))
    early = collect(running.node, ModelVerdict, "/probe/model_verdict", LATCHED)
    running.wait_until(lambda: early, "a verdict", LONG)
    late = collect(running.node, ModelVerdict, "/probe/model_verdict", LATCHED)
    running.wait_until(lambda: late, "the verdict that is kept")
    verdict = late[0]
    assert verdict.cause == ModelVerdict.TEST_FAILED
    assert verdict.verdict in ("missing", "ambiguous")
    assert any("stiffening" in name for name in verdict.effects)
    assert len(verdict.probabilities) == len(verdict.effects)
    assert verdict.error_current > 2.0
    assert verdict.error_proposed < 1.2
    assert 1.2 < verdict.span <= 2.1
    file = tmp_path / "proposed.yaml"
    file.write_text(verdict.proposed_model)
    assert load(file).composition.names


def test_a_diagnosis_that_is_killed_is_told_and_the_node_goes_on(session):
    running = session(monitor())
    states = collect(running.node, DiagnosticArray, "/diagnostics")
    publisher = samples_publisher(running.node)
    sent = messages(*tissue())
    heard(running, publisher, sent[:30])
    assert wait_for(running, states, "the model holds").level == DiagnosticStatus.OK
    assert ask(running, Trigger, DIAGNOSE).success
    again = ask(running, Trigger, DIAGNOSE)
    assert not again.success
    assert "a diagnosis is under way" in again.message
    os.kill(child_of(running.processes["monitor"].pid), signal.SIGKILL)
    told = wait_for(running, states, "killed by signal 9")
    assert told.level == DiagnosticStatus.WARN
    tested = {v.key: v.value for v in told.values}["windows tested"]
    for each in sent[30:]:
        publisher.publish(each)

    def more() -> bool:
        values = {v.key: v.value for v in health(states).values}
        return int(values["windows tested"]) > int(tested)

    running.wait_until(more, "more windows")


def test_nothing_is_diagnosed_without_samples_or_with_values_that_are_not_finite(session):
    running = session(monitor())
    states = collect(running.node, DiagnosticArray, "/diagnostics")
    publisher = samples_publisher(running.node)
    answer = ask(running, Trigger, DIAGNOSE)
    assert not answer.success
    assert "no samples come" in answer.message
    position, force = tissue()
    force[-1] = np.nan
    heard(running, publisher, messages(position, force))
    assert wait_for(running, states, "look at the cables").level == DiagnosticStatus.WARN
    assert "look at the cables" in ask(running, Trigger, DIAGNOSE).message
    assert (
        wait_for(running, states, "no samples in the last second").level == DiagnosticStatus.STALE
    )


def test_another_model_is_tested_while_it_runs(session, tmp_path):
    files = {
        name: written(tmp_path / f"{name}.yaml", name)
        for name in ("cubic_stiffening", "stiffness_step")
    }
    running = session(monitor(false_alarms=1e-6))
    states = collect(running.node, DiagnosticArray, "/diagnostics")
    publisher = samples_publisher(running.node)
    position, force = tissue(seconds=40.0, cubic=3e7)
    sent = iter(messages(position, force))
    heard(running, publisher, [next(sent) for _ in range(20)])
    wait_for(running, states, "times the noise")
    for model, said in (
        (files["stiffness_step"], "stiffness_step begins at an instant of the recording"),
        ("nowhere.yaml", "nowhere.yaml: No such file"),
    ):
        accepted, reason = set_parameter(running, "/probe/monitor", "model", model)
        assert not accepted
        assert said in reason
    assert set_parameter(running, "/probe/monitor", "model", files["cubic_stiffening"])[0]
    running.wait_until(
        lambda: {v.key: v.value for v in health(states).values}["model"].endswith(
            "cubic_stiffening.yaml"
        ),
        "the model",
        LONG,
    )
    for _ in range(20):
        publisher.publish(next(sent))
    told = wait_for(running, states, "the model holds")
    assert told.level == DiagnosticStatus.OK


def test_a_second_monitor_is_told(session):
    running = session(monitor(), NodeProcess("monitor", "second", parameters={}))
    states = collect(running.node, DiagnosticArray, "/diagnostics")
    told = wait_for(running, states, "end all monitors of this namespace but one")
    assert told.level == DiagnosticStatus.ERROR


def test_a_model_that_is_not_there_ends_it_with_a_sentence():
    assert "nowhere.yaml" in fails_with(monitor(model="nowhere.yaml"))
