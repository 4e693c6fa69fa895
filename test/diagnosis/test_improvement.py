"""The ladder: what is added, where it ends, what is dropped again."""

from __future__ import annotations

from pathlib import Path

import pytest
from hidden import EXACT, TOLERANT, challenge, first_of, library, measurement

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.evidence.conclusion import conclude_search
from tissue_probe.diagnosis.improvement.ladder import (
    climb,
    climb_by,
)
from tissue_probe.diagnosis.improvement.moves import addable
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.library import effects

#: Residual over noise below which a model of these long recordings leaves noise only.
MUCH = 1.07
FEW = library("standard_linear_solid", "cubic_stiffening", "coulomb_friction", "mains_hum")


def climbed(made, known=EXACT, effects=FEW):
    return climb(Composition(), [measurement(made.recording)], known, effects)


@pytest.mark.parametrize("instrument", [EXACT, TOLERANT], ids=["exact", "tolerant"])
def test_nothing_is_added_to_what_is_adequate(instrument):
    rig = "exact" if instrument is EXACT else "tolerant"
    ladder = climbed(challenge(14, rig=rig, preload=2e-3), instrument)
    assert ladder.verdict == "adequate"
    assert ladder.effects == ()
    assert ladder.final is ladder.base
    assert len(ladder.ranking) == len(FEW)


@pytest.mark.parametrize(
    ("effect", "seed"), [("standard_linear_solid", 3), ("cubic_stiffening", 7), ("mains_hum", 5)]
)
def test_the_one_effect_that_is_missing_is_added(effect, seed):
    ladder = climbed(challenge(seed, effect, preload=2e-3))
    assert (ladder.verdict, ladder.effects, ladder.tied) == ("missing", (effect,), (effect,))
    assert ladder.base.ratio > 1.3
    assert ladder.final.ratio < MUCH
    assert ladder.final.heldout_rmse < ladder.base.heldout_rmse


def test_a_step_whose_search_went_astray_is_searched_again_where_a_ramp_explains_the_same():
    made = challenge(448006, "stiffness_step", excitation="msine60", rig="tolerant")
    ladder = climbed(made, TOLERANT, library("stiffness_step", "stiffness_ramp"))
    assert (ladder.verdict, ladder.effects) == ("missing", ("stiffness_step",))
    (instant,) = (each for name, each in ladder.final.named().items() if name == "step_time")
    assert instant == pytest.approx(made.answer.parameters["stiffness_step"]["step_time"], abs=2e-3)


@pytest.mark.parametrize("seed", first_of([446006, 446061], 1))
def test_dry_friction_is_found_where_the_motion_goes_on(seed):
    """And not the richer law: that had made up for a start that lay far from how the coil moves."""
    made = challenge(seed, "coulomb_friction", excitation="sine10ss", rig="tolerant")
    measured = [measurement(made.recording, at_rest=False)]
    effects = library("coulomb_friction", "stribeck_friction")
    ladder = climb(Composition(), measured, TOLERANT, effects)
    assert (ladder.verdict, ladder.effects) == ("missing", ("coulomb_friction",))
    assert ladder.final.ratio < 1.0


def test_what_is_simpler_is_reached_from_where_the_richer_is_as_good_as_it():
    """Hertz's contact of exponent 1: loss of contact alone was too far behind to be begun with."""
    made = challenge(481044, "stiffness_step", "contact_loss", excitation="chirp60")
    ladder = climbed(made, effects=library("contact_loss", "hertz_contact", "stiffness_step"))
    assert (ladder.verdict, set(ladder.effects)) == ("missing", {"contact_loss", "stiffness_step"})


def test_where_all_is_explained_what_contains_an_effect_and_does_much_better_takes_its_place():
    """Lost contact beside damping that grows with depth left noise, and a faint pull untold."""
    made = challenge(26000021, "hunt_crossley", "adhesion")
    effects = library("hunt_crossley", "contact_loss", "adhesion", "hertz_contact")
    ladder = climbed(made, effects=effects)
    # So faint a pull is no more than a law of contact may be wrong by.
    assert set(ladder.effects) - {"contact_loss", "adhesion"} == {"hunt_crossley"}
    assert ladder.posterior.families["contact"] > 0.95


