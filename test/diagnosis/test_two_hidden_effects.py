"""Two hidden effects are found beside others that do nearly as well."""

from __future__ import annotations

import pytest
from hidden import EXACT, TOLERANT, challenge, first_of, library, measurement

from tissue_probe.diagnosis.improvement.ladder import climb
from tissue_probe.physics.composition import Composition

#: By the cause for which they were once missed: the two with their seed, and what else is tried.
PAIRS = {
    "beside added mass adhesion takes the place of lost contact": (
        (27000062, "adhesion", "added_mass", {}),
        ("contact_loss", "hertz_contact", "structural_mode"),
    ),
    "each of five families promises more than the second effect": (
        (343001, "structural_mode", "backlash", {"rig": "tolerant"}),
        (
            *("bouc_wen_hysteresis", "channel_delay", "force_gain", "standard_linear_solid"),
            *("adhesion", "exponential_stiffening"),
        ),
    ),
    "kin of both does better alone": (
        (442022, "force_lag", "hertz_contact", {"excitation": "stepped30", "rig": "tolerant"}),
        ("channel_delay", "exponential_stiffening"),
    ),
    "without relaxation contact seems to be lost in another form": (
        (
            439007,
            "generalized_maxwell",
            "contact_loss",
            {"excitation": "chirp60", "rig": "tolerant"},
        ),
        (),
    ),
    "a way leads to the pair from one side only": (
        (453148, "adhesion", "hunt_crossley", {}),
        ("force_gain",),
    ),
    "relaxation hides that the tissue holds the tip": (
        (18800109, "springpot", "adhesion", {"rig": "tolerant"}),
        ("contact_loss",),
    ),
}


@pytest.mark.parametrize(("hidden", "others"), first_of(PAIRS.values(), 2), ids=PAIRS)
def test_two_hidden_effects_are_found_beside_others(hidden, others):
    seed, one, two, options = hidden
    made = challenge(seed, one, two, **options)
    known = TOLERANT if options.get("rig") == "tolerant" else EXACT
    measured = [measurement(made.recording)]
    ladder = climb(Composition(), measured, known, library(one, two, *others))
    assert (ladder.verdict, set(ladder.effects)) == ("missing", {one, two})
