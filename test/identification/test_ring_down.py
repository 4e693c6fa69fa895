"""Stiffness and damping of the tool from an impulse, as in the paper's fig. 6."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tissue_probe.identification.ring_down import fit_ring_down, ring_down

PERIOD = 5e-4
MASS, K0, BETA0 = 0.04, 9700.0, 0.8


def struck(noise: float, seed: int = 0, k0: float = K0, beta0: float = BETA0) -> np.ndarray:
    """A second: at rest, struck at 0.1 s, ringing down."""
    time = np.arange(1800) * PERIOD
    quiet = np.full(200, 0.0)
    force = np.concatenate([quiet, ring_down(time, k0, beta0, MASS, 8e-3)])
    return 0.3 + force + noise * np.random.default_rng(seed).standard_normal(force.size)


def test_the_formula_is_the_motion_of_the_equation():
    time = np.arange(400) * PERIOD
    motion = solve_ivp(
        lambda t, y: (y[1], -(K0 * y[0] + BETA0 * y[1]) / MASS),
        (0.0, time[-1]),
        (0.0, 8e-3),
        t_eval=time,
        rtol=1e-9,
        atol=1e-12,
    )
    assert ring_down(time, K0, BETA0, MASS, 8e-3) == pytest.approx(K0 * motion.y[0], abs=1e-6)


def test_the_papers_tool_is_found_without_noise():
    found = fit_ring_down(struck(0.0), PERIOD, MASS)
    assert found.stiffness == pytest.approx(K0, rel=1e-6)
    assert found.damping == pytest.approx(BETA0, rel=1e-4)
    assert found.frequency == pytest.approx(78.4, abs=0.05)


@pytest.mark.parametrize("unit", [1.0, -0.5, 1000.0])
def test_neither_unit_nor_sign_of_the_force_matters(unit):
    found, same = (fit_ring_down(u * struck(0.002), PERIOD, MASS) for u in (1.0, unit))
    assert same.stiffness == pytest.approx(found.stiffness, rel=1e-6)
    assert same.damping == pytest.approx(found.damping, rel=1e-4)


def test_the_intervals_hold_the_truth_as_often_as_they_say():
    hits = np.zeros(2)
    for seed in range(200):
        found = fit_ring_down(struck(0.005, seed), PERIOD, MASS)
        hits += [
            found.stiffness_interval[0] <= K0 <= found.stiffness_interval[1],
            found.damping_interval[0] <= BETA0 <= found.damping_interval[1],
        ]
    assert np.all(hits / 200 > 0.90)
    assert np.all(hits / 200 < 0.99)


def test_doubt_about_the_mass_is_doubt_about_stiffness_and_damping():
    sure, unsure = (fit_ring_down(struck(0.001), PERIOD, MASS, each) for each in (0.0, 0.0004))
    assert unsure.stiffness_deviation == pytest.approx(0.01 * K0, rel=0.05)
    assert unsure.damping_deviation > sure.damping_deviation
    assert unsure.stiffness == sure.stiffness


@pytest.mark.parametrize("k0", [2000.0, 30_000.0])
@pytest.mark.parametrize("beta0", [0.2, 3.0])
def test_other_tools_are_found_too(k0, beta0):
    found = fit_ring_down(struck(0.001, k0=k0, beta0=beta0), PERIOD, MASS)
    assert found.stiffness == pytest.approx(k0, rel=0.01)
    assert found.damping == pytest.approx(beta0, rel=0.05)


def grows() -> np.ndarray:
    time = np.arange(2000) * PERIOD
    return np.exp(3.0 * time) * np.sin(500.0 * time)


@pytest.mark.parametrize(
    ("force", "said"),
    [
        (np.full(100, np.nan), "missing in some samples"),
        (np.zeros(1000), "does not swing|does not decay|no decaying swing"),
        (np.random.default_rng(0).standard_normal(2000), "does not swing|decay"),
        (grows(), "does not swing|decay"),
        (np.array([1.0]), "does not swing"),
    ],
)
def test_what_is_no_ring_down_is_refused(force, said):
    with pytest.raises(ValueError, match=said):
        fit_ring_down(force, PERIOD, MASS)
