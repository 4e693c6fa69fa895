"""Nodes take another model while they run: the old one goes on until the new one is compiled."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient

from conftest import (
    PATIENCE,
    ask,
    collect,
    deactivate,
    driver,
    set_parameter,
    stage_on_tissue,
)
from tissue_probe.analysis.recorded_facts import estimate_again
from tissue_probe.nodes.qos import LATCHED
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.library import load_effects
from tissue_probe.physics.model_file import save
from tissue_probe.recording.bags.reader import read_estimates, read_recording
from tissue_probe_msgs.msg import EstimatorModel, TissueEstimate

# Kernels are compiled at low priority, maybe beside other tests.
pytestmark = pytest.mark.timeout(600)

#: A kernel on a busy machine that finds no machine code of an earlier one [s].
LONG = 280.0
#: Of an effect that no process has compiled before: the time is in its equations.
OWN = """
import sympy as sp
from tissue_probe.physics.effects.effect import INDENTATION, Effect, Parameter

CURVE = sp.Symbol("own_curve", real=True)
EFFECT = Effect(
    name="own_stiffening",
    family="elastic",
    physics="The tissue stiffens with the fourth power of the indentation",
    parameters=(Parameter(CURVE, "N/m^4", default=1e5, lower=-1e12, upper=1e12),),
    force=CURVE * INDENTATION**4 * sp.Float("{never}"),
)
"""


def written(path: Path, composition: Composition, effect_files: tuple[Path, ...] = ()) -> str:
    values = {e.name: e.default for e in composition.entries(map(str, composition.model.values))}
    save(path, composition, values, {}, effect_files=effect_files)
    return str(path)


@pytest.fixture
def cubic(tmp_path) -> str:
    return written(tmp_path / "cubic.yaml", Composition(effects=(EFFECTS["cubic_stiffening"],)))


@pytest.fixture
def own(tmp_path) -> tuple[str, str]:
    """A model that is not on the disk yet, and the Python file of its effect."""
    file = tmp_path / "own.py"
    file.write_text(OWN.format(never=f"1.{time.time_ns()}"))
    composition = Composition(effects=load_effects(file))
    return written(tmp_path / "own.yaml", composition, (file,)), str(file)


def set_together(running, node: str, **values: object) -> tuple[bool, str]:
    """Set parameters that only hold together; return success and the node's reason."""
    client = AsyncParameterClient(running.node, node)
    running.wait_until(client.services_are_ready, node, PATIENCE)
    answer = client.set_parameters_atomically(
        [Parameter(name, value=value) for name, value in values.items()]
    )
    running.wait_until(answer.done, "the answer", PATIENCE)
    return answer.result().result.successful, answer.result().result.reason


def model_of(running, node: str) -> str:
    """The parameter ``model``, as the node tells it."""
    wanted = GetParameters.Request(names=["model"])
    return ask(running, GetParameters, f"{node}/get_parameters", wanted).values[0].string_value


def told(received: list, node: str) -> dict[str, str]:
    """What a node's last word on its health says, with its message as ``message``."""
    last = [s for m in received for s in m.status if s.name == node][-1:]
    return (
        {} if not last else {v.key: v.value for v in last[0].values} | {"message": last[0].message}
    )


def child_of(process: int) -> int:
    """The one process that another has started."""
    (child,) = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return int(child)


def estimators(*names: str) -> NodeProcess:
    return NodeProcess("estimators", "estimators", parameters={"estimators": list(names)})


def is_taken(estimates: list, effect: str) -> bool:
    return bool(estimates) and effect in estimates[-1].model


@pytest.fixture
def running(session, bag):
    """Two filters in one process on a simulated probe, recorded; the first estimates are there."""
    recorder = NodeProcess("recorder", "recorder", parameters={"output": str(bag)})
    started = session(driver(), stage_on_tissue(), estimators("ekf", "rls"), recorder)
    started.estimates = collect(started.node, TissueEstimate, "/probe/ekf/estimate")
    started.states = collect(started.node, DiagnosticArray, "/diagnostics")
    subscribers = {"/probe/driver": 2, "/probe/ekf": 2, "/probe/rls": 1}
    started.activate(subscribers, {"/probe/ekf": 1})
    started.wait_until(lambda: len(started.estimates) > 100, "estimates")
    return started


