"""Which forms of an effect are searched, and from where."""

from __future__ import annotations

from hidden import EXACT, TOLERANT, challenge, measurement

from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates
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