def test_a_pair_is_found_neither_of_which_does_best_alone():
    """Relaxation explained more than either, and what promises most beside it leads nowhere."""
    made = challenge(25000112, "tissue_motion", "bouc_wen_hysteresis", excitation="sine10ss")
    effects = library(
        *("tissue_motion", "bouc_wen_hysteresis"),
        *("springpot", "generalized_maxwell", "force_drift", "stiffness_ramp"),
    )
    measured = [measurement(made.recording, at_rest=False)]
    ladder = climb(Composition(), measured, EXACT, effects)
    assert set(ladder.effects) == {"tissue_motion", "bouc_wen_hysteresis"}
    assert ladder.final.ratio < MUCH


def test_two_effects_are_added_one_after_the_other():
    made = challenge(30, "load_cell_stiffness_error", "coulomb_friction")
    effects = library("load_cell_stiffness_error", "coulomb_friction", "mains_hum")
    ladder = climbed(made, effects=effects)
    assert set(ladder.effects) == {"load_cell_stiffness_error", "coulomb_friction"}
    errors = [fit.ratio for fit in (ladder.base, *ladder.steps)]
    assert len(errors) == 3
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < MUCH


def test_a_second_effect_is_sought_beside_what_the_first_contains():
    made = challenge(
        444024, "coulomb_friction", "added_mass", excitation="sine10ss", rig="tolerant"
    )
    effects = library("structural_mode", "added_mass", "mains_hum", "coulomb_friction")
    measured = [measurement(made.recording, at_rest=False)]
    ladder = climb(Composition(), measured, TOLERANT, effects)
    assert (ladder.verdict, set(ladder.effects)) == ("missing", {"added_mass", "coulomb_friction"})


def test_what_goes_with_either_of_two_effects_as_well_is_told():
    made = challenge(446230, "channel_delay", "force_gain", excitation="stepped30", rig="tolerant")
    effects = library("channel_delay", "force_lag", "force_gain", "added_mass", "structural_mode")
    ladder = climbed(made, TOLERANT, effects)
    assert set(ladder.effects) == {"channel_delay", "force_gain"}
    beside = [set(ladder.posterior.more(fit)) for fit in ladder.posterior.models]
    assert beside[1] == {"channel_delay", "added_mass"}


@pytest.mark.battery
def test_a_hum_at_a_multiple_of_the_sine_takes_no_place_of_another_first_effect():
    """It explains the most, being one line of what the other two make together."""
    hidden = ("coulomb_friction", "added_mass")
    made = challenge(428001, *hidden, excitation="sine10ss", rig="tolerant")
    others = ("structural_mode", "force_gain", "force_bias", "bouc_wen_hysteresis", "channel_delay")
    measured = [measurement(made.recording, at_rest=False)]
    effects = library("mains_hum", *others, "springpot", "backlash", *hidden)
    ladder = climb(Composition(), measured, TOLERANT, effects)
    assert (ladder.verdict, set(ladder.effects)) == ("missing", set(hidden))


@pytest.mark.battery
def test_what_an_effect_contains_is_searched_again_where_it_was_found_badly():
    """Beside relaxation contact is lost as it is alone; from contact no way led to relaxation."""
    hidden = ("generalized_maxwell", "contact_loss")
    made = challenge(428016, *hidden, excitation="msine60", rig="tolerant")
    ladder = climbed(made, TOLERANT, library(*hidden, "hertz_contact", "adhesion"))
    assert set(ladder.effects) == set(hidden)
    # Hertz's law of the exponent one is the same, and is told as a rival where it is found.
    assert set().union(*ladder.alternatives) <= {*hidden, "hertz_contact"}


def test_a_second_effect_that_leaves_noise_beyond_doubt_is_kept():
    """More noise is left than was estimated, of which it could not remove more."""
    hidden = ("encoder_interpolation", "standard_linear_solid")
    ladder = climbed(challenge(446227, *hidden, rig="tolerant"), TOLERANT, library(*hidden))
    assert (ladder.verdict, ladder.effects) == ("missing", hidden)
    assert ladder.final.ratio < ladder.steps[0].ratio < MUCH


def test_two_forms_of_one_law_are_not_added_to_each_other():
    """Together they would make a curve that follows a third."""
    forms = library("cubic_stiffening", "exponential_stiffening")
    ladder = climbed(challenge(7, "hertz_contact"), effects=forms)
    assert ladder.verdict == "unexplained"
    assert len(ladder.effects) == 1


