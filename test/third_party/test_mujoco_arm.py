"""The arm of `live_loop` feels its tool as bodies do, and turns as briskly as it says."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="mujoco is not installed: pip install mujoco")
from benchmarks.live_loop.arm import MASS, Cable, World


def test_at_rest_the_sensor_feels_weight_and_its_lever():
    world = World(3)
    held = world.hold(0.0, 0.1)
    load = held.true - world.drifted(held.time)
    np.testing.assert_allclose(np.linalg.norm(load[:, :3], axis=1), 9.80665 * MASS, rtol=1e-6)
    lever = np.cross(world.tool.centre, load[:, :3])
    np.testing.assert_allclose(load[:, 3:], lever, atol=1e-6)


def test_a_cable_pulls_at_its_end_along_itself():
    bare, cabled = World(3), World(3, Cable(10.0))
    one, other = bare.hold(0.0, 0.1), cabled.hold(0.0, 0.1)
    pull = other.true - one.true
    end = np.array([0.05, 0.02, 0.08])
    np.testing.assert_allclose(pull[:, 3:], np.cross(end, pull[:, :3]), atol=1e-6)
    assert np.linalg.norm(pull[0, :3]) > 0.5


def test_it_moves_as_briskly_as_it_says():
    moved = World(0).move(0.0, 20.0)
    acceleration = np.diff(moved.position[::25], 2, axis=0) / 0.1**2
    assert 0.3 < np.sqrt(np.mean(np.sum(acceleration**2, axis=1))) < 0.8
