"""Tissue that is softer wherever it was pressed deeper before: named, with its values.

By formulas of this file, on a rig that leads the tip.
"""

import numpy as np
import pytest
from scipy.special import erf

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import RIGID_PROBE

STILL = Instrument(RIGID_PROBE, RIGID_PROBE.known | {"tip_mass": (0.0, 0.0)})
LIBRARY = {
    name: EFFECTS[name]
    for name in ("damage_by_depth", "cubic_stiffening", "stiffness_ramp", "standard_linear_solid")
}
NOISE, SHARE, DEPTH = 2e-3, 0.5, 1.5e-3
TIMES = np.arange(0.0, 4.0, 1e-3)
RATE = 2.0 * np.pi * 3.0


def growing():
    """Press deeper from period to period, from rest: position [m] and speed [m/s]."""
    size, grows = 5e-4 * (1.0 + TIMES), 5e-4
    depth = size * (1.0 - np.cos(RATE * TIMES))
    speed = grows * (1.0 - np.cos(RATE * TIMES)) + size * RATE * np.sin(RATE * TIMES)
    return depth, speed


def measured(kept, before=0.0):
    """Return a record of tissue that keeps a share of its force, after a depth ``before``."""
    depth, speed = growing()
    largest = np.maximum(np.maximum.accumulate(depth), before)
    noise = NOISE * np.random.default_rng(3).standard_normal(TIMES.size)
    force = 450.0 * depth * kept(depth, largest) + 4.0 * speed + noise
    return Measurement(depth, force, 1e-3)


KEPT = {
    "weaker spring": lambda x, m: 1.0 - SHARE * (1.0 - np.exp(-m / DEPTH)),
    "intact where it goes deeper": lambda x, m: 1.0 - SHARE * erf((m**2 - x**2) / DEPTH**2),
}


@pytest.mark.parametrize("law", KEPT)
def test_damage_by_the_largest_depth_is_named_with_its_values(law):
    found = diagnose(Composition("rigid_probe"), [measured(KEPT[law])], STILL, LIBRARY)
    assert (found.verdict, found.effects) == ("missing", ("damage_by_depth",))
    fitted, deviations = found.ladder.final.named(), found.ladder.final.deviations()
    for name, truth in {"damage_share": SHARE, "damage_depth": DEPTH, "stiffness": 450.0}.items():
        assert abs(fitted[name] - truth) < 4.0 * deviations[name]
        assert deviations[name] < 0.1 * truth


def test_tissue_that_was_pressed_before_begins_with_its_damage():
    kept = KEPT["intact where it goes deeper"]
    found = diagnose(Composition("rigid_probe"), [measured(kept, 2.5e-3)], STILL, LIBRARY)
    assert (found.verdict, found.effects) == ("missing", ("damage_by_depth",))
    assert found.ladder.final.named()["largest_depth_before"] == pytest.approx(2.5e-3, rel=0.02)


@pytest.mark.parametrize("form", EFFECTS["damage_by_depth"].every_form)
def test_the_first_sample_is_at_the_largest_depth_of_the_recording_so_far(form):
    """A start that the noise in newtons left open by as many metres would be another depth."""
    measurement = measured(KEPT["weaker spring"])
    problem = Problem(Composition("rigid_probe", effects=(form,)), [measurement], STILL)
    (begun,) = problem.begin(problem.nominal)
    place = problem.kernel.states.index("withdrawn_from_largest")
    assert begun.mean[place] == 0.0
    assert begun.deviation[place] < 1e-3 * DEPTH
