"""Relaxation that several branches make, and a curved spring that relaxes as a whole."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import RIGID_PROBE

MASSLESS = Instrument(RIGID_PROBE, RIGID_PROBE.known | {"tip_mass": (0.0, 0.0)})
NOISE = 4e-3
RATES = np.array([1.0 / 40.0, 1.0 / 5.0, 1.5])
LIBRARY = {
    name: EFFECTS[name].with_odds(1.0)
    for name in (
        *("standard_linear_solid", "generalized_maxwell", "quasi_linear_relaxation"),
        "poroelastic_relaxation",
        *("hertz_contact", "cubic_stiffening", "stiffness_step", "force_drift"),
    )
}


def depth(times, seed):
    """Steps of 0.3 mm that take 2 s, each held for 18 s: two up, one down, and so on [m]."""
    times = np.maximum(times, 0.0)
    s = np.clip((times % 20.0) / 2.0, 0.0, 1.0)
    ways = np.array([1.0, 1.0, -1.0, 1.0, 1.0, -1.0]) if seed % 2 else np.tile([2.0, -1.0], 3)
    number = np.minimum((times // 20.0).astype(int), ways.size - 1)
    before = np.concatenate([[0.0], np.cumsum(ways)])[number]
    return 3e-4 * (before + ways[number] * s**3 * (10.0 - 15.0 * s + 6.0 * s**2))


def relaxing(spring, weights, seed):
    """Record the spring's force times 1 + sum of weights exp(-rate t), by another integrator."""
    times = np.arange(0.0, 120.0, 0.1)
    position = depth(times, seed)

    def slope(time, forces):
        ahead, behind = (spring(depth(np.array(time + way), seed)) for way in (1e-4, -1e-4))
        return np.multiply(weights, (ahead - behind) / 2e-4) - RATES * forces

    forces = solve_ivp(
        slope, (0.0, times[-1]), np.zeros(3), t_eval=times, max_step=0.1, rtol=1e-8, atol=1e-9
    ).y
    force = spring(position) + forces.sum(axis=0)
    force = force + NOISE * np.random.default_rng(seed).standard_normal(times.size)
    return Measurement(position, force, 0.1, at_rest=True)


@pytest.mark.parametrize(
    ("spring", "named"),
    [
        (lambda x: 1900.0 * x, {"generalized_maxwell"}),
        (lambda x: 6e4 * np.maximum(x, 0.0) ** 1.5, {"hertz_contact", "quasi_linear_relaxation"}),
    ],
    ids=["straight", "Hertz"],
)
def test_three_relaxation_times_are_named_and_carry_over(spring, named):
    weights = [0.45, 0.35, 0.5]
    records = [relaxing(spring, weights, seed) for seed in (1, 2)]
    found = diagnose(Composition("rigid_probe"), records[:1], MASSLESS, LIBRARY, records[1:])
    assert (found.verdict, set(found.effects)) == ("missing", named)
    final = found.ladder.final
    assert found.heldout(final) < 1.15 * NOISE
    rates = sorted(value for name, value in final.named().items() if "relaxation_rate" in name)
    np.testing.assert_allclose(rates, RATES, rtol=0.3)


def draining(law, rate, seed):
    """Record a straight spring with fluid in its pores: the convolution of its relaxation."""
    times = np.arange(0.0, 120.0, 0.1)
    fine = np.arange(0.0, 120.0, 0.01)
    position, ways = depth(times, seed), np.diff(depth(fine, seed), prepend=0.0)
    left = law(rate * np.maximum(fine - 0.005, 0.0))
    force = 1500.0 * position + 1200.0 * np.convolve(ways, left)[: fine.size][::10]
    force = force + NOISE * np.random.default_rng(seed).standard_normal(times.size)
    return Measurement(position, force, 0.1, at_rest=True)


def under_sphere(time):
    return 0.491 * np.exp(-0.908 * np.sqrt(time)) + 0.509 * np.exp(-1.679 * time)


def under_punch(time):
    return 1.304 * np.exp(-np.sqrt(time)) - 0.304 * np.exp(-0.254 * time)


@pytest.mark.parametrize("rate", [0.05, 0.2])
@pytest.mark.parametrize("law", [under_sphere, under_punch])
def test_fluid_that_flows_away_is_named_and_carries_over(law, rate):
    records = [draining(law, rate, seed) for seed in (1, 2)]
    library = {**LIBRARY, "springpot": EFFECTS["springpot"]}
    found = diagnose(Composition("rigid_probe"), records[:1], MASSLESS, library, records[1:])
    assert (found.verdict, found.effects) == ("missing", ("poroelastic_relaxation",))
    final = found.ladder.final
    assert found.heldout(final) < 1.1 * NOISE
    assert final.named()["diffusion_rate"] == pytest.approx(rate, rel=0.05)
    assert final.named()["fluid_stiffness"] == pytest.approx(1200.0, rel=0.03)


def test_fluid_is_tried_only_where_somebody_asks_for_it():
    record = draining(under_sphere, 0.2, 1)
    own = {**LIBRARY, "poroelastic_relaxation": EFFECTS["poroelastic_relaxation"]}
    question = Composition("rigid_probe"), [record], MASSLESS, own
    assert diagnose(*question).effects == ("generalized_maxwell",)
    added = diagnose(*question, wanted=["poroelastic_relaxation"])
    assert (added.verdict, added.effects) == ("missing", ("poroelastic_relaxation",))
