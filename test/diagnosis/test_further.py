"""Which paths are extended by one effect more."""

from __future__ import annotations

from dataclasses import replace

from hidden import EXACT, TOLERANT, challenge, library, measurement

from tissue_probe.diagnosis.candidates import fit_base, fit_candidates
from tissue_probe.diagnosis.further import Further
from tissue_probe.diagnosis.ranking import explained
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS


def _extended(*names):
    """Return the longer paths of friction, and of hum, by the effects of a library."""
    made = challenge(30, "load_cell_stiffness_error", "coulomb_friction")
    base = fit_base(Composition(), [measurement(made.recording)], EXACT)
    paths = [
        (fit_candidates(base, [EFFECTS[name]], EXACT)[0],)
        for name in ("coulomb_friction", "mains_hum")
    ]
    return Further(base, EXACT, library(*names)).of(paths)


def test_beside_a_clear_pair_no_other_first_effect_is_extended():
    longer = _extended("load_cell_stiffness_error", "force_bias")
    assert explained(longer[0][-1])
    assert {path[0].composition.names for path in longer} == {("coulomb_friction",)}


def test_where_no_pair_is_clear_others_are_extended_too():
    longer = _extended("force_bias")
    assert not explained(longer[0][-1])
    firsts = {path[0].composition.names for path in longer}
    assert firsts == {("coulomb_friction",), ("mains_hum",)}


def test_a_first_effect_is_tried_in_another_form_that_does_nearly_as_well_alone():
    """Without relaxation, contact seems to be lost at the surface, and not by a pull."""
    hidden = ("generalized_maxwell", "contact_loss")
    made = challenge(439007, *hidden, excitation="chirp60", rig="tolerant")
    base = fit_base(Composition(), [measurement(made.recording)], TOLERANT)
    further = Further(base, TOLERANT, library(*hidden))
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
    made = challenge(453000, "adhesion", "hunt_crossley", rig="tolerant")
    base = fit_base(Composition(), [measurement(made.recording)], TOLERANT)
    names = ("adhesion", "hunt_crossley", "force_gain")
    adhesion, hunt, gain = (fit_candidates(base, [EFFECTS[n]], TOLERANT)[0] for n in names)
    assert fit_candidates(hunt, [EFFECTS["adhesion"]], TOLERANT)[0].ratio > 5.0
    further = Further(base, TOLERANT, EFFECTS)
    (first, both), *_ = further.towards(hunt, [gain, hunt, adhesion])
    assert first is adhesion
    assert both.composition.names == ("adhesion", "hunt_crossley")
    assert explained(both)
    assert not further.is_new(hunt, EFFECTS["adhesion"])