def test_a_model_is_taken_without_a_lost_sample_and_off_line_at_the_same_one(running, cubic, bag):
    models = collect(running.node, EstimatorModel, "/probe/ekf/model", LATCHED)
    assert set_parameter(running, "/probe/ekf", "model", cubic) == (True, "")
    assert model_of(running, "/probe/ekf") == cubic
    running.wait_until(lambda: is_taken(running.estimates, "cubic"), "the model", LONG)
    count = len(running.estimates)
    running.wait_until(lambda: len(running.estimates) > count + 100, "estimates by it")
    # Another one, and what the first file was, may be changed at once.
    Path(cubic).unlink()
    assert set_parameter(running, "/probe/ekf", "model", "") == (True, "")
    running.wait_until(lambda: running.estimates[-1].model == "kelvin_voigt", "the plain model")
    count = len(running.estimates)
    running.wait_until(lambda: len(running.estimates) > count + 100, "estimates by it")
    health = told(running.states, "/probe/ekf")
    deactivate(running)
    running.processes["recorder"].send_signal(signal.SIGINT)
    assert running.processes.pop("recorder").wait(PATIENCE) == 0

    assert health["samples lost"] == "0"
    sequences = np.array([each.sequence for each in running.estimates])
    assert np.all(np.diff(sequences) == 10)
    assert [each.model.split()[0] for each in models] == [
        "kelvin_voigt",
        "kelvin_voigt+cubic_stiffening",
        "kelvin_voigt",
    ]
    recording, live = read_recording(bag), read_estimates(bag)["ekf"]
    own = [each for each in recording.models if each.estimator == "ekf"]
    assert [each.sequence for each in own] == [each.sequence for each in models]
    assert own[1].file == cubic
    assert "cubic_stiffness" in own[1].content
    again = estimate_again(recording, "ekf")
    assert len(set(again.model)) == 2
    rows = np.searchsorted(again.sequence, live.sequence)
    for ours, theirs in zip(again[rows].arrays(), live.arrays(), strict=True):
        assert np.array_equal(ours, theirs, equal_nan=True)


def test_what_cannot_be_taken_is_refused_with_a_sentence_and_the_old_filter_goes_on(
    running, cubic, tmp_path
):
    rigid = written(tmp_path / "rigid.yaml", Composition("rigid_probe"))
    spoilt = tmp_path / "spoilt.yaml"
    spoilt.write_text(Path(cubic).read_text().replace("unit: kg", "unit: g"))
    for node, model, said in (
        ("ekf", str(tmp_path / "nowhere.yaml"), "nowhere.yaml: No such file"),
        ("ekf", rigid, "rig rigid_probe cannot run live"),
        ("ekf", str(spoilt), "constants.tip_mass.unit is 'g': convert to 'kg'"),
        ("rls", cubic, "knows Kelvin-Voigt tissue only"),
    ):
        accepted, reason = set_parameter(running, f"/probe/{node}", "model", model)
        assert not accepted
        assert said in reason
        assert "\n" not in reason
        assert model_of(running, f"/probe/{node}") == ""
    assert not set_parameter(running, "/probe/ekf", "force_noise", 0.1)[0]
    count = len(running.estimates)
    running.wait_until(lambda: len(running.estimates) > count + 20, "estimates")
    assert {each.model for each in running.estimates} == {"kelvin_voigt"}
    assert np.all(np.diff([each.sequence for each in running.estimates]) == 10)


def test_a_model_whose_compiling_is_killed_is_put_back_and_told(running, own):
    model, file = own
    accepted, reason = set_parameter(running, "/probe/ekf", "model", model)
    assert not accepted
    assert "name it by `effects`" in reason
    assert set_together(running, "/probe/ekf", model=model, effects=[file]) == (True, "")
    running.wait_until(
        lambda: model in told(running.states, "/probe/ekf").get("model under way", ""), "the model"
    )
    os.kill(child_of(running.processes["estimators"].pid), signal.SIGKILL)
    running.wait_until(
        lambda: "killed by signal 9" in told(running.states, "/probe/ekf").get("message", ""),
        "the failure",
    )
    assert told(running.states, "/probe/ekf")["model under way"] == "none"
    levels = [s.level for m in running.states for s in m.status if s.name == "/probe/ekf"]
    assert levels[-1] == DiagnosticStatus.WARN
    assert model_of(running, "/probe/ekf") == ""
    count = len(running.estimates)
    running.wait_until(lambda: len(running.estimates) > count + 20, "estimates")
    assert {each.model for each in running.estimates} == {"kelvin_voigt"}


def test_of_two_changes_the_newer_wins(running, own, cubic):
    model, file = own
    assert set_together(running, "/probe/ekf", model=model, effects=[file]) == (True, "")
    assert set_together(running, "/probe/ekf", model=cubic, effects=[]) == (True, "")
    running.wait_until(lambda: is_taken(running.estimates, "cubic"), "the newer model", LONG)
    assert not any("own_stiffening" in each.model for each in running.estimates)
    assert model_of(running, "/probe/ekf") == cubic
