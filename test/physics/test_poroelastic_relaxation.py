"""The relaxation of tissue with fluid in its pores, against the published function."""

import numpy as np
import pytest
from composed import PERIOD, force_of, values_of

from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.effects.poroelastic_relaxation import FLUID_BRANCHES, FLUID_STIFFNESS

POROELASTIC = EFFECTS["poroelastic_relaxation"]
STIFFNESS, RATE = 300.0, 4.0


def sphere(T):
    return 0.491 * np.exp(-0.908 * np.sqrt(T)) + 0.509 * np.exp(-1.679 * T)


def cone(T):
    return 0.493 * np.exp(-0.822 * np.sqrt(T)) + 0.507 * np.exp(-1.348 * T)


def punch(T):
    return 1.304 * np.exp(-np.sqrt(T)) - 0.304 * np.exp(-0.254 * T)


FORMS = {sphere: 0, punch: 1}


def kernel(form, T):
    """Return the part of the strength that is left at T = D t / a^2, by the effect's branches."""
    effect = POROELASTIC.every_form[form]
    weights = [float((effect.force / FLUID_STIFFNESS).coeff(each)) for each in FLUID_BRANCHES]
    per_time = effect.parameters[1].symbol
    rates = [-float(each.motion.coeff(each.symbol) / per_time) for each in effect.states]
    return np.exp(-np.outer(T, rates)) @ weights


@pytest.mark.parametrize(("law", "most"), [(sphere, 1e-3), (punch, 1.3e-3)])
def test_its_exponentials_follow_the_published_function(law, most):
    T = np.geomspace(1.0 / 300.0, 1e3, 4000)
    assert np.abs(kernel(FORMS[law], T) - law(T)).max() < most


def test_a_cone_relaxes_as_a_sphere_does_in_another_time():
    T = np.geomspace(1e-6, 1e3, 4000)
    assert np.abs(sphere(0.807 * T) - cone(T)).max() < 1e-3


@pytest.mark.parametrize("law", FORMS)
def test_a_held_tip_feels_the_published_relaxation(law):
    """Pressed in within 20 ms and held: the convolution of the function with the motion."""
    composition = Composition("rigid_probe", effects=(POROELASTIC.every_form[FORMS[law]],))
    times = np.arange(3000) * PERIOD
    s = np.clip(times / 0.02, 0.0, 1.0)
    depth = 1e-3 * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    own = {"fluid_stiffness": STIFFNESS, "diffusion_rate": RATE, "damping": 0.0}
    values = values_of(composition, stiffness=200.0, tip_mass=0.0, contact_position=0.0, **own)
    force = force_of(composition, values, depth, PERIOD).output
    middles = 0.5 * (times[1:] + times[:-1])
    held = times > 0.03
    relaxed = [np.diff(depth)[: n - 1] @ law(RATE * (times[n - 1] - middles[: n - 1]))
               for n in np.flatnonzero(held)[::50] + 1]  # fmt: skip
    expected = 200.0 * depth[held][::50] + STIFFNESS * np.array(relaxed)
    np.testing.assert_allclose(force[held][::50], expected, atol=2e-3 * STIFFNESS * 1e-3)
