"""A fit's numbers are as right as their intervals say, however coarse the samples are."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lsim, lti

from tissue_probe.diagnosis.diagnosis import diagnose, fit_plainly
from tissue_probe.diagnosis.fitting.accuracy import UNSEEN, doubt, widen_covariance
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidates import fit_base
from tissue_probe.diagnosis.revisions.fineness import finer
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.response import Between, Fineness
from tissue_probe.physics.rigs import FORCE_DRIVEN
from tissue_probe.quantities import POSITION

pytestmark = pytest.mark.timeout(900)

RIG = Composition(FORCE_DRIVEN)

FREE = Instrument(FORCE_DRIVEN, FORCE_DRIVEN.known | {"contact_position": (0.0, 0.0)})
MASS, STIFFNESS, CUBE, NOISE = 0.05, 5e2, 2e8, 2e-7
RESONANCE = np.sqrt(STIFFNESS / MASS)


def measured(rate, damping, cube=0.0, seed=0, count=3000, noise=NOISE):
    """Return a tip pushed by lines up to twice its resonance, at so many samples a period of it."""
    period = 2 * np.pi / RESONANCE / rate
    random = np.random.default_rng(seed)
    lines = 2 * np.pi * np.arange(1, 200) / (count * period)
    lines = lines[lines < 2.0 * RESONANCE][:, np.newaxis]
    phases = random.uniform(0, 2 * np.pi, lines.shape)
    size = 0.4 / np.sqrt(lines.size)

    def push(time):
        return size * np.sum(np.sin(lines * time + phases) - np.sin(phases), axis=0)

    def rates(time, z):
        pull = STIFFNESS * z[0] + damping * z[1] + cube * z[0] ** 3
        return [z[1], (push(np.atleast_1d(time))[0] - pull) / MASS]

    times = np.arange(count) * period
    solved = solve_ivp(rates, (0, times[-1]), [0.0, 0.0], "DOP853", times, rtol=1e-10, atol=1e-14)
    position = solved.y[0] + noise * random.standard_normal(count)
    return Measurement(position, push(times), period, at_rest=True, output=POSITION)


def off(fit, **truth):
    """Return by how many half-widths of their intervals values are off, at the most."""
    found, deviations = fit.named(), fit.deviations()
    return max(abs(found[name] - true) / (1.96 * deviations[name]) for name, true in truth.items())


def deviations_of(fit):
    return np.sqrt(np.diag(fit.covariance))[fit.values > 0]


@pytest.fixture(scope="module")
def coarse():
    return measured(8.0, 0.1)


def test_the_spline_through_a_coarse_force_moves_the_values_as_it_is_told(coarse):
    fit = fit_base(RIG, [coarse], FREE)
    smoother = fit_base(RIG, [replace(coarse, fineness=Fineness(degree=9))], FREE)
    moved = (smoother.values - fit.values)[fit.values > 0] / deviations_of(fit)
    told = doubt(fit, FREE).by_course[fit.values > 0]
    assert np.abs(told).max() > UNSEEN
    np.testing.assert_allclose(-moved, told, atol=0.1)


def test_a_linear_tip_under_a_coarse_force_has_its_values(coarse):
    fit = fit_plainly(RIG, [coarse], FREE)
    assert off(fit, tip_mass=MASS, stiffness=STIFFNESS, damping=0.1) < 2.0
    assert doubt(fit, FREE).course < UNSEEN
    assert fit.rmse == pytest.approx(NOISE, rel=0.05)


def test_a_linear_model_has_no_error_of_steps(coarse):
    assert doubt(fit_base(RIG, [coarse], FREE), FREE).step == 0.0


@pytest.mark.battery
@pytest.mark.parametrize("rate", [8.0, 20.0])
def test_a_stiffening_resonance_is_named_and_its_values_hold(rate):
    first, second = measured(rate, 0.2, CUBE), measured(rate, 0.2, CUBE, seed=1)
    found = diagnose(RIG, [first], FREE, EFFECTS, [second])
    assert (found.verdict, found.effects) == ("missing", ("cubic_stiffening",))
    truth = {"tip_mass": MASS, "stiffness": STIFFNESS, "damping": 0.2, "cubic_stiffness": CUBE}
    assert off(found.ladder.final, **truth) < 2.0
    assert found.heldout(found.ladder.final) == pytest.approx(NOISE, rel=0.1)


def test_what_is_fine_enough_is_left_as_it_is():
    fit = fit_base(RIG, [measured(60.0, 5.0)], FREE)
    assert finer(fit, FREE) is None
    assert widen_covariance(fit, FREE) is fit


def test_what_samples_are_too_few_for_widens_the_intervals_and_is_told():
    """Lines up to 98 hundredths of half the sampling rate, and next to no noise."""
    measurement = measured(4.1, 0.3, noise=1e-4 * NOISE)
    fit = fit_plainly(RIG, [measurement], FREE)
    assert fit.measurements[0].fineness.degree == 7
    wider = widen_covariance(fit, FREE)
    assert wider.deviations()["tip_mass"] > fit.deviations()["tip_mass"]
    found = diagnose(RIG, [measurement], FREE, {})
    assert "coarse" in [finding.name for finding in found.findings]
    assert found.ladder.base.deviations() == pytest.approx(wider.deviations())


def test_a_course_with_corners_is_not_made_smooth():
    """Straight lines between the samples: their response is known exactly."""
    period, count = 4e-3, 1500
    force = 0.4 * np.sin(np.cumsum(np.random.default_rng(3).uniform(0.0, 0.6, count)))
    force -= force[0]
    times = np.arange(count) * period
    tip = lti([1.0], [MASS, 3.0, STIFFNESS])
    position = lsim(tip, force, times, interp=True)[1]
    position = position + NOISE * np.random.default_rng(4).standard_normal(count)
    measurement = Measurement(position, force, period, at_rest=True, output=POSITION)
    straight = replace(measurement, between=Between.straight)
    fit = fit_plainly(RIG, [straight], FREE)
    assert {each.fineness.degree for each in fit.measurements} == {3}
    assert off(fit, tip_mass=MASS, stiffness=STIFFNESS, damping=3.0) < 2.0
    assert fit.ratio == pytest.approx(1.0, abs=0.05)
