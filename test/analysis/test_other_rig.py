"""Measurements of another rig than the one that is asked about."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tissue_probe as tp

STIFFNESS, DAMPING = 450.0, 4.0


def swept():
    """A rigid tip that follows a sweep of 2 to 20 Hz on Kelvin-Voigt tissue."""
    time = np.arange(0.0, 2.0, 1e-3)
    phase = 2.0 * np.pi * (2.0 * time + 4.5 * time**2)
    depth = 1e-3 * (1.0 - np.cos(phase))
    speed = 1e-3 * np.sin(phase) * 2.0 * np.pi * (2.0 + 9.0 * time)
    random = np.random.default_rng(3)
    force = STIFFNESS * depth + DAMPING * speed + 5e-3 * random.standard_normal(time.size)
    return {"t": time, "u": depth, "F": force}


def driven():
    """A mass on such tissue that a commanded force shakes; its position is measured."""
    time = np.arange(0.0, 2.0, 1e-3)

    def force(t):
        return 0.3 * np.sin(2.0 * np.pi * 7.0 * t) * np.minimum(t / 0.3, 1.0)

    solution = solve_ivp(
        lambda t, z: (z[1], (force(t) - STIFFNESS * z[0] - DAMPING * z[1]) / 0.05),
        (0.0, 2.0), (0.0, 0.0), t_eval=time, rtol=1e-9, atol=1e-12, max_step=1e-3,
    )  # fmt: skip
    noise = 1e-6 * np.random.default_rng(4).standard_normal(time.size)
    return {"t": time, "u": solution.y[0] + noise, "F": force(time)}


def rig_told(found) -> list[str]:
    return [note for note in found.notes if "is the rig" in note]


def test_the_rig_on_which_the_plain_model_explains_is_told():
    (note,) = rig_told(tp.diagnose(swept(), rig="compliant_probe", constants={"tip_mass": 0.04}))
    assert "the plain model of rigid_probe explains these measurements" in note


@pytest.mark.battery
def test_a_force_that_is_commanded_is_told():
    (note,) = rig_told(tp.diagnose(driven(), rig="rigid_probe"))
    assert "commanded and not measured; is the rig force_driven (`rig` force_driven)?" in note


def test_nothing_is_told_where_the_rig_is_right():
    assert not rig_told(tp.diagnose(swept(), rig="rigid_probe"))
    assert not rig_told(tp.diagnose(driven(), rig="force_driven"))