def test_no_branch_relaxes_where_the_probe_was_at_rest_without_load():
    """Or a load cell that warms up would be taken for tissue that relaxes."""
    made = challenge(332011, "force_drift", excitation="chirp60", preload=0.0)
    assert "settling" in made.answer.parameters["force_drift"]
    ladder = climbed(made, effects=library("standard_linear_solid", "generalized_maxwell"))
    assert ladder.verdict == "unexplained"
    assert ladder.final.ratio > 10.0


@pytest.mark.parametrize("seed", first_of([331046, 331052, 331055, 331069], 1))
def test_a_force_that_comes_late_by_much_is_found_under_a_steady_sine(seed):
    made = challenge(seed, "channel_delay", excitation="sine10ss", preload=2e-3)
    found = diagnose(
        Composition(), [measurement(made.recording, at_rest=False)], EXACT, library("channel_delay")
    )
    (delay,) = made.answer.parameters["channel_delay"].values()
    assert found.verdict == "missing"
    assert found.ladder.final.named()["channel_delay"] == pytest.approx(delay, rel=0.2)


def test_what_no_effect_explains_is_unexplained():
    ladder = climbed(challenge(7, "hertz_contact"), effects=library("mains_hum", "force_bias"))
    assert ladder.verdict == "unexplained"
    assert ladder.final.ratio > MUCH


def test_an_effect_that_only_led_another_to_where_it_explains_all_alone_is_dropped():
    """Alone the play moves the rig to the limits of its tolerance, and stays beside the truth."""
    made = challenge(20000085, "backlash", rig="tolerant")
    found = climbed(made, TOLERANT, library("backlash", "added_mass"))
    assert found.effects == ("backlash",)
    assert found.verdict == "missing"
    assert len(found.steps) == 1
    assert found.ranking[0] is found.final
    base = fit_base(Composition(), [measurement(made.recording)], TOLERANT)
    (alone,) = fit_candidates(base, [EFFECTS["backlash"]], TOLERANT)
    assert alone.ratio > 5.0


@pytest.mark.battery
def test_where_one_of_three_is_dropped_the_others_may_give_way_again():
    """Beside a bias, which is none, lost contact was followed by a tissue that holds the tip."""
    made = challenge(18800025, "contact_loss", "bouc_wen_hysteresis", excitation="sine10ss")
    effects = library("bouc_wen_hysteresis", "adhesion", "contact_loss", "backlash", "force_bias")
    found = diagnose(Composition(), [measurement(made.recording, at_rest=False)], EXACT, effects)
    # More is left than noise: a third one may be named beside them, and the bias is not.
    assert {"contact_loss", "bouc_wen_hysteresis"} <= set(found.effects)
    assert "force_bias" not in found.effects


def test_a_second_effect_is_sought_beside_all_that_alone_lead():
    """A delay with a gain stood behind a lag, which is of its family, and was not begun with."""
    made = challenge(25000093, "channel_delay", "force_gain")
    names = ("force_lag", "channel_delay", "structural_mode", "force_gain", "stribeck_friction")
    effects = library(*names, "hunt_crossley")
    found = diagnose(Composition(), [measurement(made.recording)], EXACT, effects)
    assert set(found.effects) == {"channel_delay", "force_gain"}


def test_what_is_asked_for_is_added_whether_it_is_missing_or_not():
    clean = [measurement(challenge(14, preload=2e-3).recording)]
    ladder = climb_by(
        Composition(), clean, EXACT, list(library("mains_hum", "force_bias").values())
    )
    assert ladder.effects == ("mains_hum", "force_bias")
    assert ladder.verdict == "adequate"
    assert len(ladder.steps) == 2


def test_two_effects_of_which_one_cannot_be_told_from_another_are_told_with_it():
    """Under a steady sine a lag and a delay differ in the harmonics only."""
    made = challenge(455004, "force_lag", "hunt_crossley", excitation="sine10ss", rig="tolerant")
    effects = library("force_lag", "channel_delay", "hunt_crossley")
    recording = measurement(made.recording, at_rest=False)
    found = diagnose(Composition(), [recording], TOLERANT, effects)
    ladder = found.ladder
    assert found.verdict == ladder.verdict == "ambiguous"
    assert found.suggestion is not None
    assert found.indistinguishable == ladder.tied
    assert set(ladder.tied) == {"force_lag", "channel_delay"}
    models = [set(fit.composition.names) for fit in ladder.rivals]
    assert models == [{ladder.tied[0], "hunt_crossley"}, {ladder.tied[1], "hunt_crossley"}]
    assert ladder.final is ladder.rivals[0]
    # The second recording tells, whatever is the better on the first.
    right, wrong = sorted(ladder.rivals, key=lambda fit: "force_lag" not in fit.composition.names)
    second = {frozenset(right.composition.names): 100.0, frozenset(wrong.composition.names): 0.0}
    told = conclude_search(ladder.base, ladder.ranking, ladder.steps, ladder.tried, second)
    assert (told.verdict, told.rivals, told.tied[1:]) == ("missing", (right,), ())
    assert told.final is right
    assert set(told.effects) == {"force_lag", "hunt_crossley"}
    assert set(told.steps[0].composition.names) < set(told.effects)


