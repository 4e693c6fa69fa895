"""An estimator node on a model file, over DDS: the same estimates as off line, innovations fall."""

from __future__ import annotations

import array
from pathlib import Path

import numpy as np
import pytest
from rcl_interfaces.msg import Log

from conftest import collect, estimator, fails_with, samples_publisher
from tissue_probe.estimation import Estimator, EstimatorSettings
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.library import load_effects
from tissue_probe.physics.model_file import save
from tissue_probe.physics.response import course, respond
from tissue_probe.signals import SampleBlock
from tissue_probe_msgs.msg import ProbeSamples, TissueEstimate

# The node's kernel is compiled first, here, so that the node only loads it.
pytestmark = pytest.mark.timeout(600)

EXAMPLE = Path(__file__).parents[2] / "docs" / "my_effect.py"
PERIOD, SAMPLES, BLOCK = 5e-4, 3000, 10


def stiffening(folder):
    """A model file with cubic stiffening, and what a probe measures on such tissue."""
    composition = Composition(effects=(EFFECTS["cubic_stiffening"],))
    values = {entry.name: entry.default for entry in composition.values}
    save(folder / "model.yaml", composition, values, {})
    times = np.arange(SAMPLES) * PERIOD
    position = (times / times[-1]) * 2e-3 * np.sin(62.8 * times) ** 2
    vector = np.array(list(values.values()))
    coil = course(composition.kernel, position, PERIOD, vector)
    force = respond(composition.kernel, vector, np.zeros(2), coil).output
    force += 0.005 * np.random.default_rng(2).standard_normal(SAMPLES)
    return folder / "model.yaml", position, force


@pytest.mark.slow
def test_a_node_runs_the_model_in_a_file(session, tmp_path):
    path, position, force = stiffening(tmp_path)
    whole = SampleBlock(0, 0, PERIOD, position, force, np.zeros(SAMPLES))
    improved = Estimator("robust_ekf", EstimatorSettings(model=str(path))).process(whole)
    plain = Estimator("robust_ekf", EstimatorSettings()).process(whole)
    running = session(estimator("robust_ekf", model=str(path)))
    estimates = collect(running.node, TissueEstimate, "/probe/robust_ekf/estimate")
    publisher = samples_publisher(running.node)
    running.wait_until(
        lambda: (
            running.node.count_subscribers("/probe/samples") == 1
            and running.node.count_publishers("/probe/robust_ekf/estimate") == 1
        ),
        "the estimator",
    )
    for first in range(0, SAMPLES, BLOCK):
        message = ProbeSamples(sequence=first, sample_period=PERIOD)
        message.header.stamp.nanosec = first * 500_000 % 1_000_000_000
        message.header.stamp.sec = first * 500_000 // 1_000_000_000
        message.position = array.array("d", position[first : first + BLOCK])
        message.force = array.array("d", force[first : first + BLOCK])
        message.command = array.array("d", [0.0] * BLOCK)
        publisher.publish(message)
        running.wait_until(lambda first=first: len(estimates) > first // BLOCK - 20, "estimates")
    running.wait_until(lambda: len(estimates) == SAMPLES // BLOCK, "all estimates")
    live = np.array([estimate.innovation for estimate in estimates])
    np.testing.assert_array_equal(live, improved.innovation[BLOCK - 1 :: BLOCK])
    second_half = live[live.size // 2 :]
    fitted, wrong = np.std(second_half), np.std(plain.innovation[SAMPLES // 2 :])
    assert fitted < 1.15 * 0.005 < 1.5 * 0.005 < wrong


def test_a_model_file_with_a_mistake_ends_the_node_with_one_sentence(tmp_path):
    path, _, _ = stiffening(tmp_path)
    path.write_text(path.read_text().replace("unit: kg", "unit: g"))
    said = fails_with(estimator("robust_ekf", model=str(path)))
    assert "constants.tip_mass.unit is 'g': convert to 'kg'" in said
    assert "Traceback" not in said


def test_a_node_runs_no_code_but_that_of_the_files_in_its_parameter(tmp_path):
    own, ran = tmp_path / "own.py", tmp_path / "ran"
    own.write_text(EXAMPLE.read_text())
    composition = Composition(effects=load_effects(own))
    values = {entry.name: entry.default for entry in composition.values}
    save(tmp_path / "model.yaml", composition, values, {}, effect_files=[own])
    own.write_text(f"open({str(ran)!r}, 'w')\nraise SystemExit(0)\n")
    model = str(tmp_path / "model.yaml")
    said = fails_with(estimator("robust_ekf", model=model))
    assert "needs the effect 'quadratic_drag'" in said
    assert said.endswith("name it by `effects`")
    assert not ran.exists()
    said = fails_with(estimator("robust_ekf", model=model, effects=[str(own)]))
    assert f"{own} cannot be run: SystemExit: 0" in said
    assert ran.exists()


def test_a_node_whose_filter_has_to_be_compiled_first_says_so(session, tmp_path, monkeypatch):
    path, _, _ = stiffening(tmp_path)
    monkeypatch.setenv("TISSUE_PROBE_CACHE", str(tmp_path / "empty"))
    running = session(estimator("afekf", model=str(path)))
    said = collect(running.node, Log, "/rosout")
    running.wait_until(
        lambda: any("is being compiled, once for each model" in each.msg for each in said),
        "a word on what takes so long",
    )
    assert running.node.count_publishers("/probe/afekf/estimate") == 0  # it was told meanwhile
