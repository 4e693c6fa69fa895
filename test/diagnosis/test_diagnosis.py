"""From samples to a verdict, on recordings of the challenge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hidden import EXACT, TOLERANT, challenge, first_of, library, measurement
from specimen import Specimen, sine
from threadpoolctl import threadpool_info, threadpool_limits

from tissue_probe.analysis.verdict_in_words import verdict
from tissue_probe.challenge.coil import PERFECT
from tissue_probe.diagnosis import diagnosis
from tissue_probe.diagnosis.advice.separation import suggest
from tissue_probe.diagnosis.evidence.adequacy import STRAINED
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates
from tissue_probe.diagnosis.ranking.rules import find_added_effect
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.response import course, respond

#: Residual over noise below which a model of these long recordings leaves noise only.
MUCH = 1.07
NOISE = 5e-3
FEW = library("cubic_stiffening", "exponential_stiffening", "coulomb_friction")
#: What Kelvin-Voigt absorbs under a steady sine without preload, and what it does not.
ABSORBED = (
    *("standard_linear_solid", "added_mass", "force_gain", "load_cell_stiffness_error"),
    *("channel_delay", "force_lag"),
)
NOT_ABSORBED = ("cubic_stiffening", "mains_hum", "force_drift")


def diagnose(made, effects=FEW, at_rest=True, second=False, **asked):
    return diagnosis.diagnose(
        Composition(),
        [measurement(made.recording, at_rest)],
        EXACT,
        effects,
        [measurement(made.second)] if second else [],
        **asked,
    )


def test_the_right_effect_is_proved_on_a_second_recording():
    made = challenge(11, "cubic_stiffening")
    found = diagnose(made, second=True)
    assert (found.verdict, found.effects) == ("missing", ("cubic_stiffening",))
    assert found.heldout(found.ladder.final) < 1.05 * NOISE
    assert found.heldout(found.ladder.base) > 10 * NOISE
    wrong = ("coulomb_friction",)
    assert found.validated[wrong] > 10 * NOISE
    assert {(), ("cubic_stiffening",)} <= set(found.validated)
    assert found.validation_noise == pytest.approx(NOISE, rel=0.1)
    assert found.carries_over
    known = {**found.validated, ("cubic_stiffening",): 2.0 * NOISE}
    assert not replace(found, validated=known).carries_over


def stiffening(amplitude, seed, force=0.05):
    """A recording of a tissue that stiffens exponentially, pressed by twice the amplitude."""
    composition = Composition(effects=(EFFECTS["exponential_stiffening"],))
    known = {entry.name: entry.default for entry in composition.values}
    values = np.array(list({**known, "exponential_force": force}.values()))
    position = amplitude * (1.0 - np.cos(2.0 * np.pi * 5.0 * 5e-4 * np.arange(4000)))
    coil = course(composition.kernel, position, 5e-4, values)
    noise = NOISE * np.random.default_rng(seed).standard_normal(position.size)
    simulated = respond(composition.kernel, values, np.zeros(2), coil).output
    return Measurement(position, simulated + noise, 5e-4, at_rest=True)


@pytest.mark.parametrize("seed", first_of(range(3), 1))
def test_a_second_recording_that_goes_much_farther_is_judged_by_how_well_the_values_are_known(seed):
    narrow, wide, other = stiffening(1e-3, seed), stiffening(3e-3, 50), stiffening(3e-3, 51, 0.1)
    effects = library("exponential_stiffening")
    asked = (Composition(), [narrow], EXACT, effects)
    found = diagnosis.diagnose(*asked, [wide])
    final = found.ladder.final
    assert found.effects == ("exponential_stiffening",)
    assert 1.5 * NOISE < found.heldout(final) < 3.0 * found.uncertainty
    assert found.carries_over
    assert not found.reaches
    of_another = diagnosis.diagnose(*asked, [other])
    assert not of_another.carries_over
    assert (found.verdict, of_another.verdict) == ("missing", "unexplained")
    assert "explains this recording, and not the second one" in verdict(of_another)[0]
    both = diagnosis.diagnose(Composition(), [narrow, wide], EXACT, effects, [stiffening(3e-3, 52)])
    assert both.carries_over
    assert both.reaches
    assert both.heldout(both.ladder.final) < 1.05 * NOISE


@pytest.mark.parametrize("seed", first_of([2, 1, 3], 1))
@pytest.mark.parametrize("amplitude", [1e-3, 1.5e-3])
def test_a_right_law_whose_values_are_roughly_known_is_not_given_up_for_a_wrong_one(
    amplitude, seed
):
    """On the second recording it errs by as much as its values are off, and the other by less."""
    narrow, wide = (stiffening(*each, 0.02) for each in ((0.6e-3, seed), (amplitude, 50 + seed)))
    known = library("exponential_stiffening", "cubic_stiffening")
    found = diagnosis.diagnose(Composition(), [narrow], EXACT, known, [wide])
    assert (found.verdict, found.effects) == ("missing", ("exponential_stiffening",))


def test_what_the_fit_tells_of_the_measurement_joins_the_findings():
    position, _, _, force = Specimen(stiffness=0.0, damping=0.0).measure(sine())
    free = Measurement(position, force, 5e-4, at_rest=True)
    found = diagnosis.diagnose(Composition(), [free], TOLERANT, FEW)
    assert [finding.name for finding in found.findings] == ["no_contact"]


def test_linear_algebra_has_one_thread_while_the_searches_have_theirs():
    seen = []

    def starts(extent):
        seen.append({each["num_threads"] for each in threadpool_info()})
        return [{}]

    watched = {"cubic_stiffening": replace(EFFECTS["cubic_stiffening"], starts=starts)}
    with threadpool_limits(2):
        diagnose(challenge(11, "cubic_stiffening"), watched)
        assert {each["num_threads"] for each in threadpool_info()} == {2}
    assert seen
    assert set().union(*seen) == {1}


def test_without_a_second_recording_blocks_of_the_first_are_held_out():
    found = diagnose(challenge(11, "cubic_stiffening"))
    assert found.validated == {}
    assert found.carries_over
    final = found.ladder.final
    assert found.heldout(final) == final.heldout_rmse
    assert 0.95 * NOISE < final.heldout_rmse < 1.1 * NOISE


@pytest.mark.parametrize("effect", ["adc_saturation", "stuck_samples"])
def test_faults_of_the_converter_are_named_and_left_out_of_the_fit(effect):
    found = diagnose(challenge(21, effect))
    assert (found.verdict, found.effects) == ("missing", (effect,))
    assert found.spoilt == (effect,)
    (used,) = (each.used for each in found.ladder.base.measurements)
    assert 0.5 < np.mean(used) < 1.0
    assert found.ladder.final.ratio < MUCH
    assert [finding.name for finding in found.findings] == [effect]


def test_a_clean_recording_is_adequate():
    found = diagnose(challenge(21, preload=2e-3))
    assert (found.verdict, found.effects, found.indistinguishable) == ("adequate", (), ())


def test_what_a_steady_sine_cannot_show_is_listed_and_an_experiment_is_proposed():
    made = challenge(21, excitation="sine10ss", preload=0.0)
    found = diagnose(made, library(*ABSORBED, *NOT_ABSORBED), at_rest=False)
    assert found.verdict == "adequate"
    assert set(ABSORBED) <= set(found.unseen)
    assert not set(NOT_ABSORBED) & set(found.unseen)
    assert found.suggestion.excitation["amplitude"] > 0
    assert found.suggestion.duration >= 2.0
    assert set(found.suggestion.shows) <= set(found.unseen)
    assert np.isnan(found.suggestion.separation)


def test_calibrations_are_proposed_for_what_no_excitation_shows():
    """A bias hides behind the tolerance of the contact's zero under every motion."""
    made = challenge(21, excitation="sine10ss", preload=0.0, rig="tolerant")
    measured = measurement(made.recording, at_rest=False)
    found = diagnosis.diagnose(
        Composition(), [measured], TOLERANT, library(*ABSORBED, "force_bias")
    )
    assert "force_bias" in found.unseen
    assert "force_bias" not in found.suggestion.shows
    assert "force_lag" in found.suggestion.shows
    assert "free air, and tare" in found.suggestion.calibration


