"""Which forms of an effect are searched, and from where."""

from __future__ import annotations

from hidden import EXACT, TOLERANT, challenge, library, measurement

from tissue_probe.diagnosis.evidence.adequacy import leaves_only_noise
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates
from tissue_probe.diagnosis.ranking.rules import find_added_effect, in_limit, rank_fits
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS


def test_a_form_is_searched_that_only_where_it_is_fitted_differs_from_another():
    """By a model without it the tissue never pulls: there both forms of Hertz's contact are one."""
    hidden = ("structural_mode", "hertz_contact")
    made = challenge(994788119, *hidden, excitation="chirp60", rig="tolerant")
    base = fit_base(Composition(), [measurement(made.recording)], TOLERANT)
    (plain,) = fit_candidates(base, [EFFECTS["hertz_contact"].plain], TOLERANT)
    (best,) = fit_candidates(base, [EFFECTS["hertz_contact"]], TOLERANT)
    assert best.ratio < 0.7 * plain.ratio
    assert len(best.composition.kernel.first) == 2  # touching, pushing


def test_a_form_begins_where_a_better_one_ended():
    """To where a tip sticks and slides the way led through friction that only creeps."""
    made = challenge(480002, "stribeck_friction", excitation="stepped30")
    base = fit_base(Composition(), [measurement(made.recording)], EXACT)
    (best,) = fit_candidates(base, [EFFECTS["stribeck_friction"]], EXACT)
    assert best.composition.effects[-1].moving != 1
    assert best.ratio < 1.02  # from its own starts the sticking form ended at 1.12


def test_what_contains_an_effect_is_searched_from_where_that_did_better():
    """The pull was given up where it ended at none, as mere loss of contact had come farther."""
    made = challenge(21000129, "adhesion", excitation="chirp60", rig="tolerant")
    base = fit_base(Composition(), [measurement(made.recording)], TOLERANT)
    best, _ = fit_candidates(base, library("contact_loss", "adhesion").values(), TOLERANT)
    assert find_added_effect(best).name == "adhesion"
    assert leaves_only_noise(best)


def test_what_leaves_noise_but_more_than_another_does_is_searched_near_where_it_ended():
    """The noise is known roughly: another period of the sine was taken for that of the step."""
    made = challenge(21000132, "stiffness_step", excitation="sine10ss", rig="tolerant")
    base = fit_base(Composition(), [measurement(made.recording, at_rest=False)], TOLERANT)
    (alone,) = fit_candidates(base, [EFFECTS["stiffness_step"]], TOLERANT)
    both = fit_candidates(base, library("stiffness_ramp", "stiffness_step").values(), TOLERANT)
    step = rank_fits(base, both)[0]
    assert find_added_effect(step).name == "stiffness_step"
    assert leaves_only_noise(alone)
    assert step.cost < 0.98 * alone.cost


def test_what_is_contained_is_searched_from_where_what_contains_it_ended_as_it():
    """Lost contact was given up at 2.2 times the noise; as Hertz's law of exponent one it fits."""
    hidden = ("structural_mode", "contact_loss")
    made = challenge(24000012, *hidden, excitation="sine10", rig="tolerant")
    base = fit_base(Composition(), [measurement(made.recording)], TOLERANT)
    (alone,) = fit_candidates(base, [EFFECTS["contact_loss"]], TOLERANT)
    found = fit_candidates(base, library("hertz_contact", "contact_loss").values(), TOLERANT)
    first, second = rank_fits(base, found)
    assert (find_added_effect(first).name, find_added_effect(second).name) == (
        "contact_loss",
        "hertz_contact",
    )
    assert in_limit(second)
    assert first.cost < 1.001 * second.cost < 0.5 * alone.cost


def test_a_resonance_within_the_sweep_is_found_beside_another_effect_that_is_missing():
    """At 19 Hz: between proposals of 15 and 25 Hz neither had led to it."""
    hidden = ("structural_mode", "exponential_stiffening")
    made = challenge(24000223, *hidden, excitation="stepped30", rig="tolerant")
    base = fit_base(Composition(), [measurement(made.recording)], TOLERANT)
    (mode,) = fit_candidates(base, [EFFECTS["structural_mode"]], TOLERANT)
    assert abs(mode.named()["modal_frequency"] - 19.3) < 0.3
    assert mode.ratio < 0.5 * base.ratio
