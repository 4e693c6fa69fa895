"""Motions with corners: how they go on between two samples is not known there."""

import numpy as np
import pytest

import tissue_probe as tp
from tissue_probe.diagnosis.fitting.corners import corners

PERIOD, STIFFNESS, DAMPING, NOISE = 0.05, 500.0, 200.0, 2e-3


def triangles(seed, slow, friction=0.0, depth=1.5e-3):
    """Straight ramps that turn between samples, from the middle of the record on slower ones."""
    time = PERIOD * np.arange(1200)
    cycle = np.where(time < 31.8, 5.3, slow)
    phase = np.where(time < 31.8, time / 5.3, 6.0 + (time - 31.8) / slow)
    up = phase % 1.0 < 0.5
    position = depth * (1.0 - np.abs(2.0 * (phase % 1.0) - 1.0))
    speed = np.where(up, 2.0, -2.0) * depth / cycle
    force = STIFFNESS * position + DAMPING * speed + friction * np.sign(speed)
    force += NOISE * np.random.default_rng(seed).standard_normal(time.size)
    return {"t": time, "u": position, "F": force}


def diagnosed(friction):
    return tp.diagnose(
        triangles(1, 9.1, friction),
        validate=triangles(2, 7.7, friction),
        rig="rigid_probe",
        constants={"tip_mass": 0.0},
    )


def test_what_a_corner_between_two_samples_does_is_no_effect():
    found = diagnosed(friction=0.0)
    answer = found.to_dict()
    assert answer["verdict"] == "adequate"
    (told,) = [each for each in answer["findings"] if "corners" in each]
    assert "samples beside corners of the position that drives" in told
    values = answer["ladder"][0]["parameters"]
    assert values["stiffness"]["value"] == pytest.approx(STIFFNESS, rel=2e-3)
    assert values["damping"]["value"] == pytest.approx(DAMPING, rel=2e-3)
    assert answer["rmse"]["heldout"]["final"] < 1.1 * NOISE


def test_dry_friction_is_found_beside_corners():
    answer = diagnosed(friction=0.04).to_dict()
    assert (answer["verdict"], answer["effects"]) == ("missing", ["coulomb_friction"])
    assert answer["rmse"]["heldout"]["final"] < 1.1 * NOISE


@pytest.mark.parametrize("fastest", [10.0, 100.0])
def test_a_smooth_motion_has_no_corners(fastest):
    time = np.arange(4000) / 2000.0
    noise = 1e-8 * np.random.default_rng(0).standard_normal(time.size)
    sweep = 1e-3 * np.sin(2 * np.pi * (1.0 + 0.25 * (fastest - 1.0) * time) * time)
    assert not corners(sweep + noise).any()
    assert not corners(sweep).any()


def test_only_the_samples_about_a_corner_are_near_it():
    position = triangles(1, 9.1)["u"]
    near, at = corners(position), np.flatnonzero(np.diff(np.sign(np.diff(position)))) + 1
    assert near[at].all()
    assert near.sum() < 20 * at.size


@pytest.mark.parametrize("jitter", [0.0, 0.1])
def test_a_motion_that_is_over_between_two_samples_tells_of_no_damping(jitter):
    """Position and force step at once, and a spline through both would ring alike: no damping."""
    random = np.random.default_rng(3)
    time = PERIOD * (np.arange(800) + jitter * random.uniform(-1.0, 1.0, 800))
    position = np.where(np.arange(800) < 1, 0.0, 2e-3)
    force = STIFFNESS * position + NOISE * random.standard_normal(time.size)
    recording = tp.read({"t": time, "u": position, "F": force}, force_polarity="compression")
    found = tp.compare(recording, rig="rigid_probe", constants={"tip_mass": 0.0}, starts="at-rest")
    values, deviations = found.fit.named(), found.fit.deviations()
    assert values["stiffness"] == pytest.approx(STIFFNESS, rel=1e-3)
    assert values["damping"] + 1.96 * deviations["damping"] > DAMPING