def test_an_experiment_is_proposed_though_the_first_of_those_alike_is_too_faint_to_tell():
    """Where it is right all others follow it; where another is right it does not."""
    measured = measurement(challenge(11, "cubic_stiffening").recording)
    base = fit_base(Composition(), [measured], EXACT)
    effects = [EFFECTS["mains_hum"], EFFECTS["cubic_stiffening"]]
    fits = {find_added_effect(fit).name: fit for fit in fit_candidates(base, effects, EXACT)}
    hum, cubic = fits["mains_hum"], fits["cubic_stiffening"]
    names = hum.composition.kernel.values
    silent = [0.0 if name in ("hum_sine", "hum_cosine") else hum.named()[name] for name in names]
    faint = replace(hum, values=np.array(silent))
    advice = suggest([faint, cubic], EXACT, EFFECTS)
    assert advice.separation > 1.1
    assert advice.excitation["amplitude"] > 0


def test_a_broadband_record_under_preload_could_have_shown_everything():
    made = challenge(22, excitation="msine60", preload=2e-3)
    effects = library("standard_linear_solid", "added_mass", "force_gain", "force_lag")
    found = diagnose(made, effects)
    assert (found.verdict, found.unseen) == ("adequate", ())
    assert found.suggestion is None


def test_a_damping_that_drives_does_not_stand_for_a_lag():
    """Fitted without bounds, less mass and a negative damping left as little."""
    made = challenge(422016, "force_lag", excitation="sine10ss")
    effects = library("force_lag", "added_mass", "structural_mode", "channel_delay")
    found = diagnose(made, effects, at_rest=False)
    assert (found.verdict, found.effects) == ("missing", ("force_lag",))
    assert found.ladder.base.named()["damping"] >= 0.0


