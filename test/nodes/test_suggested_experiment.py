"""What a diagnosis suggests, as its command line has it, is what the driver takes."""

from __future__ import annotations

import shlex

import pytest
import rclpy

from tissue_probe.devices.limits import Limits
from tissue_probe.diagnosis.advice.driver_command import (
    DRIVER_COMMAND,
    LARGEST,
    USUAL,
    driver_command,
)
from tissue_probe.diagnosis.advice.separation import PROBE_AMPLITUDE, PROBE_EXPERIMENTS, Suggestion
from tissue_probe.nodes.driver import ExcitationSettings
from tissue_probe.nodes.parameters import declare, read


@pytest.fixture
def declared():
    """Return the excitation that a driver of this command line would make."""

    def declared(line: str):
        words = shlex.split(line)
        rclpy.init(args=words[words.index("--ros-args") :])
        node = rclpy.create_node("driver")
        assert node.get_namespace() == "/probe"
        declare(node, ExcitationSettings, "excitation.")
        try:
            return read(node, ExcitationSettings, "excitation.")
        finally:
            node.destroy_node()

    yield declared
    rclpy.try_shutdown()


@pytest.mark.parametrize("experiment", PROBE_EXPERIMENTS, ids=str)
@pytest.mark.parametrize("gain", [1e-3, 1e-5, float("nan")])
def test_the_driver_takes_every_experiment(declared, experiment, gain):
    excitation, preload, duration = experiment
    asked = Suggestion({**excitation, "amplitude": PROBE_AMPLITUDE}, preload, duration, 1.5)
    taken = declared(driver_command(asked, gain).line)
    for name, value in excitation.items():
        assert getattr(taken, name) == value
    assert taken.amplitude == {1e-3: 1.0, 1e-5: LARGEST}.get(gain, USUAL)
    assert taken.make().amplitude == taken.amplitude


def test_the_volts_are_those_of_the_driver():
    assert ExcitationSettings().amplitude == USUAL
    assert Limits().command_limit == LARGEST
    assert DRIVER_COMMAND.startswith("ros2 run tissue_probe driver ")
