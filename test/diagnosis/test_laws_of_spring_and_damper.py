"""Springs with a knee, dampings that change with the speed, stiffness that settles: named, right.

By formulas and integrators of this file, on a rig that leads the tip.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import RIGID_PROBE

STILL = Instrument(RIGID_PROBE, RIGID_PROBE.known | {"tip_mass": (0.0, 0.0)})
LIBRARY = {
    name: EFFECTS[name]
    for name in (
        *("bilinear_spring", "cubic_stiffening", "nonlinear_damping", "coulomb_friction"),
        *("stiffness_step", "stiffness_ramp"),
    )
}
NOISE = 5e-3
TIMES = np.arange(0.0, 2.0, 1e-3)
RATES = 2.0 * np.pi * np.array([3.0, 7.0, 13.0, 22.0])
PHASES = np.array([0.3, 1.9, 4.0, 5.1])


def way(times):
    """Four sines [m], and their speed [m/s]."""
    angles = np.multiply.outer(times, RATES) + PHASES
    return 4e-4 * np.sin(angles).sum(-1), 4e-4 * (np.cos(angles) * RATES).sum(-1)


def recent(times, memory):
    """Mean size of the speed in the recent past, from rest."""
    told = solve_ivp(
        lambda t, s: (np.abs(way(t)[1]) - s) / memory,
        (0.0, 2.0),
        [0.0],
        t_eval=times,
        max_step=1e-3,
    )
    return told.y[0]


@pytest.mark.parametrize(
    ("law", "name", "values"),
    [
        (
            lambda t, u, v: 150.0 * np.maximum(u - 3e-4, 0.0),
            "bilinear_spring",
            {"stiffness_beyond_knee": 150.0, "knee_depth": 3e-4},
        ),
        (
            lambda t, u, v: -120.0 * np.maximum(u, 0.0),
            "bilinear_spring",
            {"stiffness_beyond_knee": -120.0},
        ),
        (
            lambda t, u, v: 20.0 * np.abs(v) * v,
            "nonlinear_damping",
            {"quadratic_damping": 20.0},
        ),
        (
            lambda t, u, v: 1.5 * np.abs(v),
            "nonlinear_damping",
            {"damping_by_direction": 1.5},
        ),
        (
            lambda t, u, v: 4.0 * 1e-2 * np.sign(v) * np.sqrt(np.abs(v) / 1e-2),
            "nonlinear_damping",
            {"damping_at_10_mm_s": 4.0, "speed_exponent": 0.5},
        ),
        (
            lambda t, u, v: -30.0 * recent(t, 0.12) * v,
            "nonlinear_damping",
            {"quadratic_damping": -30.0, "speed_memory": 0.12},
        ),
    ],
    ids=["knee", "direction", "quadratic", "one way", "power", "thixotropic"],
)
def test_a_law_is_named_with_its_values(law, name, values):
    position, speed = way(TIMES)
    noise = NOISE * np.random.default_rng(5).standard_normal(TIMES.size)
    force = 450.0 * position + 6.0 * speed + law(TIMES, position, speed) + noise
    measured = Measurement(position, force, 1e-3)
    found = diagnose(Composition("rigid_probe"), [measured], STILL, LIBRARY)
    assert (found.verdict, found.effects) == ("missing", (name,))
    fitted, deviations = found.ladder.final.named(), found.ladder.final.deviations()
    for each, truth in values.items():
        assert abs(fitted[each] - truth) < 4.0 * deviations[each]
        assert deviations[each] < 0.1 * abs(truth)
