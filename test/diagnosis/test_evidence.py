"""How sure it is what is missing, on fits of which only the figures that count are set."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hidden import EXACT, challenge, first_of, measurement
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import block_diag

from tissue_probe.diagnosis.evidence.adequacy import (
    EVEN,
    NOT_THERE,
    ROUGHLY,
    ROUNDING,
    STRAINED,
    adequacy,
    doubtful,
    is_quiet,
    leaves_only_noise,
)
from tissue_probe.diagnosis.evidence.conclusion import conclude_search
from tissue_probe.diagnosis.evidence.posterior import (
    SECOND,
    SURE_PROBABILITY,
    library_size,
    posterior,
)
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidates import fit_base
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import RIGID_PROBE


@cache
def base():
    """Return a fit of real data, for the others to differ from."""
    made = fit_base(Composition(), [measurement(challenge(7, preload=2e-3).recording)], EXACT)
    return replace(made, colour=1.0, unevenness=0.0, strain=0.0)


def fit(effects, misfit, ratio=1.0):
    """Return a fit with effects more, of a residual and a misfit less than that of the base."""
    made = base()
    for effect in (EFFECTS[name] for name in effects.split("+") if name):
        made = replace(
            made,
            composition=made.composition.plus(effect),
            entries=(*made.entries, *effect.parameters),
            values=np.append(made.values, [each.default for each in effect.parameters]),
            covariance=block_diag(
                made.covariance, *((1e-3 * each.default) ** 2 for each in effect.parameters)
            ),
            unknowns=made.unknowns + len(effect.parameters),
        )
    scale = ratio / made.ratio
    made = replace(made, misfits=tuple(scale**2 * each for each in made.misfits))
    return replace(made, cost=made.cost * np.exp(-misfit / made.samples))


WRONG = 1.5


def unexplained(misfit=0.0):
    return fit("", misfit, WRONG)


def test_equally_probable_families_stand_in_the_order_of_the_effects():
    """The first that is sure is claimed: the order of a set would be another in each process."""
    names = ["mains_hum", "force_lag", "coulomb_friction", "cubic_stiffening", "springpot"]
    told = posterior(unexplained(), [fit("+".join(names), 900.0, WRONG)])
    assert list(told.families) == [EFFECTS[name].family for name in names]


def test_adequacy_is_the_largest_test_over_its_limit():
    made = fit("mains_hum", 0.0)
    assert adequacy(made) == pytest.approx(NOT_THERE)
    assert adequacy(replace(made, unevenness=0.9 * EVEN)) == pytest.approx(0.9)
    assert adequacy(replace(made, strain=1.3 * STRAINED)) == pytest.approx(1.3)
    assert not leaves_only_noise(fit("mains_hum", 0.0, 1.1))
    assert leaves_only_noise(fit("mains_hum", 0.0, 1.04))
    quiet = fit("mains_hum", 0.0, 0.69)
    assert is_quiet(quiet)
    assert not leaves_only_noise(quiet)


def test_an_encoders_rounding_may_have_any_colour_but_not_any_size():
    dark = replace(fit("mains_hum", 0.0), colour=1.5)
    assert not leaves_only_noise(dark)
    rounded = 1.1 * ROUNDING * dark.noise
    assert leaves_only_noise(replace(dark, rounding=rounded))
    assert not leaves_only_noise(replace(dark, rounding=0.5 * rounded))
    assert not leaves_only_noise(replace(fit("mains_hum", 0.0, 1.2 * ROUGHLY), rounding=rounded))


def test_a_colour_that_fine_steps_do_not_give_is_doubtful():
    made = fit("encoder_interpolation", 0.0, 1.04)
    fine = replace(made, rounding=0.5 * made.noise)
    assert not doubtful(fine)
    assert doubtful(replace(fine, colour=1.5))
    # The errors of coarse steps follow the motion, and have its colour.
    coarse = fit("encoder_quantization", 0.0, 1.04)
    assert not doubtful(replace(coarse, rounding=0.5 * made.noise, colour=1.5))


@pytest.mark.parametrize(("samples", "seeds"), first_of([(100, 150), (400, 100), (2000, 40)], 1))
def test_noise_alone_is_explained_however_few_samples_there_are(samples, seeds):
    """One record in a hundred may exceed a limit: of so many, more than four hardly ever do."""
    known = Instrument(RIGID_PROBE, RIGID_PROBE.known | {"tip_mass": (0.0, 0.0)})
    time, wrong = np.arange(samples) * 0.01, 0
    for seed in range(seeds):
        random = np.random.default_rng([samples, seed])
        u = 1e-3 * (1.0 + np.sin(2.0 * np.pi * random.uniform(2.0, 6.0) * time))
        v = np.gradient(u, 0.01, edge_order=2)
        force = 500.0 * u + 3.0 * v + 5e-3 * random.standard_normal(samples)
        made = fit_base(Composition("rigid_probe"), [Measurement(u, force, 0.01)], known)
        wrong += not leaves_only_noise(made)
    assert wrong <= 4


def test_the_more_probable_is_what_leaves_less_or_has_less_to_learn():
    bias, mode = fit("force_bias", 100.0), fit("structural_mode", 110.0)
    told = posterior(unexplained(), [bias, mode])
    assert told.models[0] is bias
    more = mode.unknowns - bias.unknowns
    odds = told.probabilities[1] / told.probabilities[0]
    assert odds == pytest.approx(np.exp(5.0) * base().samples ** (-0.5 * more))
    assert told.effect("force_bias") > told.effect("structural_mode")


def test_a_line_at_a_multiple_of_the_drive_is_less_likely_than_any_other_effect():
    hum, mode = fit("mains_hum", 105.0), fit("structural_mode", 100.0)
    assert hum.unknowns == mode.unknowns
    assert hum.named()["hum_frequency"] == 50.0  # the drive's is 10 Hz
    assert posterior(unexplained(), [hum, mode]).models[0] is mode


def test_a_second_effect_is_less_likely_than_a_first_before_anything_is_measured():
    one, two = fit("force_bias", 100.0), fit("force_bias+force_lag", 100.0)
    # Neither leaves noise only, so that both count.
    one, two = (replace(each, unevenness=2.0 * EVEN) for each in (one, two))
    told = posterior(unexplained(), [one, two])
    probability = dict(zip(map(told.more, told.models), told.probabilities, strict=True))
    odds = probability["force_bias", "force_lag"] / probability["force_bias",]
    learnt = 0.5 * (two.unknowns - one.unknowns) * np.log(base().samples)
    assert np.log(odds) == pytest.approx(-np.log(library_size()) - SECOND - learnt)


def test_models_that_are_the_same_function_of_the_record_are_equally_probable():
    """However many values each has to learn: the record tells nothing between them."""
    lag, branch = fit("force_lag", 5000.0), fit("standard_linear_solid", 5000.0)
    assert posterior(unexplained(), [lag, branch]).probabilities[0] > 0.95
    doubt = branch.covariance.copy()
    place = branch.names.index("damping")  # none is as likely: as many values as of the lag
    doubt[place, place] = branch.values[place] ** 2
    branch = replace(branch, covariance=doubt)
    more = fit("generalized_maxwell", 5001.0)  # contains the branch
    told = posterior(unexplained(), [lag, branch, more])
    assert set(told.models[:2]) == {lag, branch}
    assert told.probabilities[0] == told.probabilities[1] > 0.49
    surer = posterior(unexplained(), [fit("force_lag", 5010.0), branch])
    assert surer.effect("force_lag") > 0.95
    both = fit("force_lag+coulomb_friction", 5000.0)
    assert posterior(unexplained(), [branch, both]).probabilities[0] > 0.99


def test_a_form_is_forgiven_for_what_it_removed_and_not_for_what_stands_beside_it():
    far = unexplained(-20_000.0)
    beside = fit("standard_linear_solid", -50.0, WRONG)
    soft = fit("standard_linear_solid+hertz_contact", 0.0)
    sharp = fit("standard_linear_solid+cubic_stiffening", 20.0)
    alone = [fit("hertz_contact", 0.0), fit("cubic_stiffening", 20.0)]
    assert len(posterior(far, alone).likely) == 2
    assert len(posterior(far, [beside, soft, sharp]).likely) == 1


def test_nothing_is_added_to_a_model_that_leaves_noise_only():
    good, better = fit("force_bias", 500.0), fit("force_bias+force_lag", 5000.0)
    told = posterior(unexplained(), [good, better])
    assert told.models[0] is good
    assert told.effect("force_lag") == 0.0
    alone = fit("", 0.0)
    assert posterior(alone, [good]).models == (alone,)


def test_forms_of_a_family_are_told_apart_no_better_than_a_laws_form_is_right():
    far = unexplained(
        -20_000.0
    )  # the effect is so strong that its form leaves much more than noise
    soft, sharp = fit("hertz_contact", 0.0), fit("cubic_stiffening", 20.0)
    other = fit("force_lag", 20.0)
    told = posterior(far, [soft, sharp])
    assert len(told.likely) == 2
    assert told.families["stiffening"] == pytest.approx(1.0)
    assert len(posterior(far, [soft, other]).likely) == 1
    assert len(posterior(unexplained(-100.0), [soft, sharp]).likely) == 1


def test_a_form_is_told_by_what_it_has_to_learn_whatever_it_leaves():
    """A relaxation of two branches that leaves as much as one branch is that one."""
    one, two = fit("standard_linear_solid", 0.0), fit("generalized_maxwell", 0.0)
    told = posterior(unexplained(-20_000.0), [one, two])
    assert told.likely == (one,)


def test_a_simple_form_that_leaves_more_than_noise_is_not_above_one_that_leaves_noise_only():
    simple, enough = fit("springpot", 1000.0, 1.08), fit("generalized_maxwell", 2780.0)
    told = posterior(unexplained(-1_000_000.0), [simple, enough])
    assert told.effect("springpot") <= told.effect("generalized_maxwell")
    ladder = conclude_search(unexplained(-1_000_000.0), [simple, enough], [enough])
    assert ladder.final is enough


def test_a_family_is_not_claimed_where_most_of_what_was_left_still_is():
    """More effects are more probable, and no form alone explains much of a slight residual."""
    slight = replace(fit("", 0.0, 1.05), unevenness=3.0 * EVEN)
    alone = replace(fit("stribeck_friction", 200.0, 1.03), unevenness=3.0 * EVEN)
    two = [
        replace(fit(f"stribeck_friction+{other}", misfit, 1.02), unevenness=3.0 * EVEN)
        for other, misfit in (("mains_hum", 400.0), ("force_drift", 390.0))
    ]
    assert conclude_search(slight, [alone], [alone], two).verdict == "unexplained"


def test_probabilities_sum_to_one_and_the_set_is_the_smallest_that_is_sure():
    fits = [fit(name, 100.0 + 2.0 * place) for place, name in enumerate(EFFECTS)]
    told = posterior(unexplained(), fits)
    assert sum(told.probabilities) == pytest.approx(1.0)
    assert list(told.probabilities) == sorted(told.probabilities, reverse=True)
    held = sum(told.probabilities[: len(told.likely)])
    assert held >= SURE_PROBABILITY > held - told.probabilities[len(told.likely) - 1]


@given(st.floats(-80.0, 80.0))
def test_a_second_recording_counts_as_much_as_the_first(misfit):
    lag, delay = fit("force_lag", 100.0), fit("channel_delay", 100.0 + misfit)
    likely = {frozenset(): 0.0, frozenset({"force_lag"}): 0.5 * misfit}
    likely[frozenset({"channel_delay"})] = 0.0
    told = posterior(unexplained(), [lag, delay], likely)
    equal = posterior(unexplained(), [lag, fit("channel_delay", 100.0)])
    odds = [
        each.effect("force_lag") / (each.effect("force_lag") + each.effect("channel_delay"))
        for each in (told, equal)
    ]
    assert odds[0] == pytest.approx(odds[1], abs=0.02)


def test_a_verdict_is_sure_where_one_model_is_and_leaves_noise_only():
    lag, delay = fit("force_lag", 500.0), fit("channel_delay", 499.0)
    sure = conclude_search(unexplained(), [lag], [])
    assert (sure.verdict, sure.effects, sure.family) == ("missing", ("force_lag",), None)
    torn = conclude_search(unexplained(), [lag, delay], [])
    assert torn.verdict == "ambiguous"
    assert set(torn.alternatives) == {("force_lag",), ("channel_delay",)}
    assert torn.final is torn.rivals[0]
    assert torn.family == "timing"
    assert conclude_search(fit("", 0.0), [lag, delay], []).verdict == "adequate"


def test_where_every_model_is_wrong_the_search_says_how_far_it_came():
    far, farther = (fit(names, 900.0, WRONG) for names in ("force_lag", "force_lag+mains_hum"))
    ladder = conclude_search(unexplained(), [far], [far], [farther])
    assert (ladder.verdict, ladder.final) == ("unexplained", far)
    assert ladder.alternatives == ()


def test_a_family_is_claimed_though_its_best_form_leaves_a_little_more_than_noise():
    soft, sharp = (
        fit("cubic_stiffening", 0.0, 1.15),
        fit("exponential_stiffening", 1.0, 1.15),
    )
    ladder = conclude_search(unexplained(-20_000.0), [soft, sharp], [soft])
    assert (ladder.verdict, ladder.family) == ("ambiguous", "stiffening")
    worse = fit("cubic_stiffening", 0.0, 1.3)
    ladder = conclude_search(unexplained(-20_000.0), [worse], [worse])
    assert (ladder.verdict, ladder.family) == ("unexplained", None)


def test_the_most_probable_effect_comes_first_in_the_ranking():
    alone, kept = fit("mains_hum", 300.0, WRONG), fit("force_lag", 200.0, WRONG)
    both = fit("force_lag+force_bias", 5000.0)
    ladder = conclude_search(unexplained(), [alone, kept], [alone], [both])
    assert ladder.effects == ("force_lag", "force_bias")
    assert [each.composition.names[-1] for each in ladder.ranking] == ["force_lag", "mains_hum"]
    assert ladder.steps == (kept, both)