def test_more_than_the_tips_own_mass_is_found_from_a_rig_fitted_astray():
    made = challenge(423030, "added_mass", rig="tolerant")
    effects = library("added_mass", "structural_mode", "load_cell_stiffness_error")
    found = diagnosis.diagnose(Composition(), [measurement(made.recording)], TOLERANT, effects)
    assert (found.verdict, found.effects) == ("missing", ("added_mass",))


def test_coarse_steps_are_named_and_not_the_lag_that_smooths_them():
    made = challenge(422060, "encoder_quantization")
    found = diagnose(made, library("encoder_quantization", "force_lag", "standard_linear_solid"))
    assert (found.verdict, found.effects) == ("missing", ("encoder_quantization",))


def test_an_encoders_error_is_named_though_smoothing_left_some_of_its_rounding():
    """To undo a steep error makes what is left of the rounding larger wherever two read alike."""
    made = challenge(497007, "encoder_interpolation", excitation="sine10ss")
    effects = library("encoder_interpolation", "force_lag", "mains_hum")
    found = diagnose(made, effects, at_rest=False)
    assert (found.verdict, found.effects) == ("missing", ("encoder_interpolation",))
    final = found.ladder.final
    assert final.rounding > 0.2 * NOISE
    assert final.rmse > MUCH * NOISE  # the noise and what rounding leaves
    assert final.ratio < 1.02


@pytest.mark.parametrize(("seed", "rig"), first_of([(428004, "tolerant"), (422024, "exact")], 1))
def test_dry_friction_that_sticks_is_found_as_such_among_many_frequencies(seed, rig):
    """Creep stood for sticking: at the blunt end of a search a fifth of the noise was left."""
    made = challenge(seed, "coulomb_friction", excitation="msine60", rig=rig)
    found = diagnosis.diagnose(
        Composition(),
        [measurement(made.recording)],
        TOLERANT if rig == "tolerant" else EXACT,
        library("coulomb_friction"),
    )
    assert (found.verdict, found.effects) == ("missing", ("coulomb_friction",))
    final = found.ladder.final
    assert final.composition.effects[0].moving != 1
    hidden = made.answer.parameters["coulomb_friction"]["coulomb"]
    assert final.named()["coulomb_force"] == pytest.approx(hidden, rel=0.01)


def test_a_tip_that_is_hardly_pulled_off_is_found():
    """Of the four peaks of the tension two exceed the pull-off force, by a thousandth."""
    made = challenge(480044, "adhesion", excitation="msine60")
    found = diagnose(made, library("adhesion", "contact_loss", "exponential_stiffening"))
    assert (found.verdict, found.effects) == ("missing", ("adhesion",))
    truth = made.answer.parameters["adhesion"]["pull_off"]
    assert found.ladder.final.named()["pull_off_force"] == pytest.approx(truth, rel=1e-3)


def test_an_instant_is_found_though_a_ramp_nearly_fits():
    made = challenge(483025, "stiffness_step", rig="tolerant")
    found = diagnosis.diagnose(
        Composition(),
        [measurement(made.recording)],
        TOLERANT,
        library("stiffness_step", "stiffness_ramp"),
    )
    assert (found.verdict, found.effects) == ("missing", ("stiffness_step",))


