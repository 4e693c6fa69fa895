"""Intervals of values by which something switches hold the truth, and no more than they must."""

import numpy as np

from tissue_probe.diagnosis.fitting.event_intervals import ask_likelihood
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.search import search
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import RIGID_PROBE
from tissue_probe.quantities import SIDE

STILL = Instrument(
    RIGID_PROBE,
    RIGID_PROBE.known | {"tip_mass": (0.0, 0.0), "contact_position": (0.0, 0.0)},
)
STIFFNESS, DAMPING, NOISE, PERIOD = 450.0, 2.0, 2e-3, 1e-3
#: Of 20 intervals of 95 % as many or more hold the truth, but in 8 % of all tries.
COUNT, LEAST_INSIDE = 20, 18
LAWS = ((lambda gap: np.maximum(1.0 - gap, 0.0), 1.0), (lambda gap: np.exp(-gap), np.log(100.0)))


def motion(random, count=4000):
    """Press in and lift off some times a second, the deeper the longer."""
    times = np.arange(count) * PERIOD
    angle = 2.0 * np.pi * random.uniform(2.0, 5.0) * times + random.uniform(0.0, 6.0)
    depth = 1.2e-3 * np.sin(angle) * (1.0 + 0.1 * times)
    return times, depth, STIFFNESS * depth + DAMPING * np.gradient(depth, times)


def noisy(depth, force, random):
    return Measurement(
        depth, force + NOISE * random.standard_normal(force.size), PERIOD, at_rest=False
    )


def torn(form, bond, extent, random):
    """Record a tip whose bond gives way evenly (0), or as threads (1), over a gap."""
    held, torn_at = LAWS[form]
    _, depth, tissue = motion(random)
    bridged, force = True, np.zeros(depth.size)
    for place, (x, pull) in enumerate(zip(depth, tissue, strict=True)):
        bridged = x > -torn_at * extent if bridged else x > 0.0
        if bridged:
            force[place] = max(pull, -bond * held(max(-x, 0.0) / extent))
    return noisy(depth, force, random)


def fit_from(measurement, effect, **truth):
    """Fit from the true values, so that no search goes astray."""
    composition = Composition("rigid_probe", effects=(effect.plain,))
    problem = Problem(composition, [measurement], STILL)
    known = {"stiffness": STIFFNESS, "damping": DAMPING, "tip_mass": 0.0, "contact_position": 0.0}
    values = np.array([{**known, **truth}[entry.name] for entry in composition.values])
    return search(problem, values, [begun.mean for begun in problem.begin(values)])


def holds(fit, name, truth):
    return abs(fit.named()[name] - truth) <= SIDE * fit.deviations()[name]


def test_the_range_of_a_bond_lies_in_its_interval():
    """Strong ones yield so late that only the samples at which they are torn tell their range."""
    inside = 0
    for seed in range(COUNT):
        random = np.random.default_rng(seed)
        form, bond = seed % 2, random.uniform(2.0, 20.0)
        extent = random.uniform(1e-4, 9e-4) / LAWS[form][1]
        measurement = torn(form, bond, extent, random)
        effect = EFFECTS["adhesion_within_range"].every_form[form]
        fit = fit_from(measurement, effect, bond_force=bond, adhesion_range=extent)
        inside += holds(ask_likelihood(fit, STILL), "adhesion_range", extent)
    assert inside >= LEAST_INSIDE


def test_the_instant_of_a_step_lies_in_its_interval():
    inside = 0
    for seed in range(COUNT):
        random = np.random.default_rng(seed)
        times, depth, force = motion(random, 2000)
        instant, change = random.uniform(0.4, 1.6), random.uniform(5.0, 60.0)
        measurement = noisy(depth, force + change * (times >= instant) * depth, random)
        fit = fit_from(
            measurement, EFFECTS["stiffness_step"], step_change=change, step_time=instant
        )
        inside += holds(ask_likelihood(fit, STILL), "step_time", instant)
    assert inside >= LEAST_INSIDE


def test_a_range_that_no_lift_reaches_is_open_to_its_bound():
    measurement = torn(0, 0.2, 9e-3, np.random.default_rng(3))
    effect = EFFECTS["adhesion_within_range"]
    fit = fit_from(measurement, effect, bond_force=5.0, adhesion_range=9e-3)
    asked = ask_likelihood(fit, STILL)
    assert asked.named()["adhesion_range"] + SIDE * asked.deviations()["adhesion_range"] >= 1e-2


def test_values_by_which_nothing_switches_keep_their_intervals():
    random = np.random.default_rng(5)
    _, depth, force = motion(random)
    measurement = noisy(depth, force + 2e7 * depth**3, random)
    fit = fit_from(measurement, EFFECTS["cubic_stiffening"], cubic_stiffness=2e7)
    assert ask_likelihood(fit, STILL) is fit
