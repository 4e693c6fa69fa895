"""How much an effect leaves to a Kelvin-Voigt fit, and that it is what was asked for."""

from __future__ import annotations

import numpy as np
import pytest

from tissue_probe.challenge import SIMULATED_EFFECTS, make_challenge
from tissue_probe.challenge.case import Case
from tissue_probe.challenge.coil import PERFECT
from tissue_probe.challenge.instrument import InstrumentErrors
from tissue_probe.challenge.kelvin_voigt import fit_residual
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.trajectory import DURATIONS, Trajectory

PHASES = tuple(np.random.default_rng(3).uniform(0.0, 6.28, 60).tolist())


@pytest.mark.parametrize("kind", DURATIONS)
@pytest.mark.parametrize(("stiffness", "damping"), [(150.0, 15.0), (3000.0, 0.5)])
def test_a_clean_recording_leaves_less_than_a_fiftieth_of_the_noise(kind, stiffness, damping):
    truth = Specimen(stiffness=stiffness, damping=damping)
    coil = Trajectory(kind, 1e-3, DURATIONS[kind], phases=PHASES)
    case = Case(truth, InstrumentErrors(encoder_step=1e-12), coil).press_in(2e-3)
    position, force = case.measure(np.zeros(case.samples))
    left = fit_residual(position, force, truth._replace(stiffness=500.0, damping=4.0))
    assert np.sqrt(np.mean(left**2)) < 1e-4


@pytest.mark.parametrize("name", SIMULATED_EFFECTS)
def test_an_effect_leaves_what_was_asked_for_as_far_as_it_can(name):
    effect = SIMULATED_EFFECTS[name]
    answer = make_challenge(5, (name,), "sine10", preload=2e-3).answer
    ratio, strength = answer.ratios[name], answer.strengths[name]
    at_an_end = np.isclose(strength, [effect.weakest, effect.strongest], rtol=1e-6).any()
    assert 1.4 <= answer.targets[name] <= 25.0
    assert not answer.absorbed
    if name == "amplitude_softening":  # too much softens so far that nothing is left to vary
        assert 1.1 < ratio < answer.targets[name]
    elif name == "adhesion":  # sets in with a jump
        assert ratio >= 0.95 * answer.targets[name]
    elif not at_an_end:
        # Samples are stuck by whole numbers of them.
        rel = 0.15 if name == "stuck_samples" else 0.05
        assert ratio == pytest.approx(answer.targets[name], rel=rel)
    assert answer.ratio == pytest.approx(ratio, rel=0.05)


def test_an_effect_that_sets_in_with_a_jump_rather_shows_too_well():
    for seed in range(4):
        answer = make_challenge(seed, ("hertz_contact",), "sine10", preload=0.0).answer
        assert answer.ratio > 1.2


def test_an_effect_leaves_what_the_caller_asks_for_in_a_specimen_that_is_the_same():
    drawn, asked = (
        make_challenge(5, ("cubic_stiffening",), "sine10", leaves=leaves).answer
        for leaves in (None, 3.0)
    )
    assert asked.ratio == pytest.approx(3.0, rel=0.05)
    assert asked.targets == {"cubic_stiffening": 3.0}
    assert asked.ratio != pytest.approx(drawn.ratio, rel=0.05)
    assert (asked.tissue, asked.rig, asked.excitation) == (
        drawn.tissue,
        drawn.rig,
        drawn.excitation,
    )


def test_an_effect_that_is_to_leave_the_noise_only_is_refused():
    with pytest.raises(ValueError, match="more than the noise"):
        make_challenge(5, leaves=1.0)


ABSORBED = (
    *("standard_linear_solid", "generalized_maxwell", "springpot"),
    *("added_mass", "force_gain", "load_cell_stiffness_error"),
)


@pytest.mark.parametrize("name", ABSORBED)
def test_a_steady_sine_without_preload_lets_kelvin_voigt_absorb(name):
    answer = make_challenge(1, (name,), "sine10ss", preload=0.0, coil=PERFECT).answer
    assert answer.absorbed == (name,)
    assert answer.strengths[name] == SIMULATED_EFFECTS[name].typical
    assert answer.ratio < 1.05


@pytest.mark.parametrize("name", ABSORBED[:3])
def test_a_preload_shows_relaxation_by_its_unrelaxed_offset(name):
    answer = make_challenge(1, (name,), "sine10ss", preload=2e-3).answer
    assert answer.absorbed == ()
    assert answer.ratio == pytest.approx(answer.targets[name], rel=0.05)