def test_relaxation_is_found_in_a_motion_that_goes_on_whatever_it_remembers():
    """Of no strength, what it remembers changes nothing, and the way up begins downhill."""
    made = challenge(480026, "springpot", excitation="sine10ss")
    found = diagnose(made, library("springpot", "standard_linear_solid"), at_rest=False)
    fits = {each.composition.names[-1]: each for each in found.ladder.ranking}
    assert fits["springpot"].ratio < fits["standard_linear_solid"].ratio
    assert found.ladder.posterior.families["relaxation"] > 0.95


def test_a_valley_of_stiffness_and_exponent_is_crossed():
    """Under a steady sine other exponents beside other tissue fit nearly as well."""
    made = challenge(1500026, "springpot", excitation="sine10ss")
    found = diagnose(made, library("springpot", "force_bias"), at_rest=False)
    assert (found.verdict, found.effects) == ("missing", ("springpot",))
    assert found.ladder.final.converged


def test_an_effect_for_which_the_rig_had_made_up_is_named():
    made = challenge(483055, "force_gain", rig="tolerant")
    measured = [measurement(made.recording)]
    found = diagnosis.diagnose(Composition(), measured, TOLERANT, library("force_gain"))
    assert found.ladder.base.strain > STRAINED > found.ladder.final.strain
    assert (found.verdict, found.effects) == ("missing", ("force_gain",))


def test_what_may_hide_comes_before_what_would_have_shown():
    made = challenge(483027, "force_bias", excitation="stepped30", rig="tolerant")
    measured = [measurement(made.recording)]
    effects = library("cubic_stiffening", "contact_loss", "force_bias")
    found = diagnosis.diagnose(Composition(), measured, TOLERANT, effects)
    assert (found.verdict, found.unseen) == ("adequate", ("force_bias",))
    assert found.ladder.ranking[0].composition.names == ("force_bias",)


def test_a_slow_rest_of_what_the_library_lacks_is_not_explained_away():
    """Of a load cell that warms up, a slow sine leaves little, but not of any colour."""
    linear = {"force_drift": EFFECTS["force_drift"].plain}
    found = diagnose(_warming_up(), library("tissue_motion", "force_bias") | linear)
    assert (found.verdict, found.ladder.family) == ("unexplained", None)
    assert found.ladder.final.ratio < MUCH


def test_a_load_cell_that_settles_drifts():
    made = _warming_up()
    relaxing = ("standard_linear_solid", "generalized_maxwell", "springpot")
    found = diagnose(made, library("tissue_motion", "force_bias", "force_drift", *relaxing))
    assert (found.verdict, found.effects) == ("missing", ("force_drift",))
    (true,) = made.answer.parameters.values()
    values = found.ladder.final.named()
    assert values["drift_time"] == pytest.approx(true["settling_time"], rel=0.1)
    moved = values["force_drift"] * values["drift_time"]
    assert moved == pytest.approx(true["settling"], rel=0.1)


def _warming_up():
    made = challenge(425013, "force_drift", excitation="chirp60")
    assert "settling" in made.answer.parameters["force_drift"]
    return made


def test_what_is_absorbed_is_not_claimed():
    made = challenge(31, "force_gain", excitation="sine10ss", preload=0.0, coil=PERFECT)
    found = diagnose(made, library(*ABSORBED), at_rest=False)
    assert found.verdict == "adequate"
    assert "force_gain" in found.unseen


def test_effects_that_cannot_be_told_apart_are_named_together_with_what_would_tell():
    # The same physics under another name: no experiment tells them apart.
    twin = replace(FEW["cubic_stiffening"], name="twin")
    found = diagnose(challenge(11, "cubic_stiffening"), {**FEW, "twin": twin})
    assert found.verdict == "ambiguous"
    assert set(found.indistinguishable) == {"cubic_stiffening", "twin"}
    assert found.suggestion.excitation == {}
    assert found.suggestion.separation == pytest.approx(1.0, abs=0.02)


def test_samples_that_are_worthless_are_refused():
    made = challenge(21).recording
    still = measurement(replace(made, position=np.zeros(made.position.size)))
    with pytest.raises(ValueError, match="position"):
        diagnosis.diagnose(Composition(), [still], EXACT, FEW)


