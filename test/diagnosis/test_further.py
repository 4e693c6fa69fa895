"""Which paths are extended by one effect more."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hidden import EXACT, TOLERANT, challenge, library, measurement

from tissue_probe.diagnosis.improvement.exchange import anew
from tissue_probe.diagnosis.improvement.further import FOLLOWED, Further, addable
from tissue_probe.diagnosis.improvement.paths import longest
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates
from tissue_probe.diagnosis.ranking.rules import added, explained
from tissue_probe.diagnosis.ranking.screen import screened
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.library import effects


def _extended(*names):
    """Return the longer paths of friction, and of hum, by the effects of a library."""
    made = challenge(30, "load_cell_stiffness_error", "coulomb_friction")
    base = fit_base(Composition(), [measurement(made.recording)], EXACT)
    paths = [
        (fit_candidates(base, [EFFECTS[name]], EXACT)[0],)
        for name in ("coulomb_friction", "mains_hum")
    ]
    return Further(base, EXACT, library(*names), EFFECTS).of(paths)


def test_beside_a_clear_pair_no_other_first_effect_is_extended():
    longer = _extended("load_cell_stiffness_error", "force_bias")
    assert explained(longer[0][-1])
    assert {path[0].composition.names for path in longer} == {("coulomb_friction",)}


def test_where_no_pair_is_clear_others_are_extended_too():
    longer = _extended("force_bias")
    assert not explained(longer[0][-1])
    firsts = {path[0].composition.names for path in longer}
    assert firsts == {("coulomb_friction",), ("mains_hum",)}


@pytest.mark.parametrize(
    ("second", "explains"), [("load_cell_stiffness_error", True), ("force_bias", False)]
)
def test_the_last_of_a_pair_is_taken_as_the_first_only_where_the_pair_does_not_explain_all(
    second, explains
):
    made = challenge(30, "load_cell_stiffness_error", "coulomb_friction")
    base = fit_base(Composition(), [measurement(made.recording)], EXACT)
    names = ("coulomb_friction", second)
    friction, last = (fit_candidates(base, [EFFECTS[name]], EXACT)[0] for name in names)
    further = Further(base, EXACT, library(*names), EFFECTS)
    best = longest(further, [(friction,)], [friction, last], [friction])
    assert explained(best[-1]) == explains
    extended_before = further.of([(last,)]) == []
    assert extended_before != explains


def test_all_families_are_tried_beside_play_alone_and_the_usual_beside_play_and_another():
    made = challenge(480107, "backlash", "added_mass", excitation="sine10ss")
    base = fit_base(Composition(), [measurement(made.recording, at_rest=False)], EXACT)
    (play,) = fit_candidates(base, [EFFECTS["backlash"]], EXACT)
    few = library(
        *("added_mass", "force_bias", "force_gain", "force_lag", "cubic_stiffening"),
        *("standard_linear_solid", "coulomb_friction", "mains_hum"),
    )
    further = Further(base, EXACT, few, EFFECTS)
    families = {effect.family for effect in few.values()}
    beside_play = {added(path[-1]).family for path in further.of([(play,)])}
    assert beside_play == families
    (both,) = fit_candidates(play, [EFFECTS["force_bias"]], EXACT)
    beside_both = {added(path[-1]).family for path in further.of([(play, both)])}
    assert len(beside_both) == FOLLOWED < len(families - {"offset"})


def test_beside_what_alone_leads_nowhere_only_what_does_is_tried():
    made = challenge(30, "load_cell_stiffness_error", "coulomb_friction")
    base = fit_base(Composition(), [measurement(made.recording)], EXACT)
    hum, coulomb = (
        fit_candidates(base, [EFFECTS[name]], EXACT)[0]
        for name in ("mains_hum", "coulomb_friction")
    )
    few = library("coulomb_friction", "stribeck_friction", "force_bias", "added_mass")
    further = Further(base, EXACT, few, ["coulomb_friction"])
    # Stribeck's friction contains Coulomb's, and may follow what that leads to.
    beside_hum = {path[-1].composition.names[-1] for path in further.of([(hum,)])}
    assert beside_hum == {"coulomb_friction", "stribeck_friction"}
    beside_friction = {path[-1].composition.names[-1] for path in further.of([(coulomb,)])}
    assert beside_friction == {"force_bias", "added_mass"}
    assert further.of([(hum,), (coulomb,)]) == [], "the same was sought again"


def test_a_first_effect_is_tried_in_another_form_that_does_nearly_as_well_alone():
    """Without relaxation, contact seems to be lost at the surface, and not by a pull."""
    hidden = ("generalized_maxwell", "contact_loss")
    made = challenge(439007, *hidden, excitation="chirp60", rig="tolerant")
    base = fit_base(Composition(), [measurement(made.recording)], TOLERANT)
    further = Further(base, TOLERANT, library(*hidden), EFFECTS)
    path = (fit_candidates(base, [EFFECTS["contact_loss"]], TOLERANT)[0],)
    (longer,) = further.of([path])
    assert longer[-1].ratio > 4.0
    (other,) = further.reformed([path])
    assert path[-1].cost < other[-1].cost
    assert explained(further.of([other])[0][-1])


def test_what_will_not_come_near_a_known_rival_is_given_up_unless_it_is_simpler():
    made = challenge(30, "load_cell_stiffness_error", "coulomb_friction")
    base = fit_base(Composition(), [measurement(made.recording)], EXACT)
    (rival,) = fit_candidates(base, [EFFECTS["stribeck_friction"]], EXACT)
    better = replace(rival, cost=0.1 * rival.cost)
    converged = {
        name: [
            fit_candidates(base, [EFFECTS[name]], EXACT, known=known)[0].converged
            for known in ((), (better,))
        ]
        for name in ("cubic_stiffening", "coulomb_friction")
    }
    assert converged == {"cubic_stiffening": [True, False], "coulomb_friction": [True, True]}


def test_a_pair_is_found_from_the_one_side_that_leads_to_it():
    made = challenge(453148, "adhesion", "hunt_crossley")
    base = fit_base(Composition(), [measurement(made.recording)], EXACT)
    names = ("adhesion", "hunt_crossley", "force_gain")
    adhesion, hunt, gain = (fit_candidates(base, [EFFECTS[n]], EXACT)[0] for n in names)
    assert fit_candidates(hunt, [EFFECTS["adhesion"]], EXACT)[0].ratio > 5.0
    further = Further(base, EXACT, EFFECTS, EFFECTS)
    (first, both), *_ = further.towards(hunt, [gain, hunt, adhesion], np.inf)
    assert first is adhesion
    assert both.composition.names == ("adhesion", "hunt_crossley")
    assert explained(both)
    assert not further.is_new(hunt, EFFECTS["adhesion"])


def test_a_search_that_has_settled_is_not_made_again_from_the_same_fit():
    made = challenge(30, "load_cell_stiffness_error", "coulomb_friction")
    names = ("load_cell_stiffness_error", "coulomb_friction")
    base = fit_base(Composition(), [measurement(made.recording)], EXACT)
    cell, coulomb = (fit_candidates(base, [EFFECTS[name]], EXACT)[0] for name in names)
    further, friction = Further(base, EXACT, library(*names), EFFECTS), EFFECTS["coulomb_friction"]
    assert not further.has_settled(cell, friction)
    assert len(further.towards(coulomb, [cell], np.inf)) == 1
    assert len(further.of([(cell,)])) == 1
    assert further.has_settled(cell, friction)
    assert not further.has_settled(replace(cell, cost=1.01 * cell.cost), friction)
    assert further.towards(coulomb, [cell], np.inf) == []


def test_a_pair_of_which_coarse_steps_explain_the_rest_comes_before_what_smooths_the_force():
    """A lag and a mode leave less by the criterion, and do not explain all."""
    hidden = ("cubic_stiffening", "encoder_quantization")
    made = challenge(333015, *hidden, excitation="sine10ss")
    base = fit_base(Composition(), [measurement(made.recording, at_rest=False)], EXACT)
    names = (*hidden, "force_lag", "structural_mode")
    firsts = [(fit_candidates(base, [EFFECTS[n]], EXACT)[0],) for n in ("force_lag", hidden[0])]
    best, *others = Further(base, EXACT, library(*names), EFFECTS).of(firsts)
    assert set(best[-1].composition.names) == set(hidden)
    assert explained(best[-1])
    assert min(path[-1].bic for path in others) < best[-1].bic


def test_lost_motion_beside_another_effect_is_tried_in_every_form():
    """What it promises does not tell whether it is in the drive or in the coupling."""
    made = challenge(480107, "backlash", "added_mass", excitation="sine10ss")
    base = fit_base(Composition(), [measurement(made.recording, at_rest=False)], EXACT)
    (mass,) = fit_candidates(base, [EFFECTS["added_mass"]], EXACT)
    (((promising, _),),) = screened([(mass, [EFFECTS["backlash"]])], Composition(), EXACT)
    (astray,) = fit_candidates(mass, [promising], EXACT)
    assert astray.ratio > 3.0
    ((_, both),) = Further(base, EXACT, library("backlash"), EFFECTS).of([(mass,)])
    assert explained(both)


def test_beside_relaxing_tissue_every_form_of_lost_contact_is_tried():
    """What receded from the tip is lost sooner: the form that promised more leads astray."""
    made = challenge(6000039, "standard_linear_solid", "hertz_contact", excitation="stepped30")
    base = fit_base(Composition(), [measurement(made.recording)], EXACT)
    (maxwell,) = fit_candidates(base, [EFFECTS["generalized_maxwell"]], EXACT)
    forms = EFFECTS["hertz_contact"].every_form
    alone = [fit for form in forms for fit in fit_candidates(maxwell, [form], EXACT)]
    astray = max(alone, key=lambda fit: fit.ratio)
    assert astray.ratio > 2.0
    further = Further(base, EXACT, library("hertz_contact"), EFFECTS)
    ((first, both),) = further.losing_contact([maxwell], astray.cost)
    assert first is maxwell
    assert explained(both)


def test_contact_is_lost_beside_relaxing_tissue_though_alone_it_is_not():
    hidden = ("generalized_maxwell", "adhesion")
    made = challenge(6000050, *hidden, excitation="stepped30")
    base = fit_base(Composition(), [measurement(made.recording)], EXACT)
    maxwell, adhesion = (fit_candidates(base, [EFFECTS[name]], EXACT)[0] for name in hidden)
    assert adhesion.ratio > base.ratio
    further = Further(base, EXACT, EFFECTS, EFFECTS)
    found = further.losing_contact([maxwell], maxwell.cost)
    assert {path[-1].composition.names[0] for path in found} == {"generalized_maxwell"}
    path = anew(found[0], further)
    assert path[-1].composition.names == hidden
    assert explained(path[-1])


def test_forms_of_one_law_are_not_sought_beside_each_other_and_drag_of_ones_own_is():
    """Drag of a user's own is friction, too, and no form of dry friction: it excludes nothing."""
    own = effects([Path(__file__).parents[2] / "docs" / "my_effect.py"])
    beside = addable(Composition(effects=(EFFECTS["coulomb_friction"],)), own)
    assert "quadratic_drag" in beside
    assert not {"coulomb_friction", "stribeck_friction", "bouc_wen_hysteresis"} & set(beside)


def test_effects_that_exclude_each_other_say_so_alike():
    for name, effect in EFFECTS.items():
        for other in effect.excludes:
            assert name in EFFECTS[other].excludes
            assert effect.family == EFFECTS[other].family
