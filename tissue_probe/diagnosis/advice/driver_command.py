"""The command line that runs a suggested experiment on the suite's driver.

Contents: the driver's parameters by name, the coil's volts, and steps beside it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.diagnosis.advice.separation import Suggestion
from tissue_probe.signals import FloatArray

#: The driver's amplitude where none is given, and the largest that its limits let pass [V].
USUAL, LARGEST = 0.85, 5.0
DRIVER_COMMAND = "ros2 run tissue_probe driver --ros-args -r __ns:=/probe"
STAGE_COMMAND = "ros2 run tissue_probe stage --ros-args -r __ns:=/stage"
RECORDER = "ros2 run tissue_probe recorder --ros-args -r __ns:=/probe -p output:=next.mcap"
#: How well first touch is known where a stage presses the probe in [m].
TOUCH_DEVIATION = 3e-5


@dataclass(frozen=True)
class DriverCommand:
    """How to run an experiment.

    Attributes
    ----------
    line : str
        To be pasted into a shell.
    notes : tuple of str
        Steps before it, where the amplitude comes from, and how it is recorded, in sentences.
    """

    line: str
    notes: tuple[str, ...]


def coil_gain(position: FloatArray, command: FloatArray) -> float:
    """Return how far a coil goes for each volt of its command, both rms about their means [m/V].

    NaN where the command is not known throughout, or the coil was not driven.

    Parameters
    ----------
    position : array, shape (n,)
        Displacement of the coil [m].
    command : array, shape (n,)
        Voltage commanded to it [V]; NaN where not known.
    """
    volts, way = float(np.std(command)), float(np.std(position))
    return way / volts if volts > 0.0 and way > 0.0 else np.nan


def driver_command(suggestion: Suggestion, gain: float) -> DriverCommand | None:
    """Return the command that runs a suggested experiment; None where none is suggested.

    Parameters
    ----------
    suggestion : Suggestion
        Its amplitude is the coil's way.
    gain : float
        As measured by ``coil_gain`` [m/V]; NaN where it is not known.
    """
    if not suggestion.excitation:
        return None
    volts, told = _amplitude(float(str(suggestion.excitation["amplitude"])), gain)
    settings = {**suggestion.excitation, "amplitude": volts}
    words = (f"-p excitation.{name}:={_ros(value)}" for name, value in settings.items())
    notes = (_contact(suggestion.preload), told, _describe_recording(suggestion.duration))
    return DriverCommand(" ".join([DRIVER_COMMAND, *words]), notes)


def _amplitude(way: float, gain: float) -> tuple[float, str]:
    """Return the volts for a coil's way [m], and where they come from."""
    wanted = f"{1e3 * way:g} mm"
    if not np.isfinite(gain):
        return USUAL, (
            f"The coil's command is not in these measurements: {USUAL:g} V is the driver's "
            f"usual amplitude; set excitation.amplitude so that the coil moves by about {wanted}."
        )
    volts = float(f"{way / gain:.3g}")
    measured = f"the coil went {1e3 * gain:.3g} mm for each volt here (rms about the means)"
    if volts > LARGEST:
        return LARGEST, (
            f"For {wanted} the coil needs {volts:g} V: {measured}. The driver's "
            f"limits.command_limit is {LARGEST:g} V, with which it goes "
            f"{1e3 * LARGEST * gain:.3g} mm."
        )
    return volts, f"With {volts:g} V the coil moves by about {wanted}: {measured}."


def _contact(preload: float) -> str:
    """Say where the probe must be before the driver is activated."""
    if preload == 0.0:
        return (
            "Let the tip just touch before the driver is activated (stage or robot; the simulated "
            f"stage: {STAGE_COMMAND} -p z:=0.0)."
        )
    return (
        f"Press the probe in by {1e3 * preload:g} mm before the driver is activated (stage or "
        f"robot; the simulated stage: {STAGE_COMMAND} -p z:={_ros(-preload)}). The position does "
        f"not hold that way: diagnose the recording with "
        f"`constant` contact_position={_ros(-preload)}+-{TOUCH_DEVIATION:g}."
    )


def _describe_recording(duration: float) -> str:
    """Say how the experiment is begun, recorded and ended."""
    return (
        f"In another shell: {RECORDER}. In a third: ros2 lifecycle set /probe/driver configure, "
        f"the same with activate, and {duration:g} s later with deactivate. The wheels have no "
        "ros2: there the nodes are .venv/lib/tissue_probe/driver, recorder and stage, with the "
        "same arguments, and a program of yours calls the service /probe/driver/change_state."
    )


def _ros(value: object) -> str:
    """Write a parameter's value as ROS takes it: numbers in full, with a decimal point."""
    if isinstance(value, float):
        return np.format_float_positional(value, trim="0")
    return str(value)