def test_what_is_wanted_is_added_and_nothing_else():
    found = diagnose(challenge(11, "cubic_stiffening"), wanted=["coulomb_friction"])
    assert found.ladder.effects == ("coulomb_friction",)
    assert found.verdict == "unexplained"


def test_disturbed_samples_are_left_out_and_the_rest_is_fitted():
    made = challenge(14, preload=2e-3)
    force = made.recording.force.copy()
    force[200::400] += 2.0
    found = diagnose(replace(made, recording=replace(made.recording, force=force)))
    assert found.verdict == "adequate"
    assert found.spoilt == ()
    assert found.ladder.base.samples == force.size - 10
    assert [finding.name for finding in found.findings] == ["spikes"]


@pytest.mark.parametrize("off", [2e-4, -1e-3])
def test_positions_that_were_read_wrong_are_bridged_and_all_forces_fitted(off):
    made = challenge(14, preload=2e-3)
    position = made.recording.position.copy()
    position[200::400] += off
    found = diagnose(replace(made, recording=replace(made.recording, position=position)))
    assert found.verdict == "adequate"
    assert found.ladder.base.samples == position.size
    assert [finding.name for finding in found.findings] == ["position_spikes"]


def test_a_second_recording_settles_what_a_steady_sine_cannot_tell():
    made = challenge(310046, "force_bias", excitation="sine10ss", coil=PERFECT)
    effects = library("force_bias", "force_lag", "added_mass", "force_gain")
    alone = diagnose(made, effects, at_rest=False)
    assert (alone.verdict, added_names(alone)[0]) != ("missing", "force_bias")
    settled = diagnose(made, effects, at_rest=False, second=True)
    assert (settled.verdict, settled.effects) == ("missing", ("force_bias",))
    assert added_names(settled)[0] == "force_bias"
    assert settled.heldout(settled.ladder.final) < 1.05 * NOISE


def added_names(found):
    return [fit.composition.names[-1] for fit in found.ladder.ranking]


def test_each_model_of_the_ranking_is_tried_on_the_second_recording():
    made = challenge(21, rig="tolerant", excitation="chirp60", preload=2e-3)
    found = diagnosis.diagnose(
        Composition(),
        [measurement(made.recording)],
        TOLERANT,
        EFFECTS,
        [measurement(made.second)],
    )
    assert found.verdict == "adequate"
    assert all(fit.composition.names in found.validated for fit in found.ladder.ranking)


@pytest.mark.battery
def test_an_effect_of_no_strength_has_the_plain_models_error_on_what_is_held_out():
    made = challenge(21, rig="tolerant", excitation="chirp60", preload=2e-3)
    found = diagnose(made, EFFECTS)
    base = found.ladder.base
    none = [fit for fit in found.ladder.ranking if fit.cost > (1.0 - 1e-9) * base.cost]
    assert none
    for fit in none:
        assert found.heldout(fit) == pytest.approx(found.heldout(base), rel=1e-6)


@pytest.mark.parametrize(
    ("seed", "effect"),
    [
        (471040, "added_mass"),  # rings at another frequency than the tip does without
        (481005, "standard_linear_solid"),  # ten times as stiff as the rest of the tissue
        (481050, "generalized_maxwell"),
        (431001, "structural_mode"),  # so heavy that the tissue seems a quarter as stiff
        (433032, "load_cell_stiffness_error"),  # shown by the coil's jitter alone
    ],
)
def test_what_a_steady_sine_nearly_hides_is_found_though_it_is_strong(seed, effect):
    made = challenge(seed, effect, excitation="sine10ss")
    found = diagnose(made, library(effect), at_rest=False)
    assert (found.verdict, found.effects) == ("missing", (effect,))


def test_an_effect_is_not_given_up_for_another_that_comes_near_at_once():
    made = challenge(434051, "load_cell_stiffness_error", excitation="sine10ss")
    effects = library("load_cell_stiffness_error", "structural_mode", "added_mass")
    found = diagnose(made, effects, at_rest=False)
    assert (found.verdict, found.effects) == ("missing", ("load_cell_stiffness_error",))


def test_a_strong_springpot_leaves_noise_only():
    """Its ladder has enough branches, up to the fastest that a load cell can tell."""
    made = challenge(486004, "springpot", excitation="chirp60")
    found = diagnose(made, library("springpot"))
    assert (found.verdict, found.effects) == ("missing", ("springpot",))
    assert made.answer.ratio > 20.0
