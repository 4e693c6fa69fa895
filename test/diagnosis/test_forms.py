"""Which forms of an effect are searched under a motion."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hidden import EXACT, challenge, measurement

from tissue_probe.diagnosis.candidates import fit_base
from tissue_probe.diagnosis.forms import forms_apart, leave_the_same
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS


def pressed_by(preload):
    """A Kelvin-Voigt fit of tissue without further effects."""
    made = challenge(31, preload=preload)
    return fit_base(Composition(), [measurement(made.recording)], EXACT)


@pytest.mark.parametrize("name", ["hunt_crossley", "exponential_stiffening", "contact_loss"])
def test_forms_that_differ_where_the_tip_comes_off_are_told_apart_only_where_it_does(name):
    pressed = forms_apart(pressed_by(3e-3), EFFECTS[name], EXACT)
    lifted = forms_apart(pressed_by(0.0), EFFECTS[name], EXACT)
    assert pressed == [EFFECTS[name].plain]
    assert len(lifted) > 1
    assert set(lifted) <= set(EFFECTS[name].every_form)


@pytest.mark.parametrize("name", ["backlash", "bouc_wen_hysteresis", "force_drift"])
def test_forms_of_other_physics_are_always_told_apart(name):
    assert forms_apart(pressed_by(3e-3), EFFECTS[name], EXACT) == list(EFFECTS[name].every_form)


def test_fits_leave_the_same_where_noise_would_not_let_them_be_told_apart():
    fit = pressed_by(3e-3)
    (residual,) = fit.residuals
    near, off = (replace(fit, residuals=(residual + s * fit.noise,)) for s in (0.009, 0.011))
    assert leave_the_same(fit, near)
    assert not leave_the_same(fit, off)
