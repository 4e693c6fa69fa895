"""The command line of a suggested experiment: parameters, volts, and what is said of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hidden import EXACT, challenge, library, measurement

from tissue_probe.diagnosis.advice.driver_command import LARGEST, USUAL, coil_gain, driver_command
from tissue_probe.diagnosis.advice.separation import (
    PROBE_AMPLITUDE,
    PROBE_EXPERIMENTS,
    Suggestion,
    suggest,
)
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS

TIME = np.arange(2000) * 5e-4
WAVE = np.sin(2 * np.pi * 10.0 * TIME)


def suggestion(number, preload=None):
    excitation, pressed, duration = PROBE_EXPERIMENTS[number]
    pressed = pressed if preload is None else preload
    return Suggestion({**excitation, "amplitude": PROBE_AMPLITUDE}, pressed, duration, 1.5)


def test_the_volts_come_from_how_far_the_coil_went():
    gain = coil_gain(2e-3 + 5e-4 * WAVE, 0.1 + 0.4 * WAVE)
    assert gain == pytest.approx(1.25e-3)
    found = driver_command(suggestion(3), gain)
    assert found.line == (
        "ros2 run tissue_probe driver --ros-args -r __ns:=/probe -p excitation.kind:=multisine "
        "-p excitation.start:=1.0 -p excitation.stop:=60.0 -p excitation.spacing:=1.0 "
        "-p excitation.amplitude:=0.8"
    )
    assert "1.25 mm for each volt" in found.notes[1]


@pytest.mark.parametrize("command", [np.nan * WAVE, 0.0 * WAVE])
def test_without_the_coils_command_the_usual_volts_are_given_and_what_they_must_do(command):
    found = driver_command(suggestion(0), coil_gain(1e-3 * WAVE, command))
    assert found.line.endswith(f"-p excitation.amplitude:={USUAL}")
    assert "so that the coil moves by about 1 mm" in found.notes[1]


def test_no_more_volts_are_given_than_the_driver_lets_pass():
    found = driver_command(suggestion(0), 1e-4)
    assert found.line.endswith(f"-p excitation.amplitude:={LARGEST}")
    assert "needs 10 V" in found.notes[1]
    assert "limits.command_limit is 5 V, with which it goes 0.5 mm" in found.notes[1]


def test_how_the_probe_is_pressed_in_is_said():
    pressed, touching = (driver_command(suggestion(n), np.nan).notes[0] for n in (1, 0))
    assert "by 2 mm" in pressed
    assert "-p z:=-0.002)" in pressed
    assert "`constant` contact_position=-0.002+-3e-05" in pressed
    assert "just touch" in touching
    assert "-p z:=0.0)" in touching


def test_a_calibration_needs_no_command():
    assert driver_command(Suggestion({}, 0.0, 0.0, np.nan, calibration="tare"), 1e-3) is None


def test_where_samples_come_too_slowly_for_any_experiment_the_calibration_is_kept():
    measured = measurement(challenge(11, "cubic_stiffening").recording)
    base = fit_base(Composition(), [measured], EXACT)
    fits = fit_candidates(base, library("force_gain", "added_mass").values(), EXACT)
    slow = [replace(fit, measurements=(replace(measured, sample_period=0.05),)) for fit in fits]
    advice = suggest(slow, EXACT, EFFECTS)
    assert not advice.excitation
    assert "known weight" in advice.calibration


def test_how_it_is_recorded_and_ended_is_said():
    told = driver_command(suggestion(4), np.nan).notes[2]
    assert "recorder --ros-args -r __ns:=/probe -p output:=next.mcap" in told
    assert "activate, and 4 s later with deactivate" in told
