"""MuJoCo's probe: as exact as its records need, and each of its terms does what the table says."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="mujoco is not installed: pip install mujoco")

from dataclasses import replace

from benchmarks.protocols.catalogue import wave
from benchmarks.protocols.motion import COMPLIANT, DRIVEN, Rig
from benchmarks.protocols.motion import simulate as by_scipy
from benchmarks.protocols.specimen import Specimen
from benchmarks.third_party.mujoco_probe import STEP, Probe, simulate
from benchmarks.third_party.mujoco_records import HIDDEN, deal

TIMES = np.arange(600) / 2000.0
PLAIN = Probe(600.0, 1.5, 0.04, 9700.0, 0.8)
DRIVEN_TIP = replace(PLAIN, cell_stiffness=0.0, cell_damping=0.0)
#: A share of the largest force that is small beside the noise of any record.
EXACT = 3e-4


def drive(size=1e-3, mean=0.0):
    return wave(np.random.default_rng(1), "sweep", 5.0, 25.0, 0.4, size, mean)


@pytest.mark.parametrize(
    "part",
    [
        {},
        {"friction": 0.05},
        {"armature": 0.02},
        {"branch_stiffness": 200.0, "branch_time": 0.02},
        {"one_sided": True},
        {"play": 3e-5},
    ],
    ids=lambda part: next(iter(part), "plain"),
)
def test_half_the_step_gives_the_same_force(part):
    probe = replace(PLAIN, **part)
    _, force = simulate(probe, drive(), TIMES)
    _, finer = simulate(probe, drive(), TIMES, STEP / 2.0)
    assert np.sqrt(np.mean((force - finer) ** 2)) < 10.0 * EXACT * np.ptp(force)


@pytest.mark.parametrize(
    ("part", "same"),
    [
        ({}, {}),
        (
            {"branch_stiffness": 200.0, "branch_time": 0.02},
            {"branch_stiffness": (200.0,), "branch_rate": (50.0,)},
        ),
        ({"armature": 0.02}, {"mass": 0.06}),
    ],
    ids=["plain", "branch", "armature"],
)
def test_a_load_cell_reads_what_scipy_integrates(part, same):
    _, force = simulate(replace(PLAIN, **part), drive(), TIMES)
    specimen = replace(Specimen(600.0, 1.5, 0.04), **same)
    expected = by_scipy(Rig(COMPLIANT, 9700.0, 0.8), specimen, drive(), TIMES, 0.0).force
    np.testing.assert_allclose(force, expected, atol=EXACT * np.ptp(expected))


def test_a_driven_tip_moves_as_scipy_integrates():
    place, _ = simulate(DRIVEN_TIP, drive(0.5), TIMES)
    specimen = Specimen(600.0, 1.5, 0.04)
    expected = by_scipy(Rig(DRIVEN), specimen, drive(0.5), TIMES, 0.0).position
    np.testing.assert_allclose(place, expected, atol=EXACT * np.ptp(expected))


def test_friction_loss_is_dry_friction():
    place, _ = simulate(replace(DRIVEN_TIP, friction=0.2), drive(0.5), TIMES)
    specimen = Specimen(600.0, 1.5, 0.04, friction=0.2)
    expected = by_scipy(Rig(DRIVEN), specimen, drive(0.5), TIMES, 0.0).position
    np.testing.assert_allclose(place, expected, atol=0.01 * np.ptp(expected))


def test_a_plate_is_never_pulled():
    # So slow that the tip's inertia is next to nothing.
    slow = wave(np.random.default_rng(1), "sine", 3.0, 3.0, 0.4, 1e-3, 0.0)
    _, force = simulate(replace(PLAIN, one_sided=True), slow, TIMES)
    _, bonded = simulate(PLAIN, slow, TIMES)
    assert bonded.min() < -0.1
    assert force.min() > 0.15 * bonded.min()
    assert force.max() > 0.9 * bonded.max()


def test_clean_records_are_the_same_for_the_same_seed():
    first, again = deal(3, "").first, deal(3, "").first
    np.testing.assert_array_equal(first.force, again.force)
    assert first.noise > 0.0


@pytest.mark.slow
def test_what_is_hidden_leaves_more_than_the_noise():
    truth = deal(1, "armature").truth
    assert truth.effects == HIDDEN["armature"].effects
    assert 2.0 <= truth.ratio <= 20.0