@pytest.mark.battery
def test_both_of_two_effects_give_way_each_to_another_of_its_family():
    """Beside a wrong stiffening a delay was as good as the lag, and stayed for the right one."""
    made = challenge(1500056, "force_lag", "exponential_stiffening", excitation="chirp60")
    effects = library("hertz_contact", "exponential_stiffening", "force_lag", "channel_delay")
    ladder = climbed(made, effects=effects)
    assert set(ladder.effects) == {"force_lag", "exponential_stiffening"}
    assert ladder.final.ratio < MUCH


def test_an_effect_gives_way_to_what_contains_it_from_where_it_is():
    """On its own way from contact as Hunt and Crossley have it, adhesion was given up."""
    made = challenge(480229, "adhesion", "hunt_crossley", excitation="sine10ss")
    effects = library("contact_loss", "adhesion", "hunt_crossley")
    ladder = climb(Composition(), [measurement(made.recording, at_rest=False)], EXACT, effects)
    assert set(ladder.effects) == {"adhesion", "hunt_crossley"}


def test_a_search_goes_round_a_bend_beside_lost_motion():
    """Its first step gains next to nothing, and from there the next promises much."""
    made = challenge(489106, "structural_mode", "backlash")
    ladder = climbed(made, effects=library("structural_mode", "backlash", "hunt_crossley"))
    assert (ladder.verdict, set(ladder.effects)) == ("missing", {"structural_mode", "backlash"})


def test_what_rounding_might_leave_is_explained_where_an_effect_does():
    made = challenge(
        488516, "backlash", "encoder_quantization", excitation="msine60", rig="tolerant"
    )
    effects = library("encoder_quantization", "backlash", "force_bias")
    ladder = climbed(made, TOLERANT, effects)
    assert set(ladder.effects) == {"backlash", "encoder_quantization"}


def test_no_two_effects_stand_for_another_of_which_neither_explains_anything_alone():
    few = library("mains_hum", "added_mass", "tissue_motion")
    ladder = climbed(challenge(8, "coulomb_friction"), effects=few)
    assert ladder.verdict == "unexplained"
    assert ladder.effects == ("mains_hum",)


def test_an_effect_of_a_users_own_is_sought_beside_one_of_its_family(tmp_path):
    """Drag is friction, too, and no form of dry friction: it excludes nothing."""
    own = effects([Path(__file__).parents[2] / "docs" / "my_effect.py"])
    base = Composition(effects=(EFFECTS["coulomb_friction"],))
    assert "quadratic_drag" in addable(base, own)
    assert "stribeck_friction" not in addable(base, own)


@pytest.mark.battery
def test_the_parts_of_a_law_are_tried_in_other_forms():
    """Hertz's law leads, being lost contact and one stiffening: another one was hidden."""
    made = challenge(76000063, "cubic_stiffening", "contact_loss", rig="tolerant", preload=0.0)
    ladder = climbed(made, TOLERANT, EFFECTS)
    assert (ladder.verdict, set(ladder.effects)) == (
        "missing",
        {"cubic_stiffening", "contact_loss"},
    )


@pytest.mark.battery
def test_kin_takes_its_place_beside_an_effect_that_was_extended_before():
    """A lag and a delay beside Hertz's law: which of them was hidden is told by fitting both."""
    timing = ("channel_delay", "force_lag")
    contact = ("hertz_contact", "contact_loss", "hunt_crossley")
    made = challenge(
        76000076, "channel_delay", "hertz_contact", excitation="chirp60", rig="tolerant"
    )
    ladder = climbed(made, TOLERANT, library(*timing, *contact))
    tried = [set(ladder.posterior.more(fit)) for fit in ladder.tried]
    assert {"force_lag", "hertz_contact"} in tried
    assert set(ladder.effects) == {"channel_delay", "hertz_contact"}
