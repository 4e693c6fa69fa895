"""A line at a multiple of the drive's frequency, against effects."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hidden import EXACT, TOLERANT, challenge, library, measurement
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.analysis.verdict_in_words import verdict
from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates
from tissue_probe.diagnosis.ranking.harmonic import HIGHEST_MULTIPLE, better_harmonic
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS

SINE = 10.0  # Hz


@cache
def clean(excitation="sine10"):
    return measurement(challenge(15, excitation=excitation, preload=2e-3).recording)


@settings(max_examples=15, deadline=None)
@given(
    order=st.integers(2, HIGHEST_MULTIPLE),
    strength=st.floats(1.5, 20.0),
    phase=st.floats(0.0, 2.0 * np.pi),
)
def test_any_line_at_a_multiple_of_a_sine_is_found(order, strength, phase):
    measured = clean()
    angle = 2.0 * np.pi * order * SINE * measured.sample_period * np.arange(measured.force.size)
    line = strength * measured.noise.own * np.sin(angle + phase)
    base = fit_base(Composition(), [replace(measured, force=measured.force + line)], EXACT)
    found = better_harmonic(base, base, EXACT)
    assert found == pytest.approx(order * SINE, rel=1e-3)


def test_noise_holds_no_line():
    base = fit_base(Composition(), [clean()], EXACT)
    assert better_harmonic(base, base, EXACT) is None


def test_hum_of_the_mains_is_hum_at_a_multiple_of_the_sine_too():
    made = challenge(77000051, "mains_hum", rig="tolerant", preload=2.4e-3)
    assert made.answer.parameters["mains_hum"]["hum_frequency"] == 5.0 * SINE
    measured, effects = measurement(made.recording), library("mains_hum", "bouc_wen_hysteresis")
    found = diagnose(Composition(), [measured], TOLERANT, effects)
    assert (found.verdict, found.effects) == ("missing", ("mains_hum",))


def test_a_mode_that_is_tuned_to_a_multiple_of_a_steady_sine_stands_for_anything():
    made = challenge(411011, excitation="sine10ss", rig="tolerant")
    hidden = challenge(411011, "amplitude_softening", excitation="sine10ss", rig="tolerant")
    effects = library("structural_mode", "added_mass")
    none, found = (
        diagnose(Composition(), [measurement(each.recording, at_rest=False)], TOLERANT, effects)
        for each in (made, hidden)
    )
    assert (none.verdict, none.ladder.harmonic) == ("adequate", None)
    assert (found.verdict, found.effects) == ("unexplained", ("structural_mode",))
    assert found.ladder.harmonic == pytest.approx(2.0 * SINE, rel=1e-3)
    assert "a line at 20 Hz, a multiple of the drive's frequency" in verdict(found)[0]


@pytest.mark.parametrize(
    ("effect", "excitation"),
    [
        ("structural_mode", "sine10"),
        ("cubic_stiffening", "sine10"),
        ("coulomb_friction", "sine10ss"),
        ("hertz_contact", "sine10ss"),
    ],
)
def test_no_line_explains_more_than_the_effect_that_is_there(effect, excitation):
    made = challenge(420000, effect, excitation=excitation, rig="tolerant")
    measured = measurement(made.recording, at_rest=excitation != "sine10ss")
    base = fit_base(Composition(), [measured], TOLERANT)
    (final,) = fit_candidates(base, [EFFECTS[effect]], TOLERANT)
    assert base.ratio > 1.1
    assert better_harmonic(base, final, TOLERANT) is None


@pytest.mark.parametrize("excitation", ["msine60", "chirp60", "stepped30"])
def test_only_a_sine_has_multiples(excitation):
    """Even where a line is there."""
    measured = clean(excitation)
    time = measured.sample_period * np.arange(measured.force.size)
    line = 10.0 * measured.noise.own * np.sin(2.0 * np.pi * 2.0 * SINE * time)
    base = fit_base(Composition(), [replace(measured, force=measured.force + line)], EXACT)
    assert better_harmonic(base, base, EXACT) is None


def test_several_recordings_are_not_asked():
    base = fit_base(Composition(), [clean(), clean()], EXACT)
    assert better_harmonic(base, base, EXACT) is None


def test_a_model_with_hum_is_not_asked():
    hum = Composition().plus(EFFECTS["mains_hum"])
    base = fit_base(hum, [clean()], EXACT)
    assert better_harmonic(base, base, EXACT) is None
