"""What a recording could not have shown, of a model as it is and beside what was added."""

from __future__ import annotations

import numpy as np
import pytest
from hidden import EXACT, TOLERANT, challenge, library, measurement

from tissue_probe.challenge.case import Case
from tissue_probe.challenge.instrument import CHALLENGE_RATE, FORCE_NOISE, InstrumentErrors
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.trajectory import Trajectory
from tissue_probe.diagnosis import diagnosis
from tissue_probe.diagnosis.advice.visibility import SEEN, unseen, visibilities
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates
from tissue_probe.physics.composition import Composition

PLAIN = Composition()
HIDDEN = library("force_gain", "force_bias", "added_mass")


def fitted(made, known, *effects, at_rest=True):
    fit = fit_base(PLAIN, [measurement(made.recording, at_rest)], known)
    for effect in library(*effects).values():
        (fit,) = fit_candidates(fit, [effect], known)
    return fit


def test_what_the_tolerances_absorb_is_unseen_and_seen_where_the_rig_is_known():
    made = challenge(22, excitation="msine60", preload=2e-3)
    assert {"force_gain", "force_bias"} <= set(
        unseen(fitted(made, TOLERANT), HIDDEN, TOLERANT, PLAIN)
    )
    assert unseen(fitted(made, EXACT), HIDDEN, EXACT, PLAIN) == ()


@pytest.mark.parametrize(
    "name", ["structural_mode", "standard_linear_solid", "springpot", "added_mass"]
)
def test_a_steady_sine_shows_nothing_that_kelvin_voigt_absorbs_whatever_it_remembers(name):
    made = challenge(21, excitation="sine10ss", preload=0.0)
    fit = fitted(made, EXACT, at_rest=False)
    assert visibilities(fit, library(name).values(), EXACT, PLAIN)[0] < SEEN
    assert unseen(fit, library(name), EXACT, PLAIN) == (name,)


def test_what_an_effect_of_the_model_absorbs_is_unseen_beside_it():
    """A drift has an offset of its own."""
    made = challenge(22, excitation="msine60", preload=2e-3)
    bias = library("force_bias", "force_drift")
    assert unseen(fitted(made, EXACT), bias, EXACT, PLAIN) == ()
    assert unseen(fitted(made, EXACT, "force_drift"), bias, EXACT, PLAIN) == ("force_bias",)


def test_another_form_of_a_law_that_the_model_has_is_not_listed():
    made = challenge(11, "cubic_stiffening", excitation="sine10")
    fit = fitted(made, EXACT, "cubic_stiffening")
    stiffening = library("cubic_stiffening", "exponential_stiffening", "hunt_crossley")
    assert visibilities(fit, [stiffening["exponential_stiffening"]], EXACT, PLAIN)[0] < SEEN
    assert unseen(fit, stiffening, EXACT, PLAIN) == ()


def test_beside_what_is_missing_the_answer_lists_what_could_not_be_seen():
    made = challenge(12, "mains_hum", excitation="msine60", rig="tolerant", preload=2e-3)
    found = diagnosis.diagnose(
        PLAIN,
        [measurement(made.recording)],
        TOLERANT,
        library("cubic_stiffening", "force_bias", "mains_hum"),
    )
    assert (found.verdict, found.effects) == ("missing", ("mains_hum",))
    assert found.unseen == ("force_bias",)
    assert found.suggestion is None


def test_an_effect_that_the_samples_speak_for_is_unseen_where_the_residual_is_noise():
    """A delay, for which the damping and the rig's tolerances make up so far that noise is left."""
    case = Case(
        Specimen(stiffness=540.0, damping=2.6),
        InstrumentErrors(delay=0.2e-3),
        Trajectory("sine10", 1e-3, 3.0),
    ).press_in(2e-3)
    noise = FORCE_NOISE * np.random.default_rng(7).standard_normal(case.samples)
    late = Measurement(*case.measure(noise), 1.0 / CHALLENGE_RATE, at_rest=True)
    found = diagnosis.diagnose(PLAIN, [late], TOLERANT, library("channel_delay", "mains_hum"))
    assert found.verdict == "adequate"
    assert found.unseen == ("channel_delay",)
