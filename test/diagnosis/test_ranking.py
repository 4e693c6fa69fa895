"""The rules by which fits are compared, on fits of which only the figures that count are set."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hidden import EXACT, challenge, measurement
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.diagnosis.ranking.candidates import fit_base
from tissue_probe.diagnosis.ranking.rules import (
    BEYOND_DOUBT,
    EVEN,
    EXPLAINED,
    LEAST_GAIN,
    LEAST_SHARE,
    ROUGHLY,
    ROUNDING,
    SIMPLER,
    STRAINED,
    STRONG,
    TIE,
    WHITE,
    added,
    alike,
    beyond_doubt,
    differing,
    doubtful,
    explained,
    only_rounding,
    ranked,
    significant,
    ties,
    whitest,
)
from tissue_probe.diagnosis.residuals.whiteness import colour
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS

NAMES = ("standard_linear_solid", "generalized_maxwell", "cubic_stiffening", "mains_hum")


@cache
def base():
    """Return a fit of real data, for the others to differ from."""
    return fit_base(Composition(), [measurement(challenge(7, preload=2e-3).recording)], EXACT)


def fit(effects, bic, ratio=1.0):
    """Return a fit with an effect more, or several, of a given criterion and residual."""
    made = base()
    scale = ratio / made.ratio
    for effect in (EFFECTS[name] for name in effects.split("+")):
        made = replace(
            made,
            composition=made.composition.plus(effect),
            entries=(*made.entries, *effect.parameters),
            values=np.append(made.values, [each.default for each in effect.parameters]),
        )
    made = replace(made, misfits=tuple(scale**2 * misfit for misfit in made.misfits))
    return replace(made, cost=made.cost * np.exp((bic - made.bic) / made.samples))


def names(fits):
    return [added(each).name for each in fits]


def test_two_fits_of_one_model_are_ranked():
    simple = fit("standard_linear_solid", 100.0)
    better, worse = (fit("generalized_maxwell", bic) for bic in (90.0, 95.0))
    assert ranked([worse, simple, better]) == [simple, better, worse]


def test_the_figures_of_the_fits_are_those_asked_for():
    made = fit("mains_hum", 1234.0, 1.7)
    assert abs(made.bic - 1234.0) < 1e-6
    assert abs(made.ratio - 1.7) < 1e-9


def test_better_is_what_gains_enough_and_leaves_less():
    plain, less = fit("mains_hum", 1000.0, 2.0), 2.0 * (1.0 - 2 * LEAST_SHARE)
    assert significant(plain, fit("mains_hum", 1000.0 - 1.1 * LEAST_GAIN, less))
    assert not significant(plain, fit("mains_hum", 1000.0 - 0.9 * LEAST_GAIN, less))
    same = 2.0 * (1.0 - 0.5 * LEAST_SHARE)
    assert not significant(plain, fit("mains_hum", 0.0, same))  # whatever the criterion says
    assert not significant(plain, plain)
    unlikely = replace(plain, strain=1.1 * STRAINED)
    assert significant(unlikely, fit("mains_hum", 0.0, same))  # nor was the rig
    assert not significant(unlikely, replace(fit("mains_hum", 0.0, same), strain=STRAINED))


def test_beyond_doubt_is_what_stays_far_from_every_limit():
    made = replace(fit("mains_hum", 1000.0), colour=1.0, unevenness=0.0, strain=0.0)
    assert beyond_doubt(made)
    far = 1.0 + 1.1 * BEYOND_DOUBT * (np.array([EXPLAINED, WHITE]) - 1.0)
    doubtful = [
        replace(made, colour=far[1]),
        replace(made, unevenness=1.1 * BEYOND_DOUBT * EVEN),
        replace(made, strain=1.1 * BEYOND_DOUBT * STRAINED),
        replace(fit("mains_hum", 1000.0, far[0]), colour=1.0, unevenness=0.0, strain=0.0),
    ]
    assert all(map(explained, doubtful))
    assert not any(map(beyond_doubt, doubtful))


def test_alike_are_models_as_good_that_differ_in_one_effect_and_do_not_contain_it():
    final = fit("force_lag+force_bias", 1000.0)
    delayed = fit("channel_delay+force_bias", 1000.0 + 0.9 * TIE)
    others = [
        final,
        delayed,
        fit("channel_delay+mains_hum", 1000.0),  # another in both
        fit("channel_delay", 1000.0),  # has one effect less
        fit("added_mass+force_bias", 1000.0 + 1.1 * TIE),  # not as good
        fit("force_lag+force_drift", 1000.0),  # a drift contains a bias
    ]
    assert "force_bias" in EFFECTS["force_drift"].simpler
    assert alike(final, others) == [final, delayed]
    assert differing([final, delayed]) == ("force_lag", "channel_delay")
    assert differing([final]) == ()


@pytest.mark.parametrize("samples", [2000, 4000, 40_000])
def test_white_noise_hardly_ever_passes_for_coloured(samples):
    random = np.random.default_rng(samples)
    colours = [colour([random.standard_normal(samples)]) for _ in range(1000)]
    assert np.mean(np.array(colours) > whitest(samples)) <= 0.002
    assert WHITE <= whitest(samples) < 1.25


def test_explained_is_what_leaves_no_more_than_noise_and_that_white():
    made = fit("mains_hum", 1000.0, 1.0)
    assert explained(made)
    assert not explained(fit("mains_hum", 1000.0, 1.01 * EXPLAINED))
    dark = 1.01 * whitest(made.samples)
    assert not explained(replace(made, colour=dark))
    rounded = 1.1 * ROUNDING * made.noise
    assert explained(replace(made, colour=dark, rounding=rounded))
    assert not explained(replace(made, colour=dark, rounding=0.5 * rounded))
    assert not explained(replace(fit("mains_hum", 1000.0, 1.2 * ROUGHLY), rounding=rounded))
    assert not explained(replace(made, unevenness=1.01 * EVEN))
    assert not explained(replace(made, strain=1.01 * STRAINED))


def test_the_colour_of_a_residual_is_one_of_noise_and_more_where_an_effect_is_missing():
    assert abs(base().colour - 1.0) < 0.1
    wrong = fit_base(
        Composition(), [measurement(challenge(7, "cubic_stiffening").recording)], EXACT
    )
    assert wrong.colour > 1.2


def test_the_best_criterion_comes_first():
    fits = [fit("mains_hum", 300.0), fit("cubic_stiffening", 100.0), fit("force_bias", 200.0)]
    assert names(ranked(fits)) == ["cubic_stiffening", "force_bias", "mains_hum"]


def test_coarse_steps_that_explain_all_come_before_a_better_criterion_that_does_not():
    steps = replace(fit("encoder_quantization", 200.0), rounding=5e-3)
    lag = fit("force_lag", 100.0, 2.0 * EXPLAINED)
    assert names(ranked([lag, steps])) == ["encoder_quantization", "force_lag"]
    assert names(ranked([replace(steps, rounding=0.0), fit("force_lag", 100.0)]))[0] == "force_lag"
    still = replace(fit("encoder_quantization", 200.0, 2.0 * ROUGHLY), rounding=1e-6)
    assert names(ranked([lag, still]))[0] == "force_lag"


def test_a_simpler_effect_stands_before_one_that_contains_it_unless_that_gains_much():
    simple = fit("standard_linear_solid", 100.0)
    little = fit("generalized_maxwell", 100.0 - 0.9 * SIMPLER)
    less = 1.0 - 1.1 * LEAST_SHARE
    much = fit("generalized_maxwell", 100.0 - 1.1 * SIMPLER, less)
    same = fit("generalized_maxwell", 100.0 - 1.1 * SIMPLER, 1.0 - 0.9 * LEAST_SHARE)
    assert names(ranked([little, simple]))[0] == "standard_linear_solid"
    assert names(ranked([much, simple]))[0] == "generalized_maxwell"
    assert names(ranked([same, simple]))[0] == "standard_linear_solid"


def test_an_effect_at_the_bound_where_it_becomes_a_simpler_one_stands_back_whatever_it_gains():
    simple = fit("coulomb_friction", 100.0)
    larger = fit("bouc_wen_hysteresis", 100.0 - 10.0 * SIMPLER, 0.9)
    assert names(ranked([larger, simple]))[0] == "bouc_wen_hysteresis"
    at_once = larger.values.copy()
    at_once[-1] = EFFECTS["bouc_wen_hysteresis"].parameters[1].lower
    order = ranked([replace(larger, values=at_once), simple])
    assert names(order)[0] == "coulomb_friction"
    # A bound where it remains what it is tells nothing.
    sharp = fit("stribeck_friction", 100.0 - 10.0 * SIMPLER, 0.9)
    sharp.values[-1] = EFFECTS["stribeck_friction"].parameters[-1].lower
    assert names(ranked([sharp, simple]))[0] == "stribeck_friction"


def test_what_follows_an_encoders_rounding_gains_nothing_by_it():
    def rounded(name, ratio, cost):
        made = fit(name, 0.0, ratio * np.sqrt(1.25))
        return replace(made, rounding=0.5 * made.noise, cost=cost * made.samples)

    better = rounded("structural_mode", 0.95, 1.25)
    simple, more = rounded("added_mass", 0.99, 1.4), rounded("added_mass", 1.05, 1.4)
    assert only_rounding(simple)
    assert names(ranked([better, simple])) == ["added_mass", "structural_mode"]
    assert explained(more)
    assert not only_rounding(more)
    assert names(ranked([better, more])) == ["structural_mode", "added_mass"]


@given(st.floats(0.1, 10.0), st.floats(0.3, 3.0), st.floats(0.001, 0.1))
def test_the_criterion_rises_with_what_is_left_however_much_is_rounding(share, left, more):
    made = fit("force_drift", 0.0)
    size = made.samples

    def bic(times):
        cost = times * size * (1.0 + share**2)
        return replace(made, rounding=share * made.noise, cost=cost).bic

    rise = bic(left + more) - bic(left)
    assert rise > 0.0
    # Below the rounding it counts as white noise, of which this much more is as unlikely.
    white = size * more / (1.0 + np.log1p(share**2))
    if left + more < 1.0:
        assert 0.5 * white < rise < 4.0 * white * (1.0 + np.log1p(share**2))


def test_a_colour_that_fine_steps_do_not_give_is_doubtful():
    made = fit("encoder_interpolation", 0.0, 1.05)
    fine = replace(made, rounding=0.5 * made.noise)
    slow = replace(fine, colour=1.01 * whitest(made.samples))
    assert not doubtful(fine)
    assert doubtful(slow)
    assert explained(slow)
    # The errors of coarse steps follow the motion, and have its colour.
    coarse = fit("encoder_quantization", 0.0, 1.05)
    assert not doubtful(replace(coarse, rounding=0.5 * made.noise, colour=slow.colour))
    much = fit("encoder_quantization", 0.0, 1.05 * np.sqrt(1.25))
    assert doubtful(replace(much, rounding=0.5 * made.noise))


def test_every_effect_that_contains_another_stands_back():
    for effect in EFFECTS.values():
        for simpler in effect.simpler:
            order = ranked([fit(effect.name, 100.0 - 0.5 * SIMPLER), fit(simpler, 100.0)])
            assert names(order) == [simpler, effect.name]


def test_what_is_as_good_is_not_told_apart():
    fits = ranked([
        fit("cubic_stiffening", 100.0),
        fit("mains_hum", 100.0 + 0.9 * TIE),
        fit("force_bias", 100.0 + 1.1 * TIE),
    ])  # fmt: skip
    assert names(ties(fits)) == ["cubic_stiffening", "mains_hum"]


def test_what_alone_explains_all_need_only_be_told_from_what_does_not():
    better = fit("mains_hum", 1000.0)
    plain = fit("force_bias", 1000.0 + 1.1 * TIE, 1.1 * EXPLAINED)
    assert explained(better)
    assert significant(plain, better)
    assert not significant(replace(plain, misfits=fit("force_bias", 0.0, 1.02).misfits), better)
    assert not significant(fit("force_bias", 1000.0 + 0.9 * TIE, 1.1 * EXPLAINED), better)


def test_what_is_to_be_learnt_of_a_start_does_not_tell_fits_apart():
    drift, relaxation = fit("force_bias", 100.0), fit("standard_linear_solid", 100.0 + 1.5 * TIE)
    assert alike(drift, [relaxation]) == [drift]
    learnt = replace(relaxation, start_penalty=0.6 * TIE)
    learnt = replace(
        learnt, cost=learnt.cost * np.exp((relaxation.bic - learnt.bic) / learnt.samples)
    )
    assert alike(drift, [learnt]) == [drift, learnt]
    assert alike(learnt, [drift]) == [learnt, drift]


def test_where_several_are_not_told_apart_neither_are_their_kin_that_leave_as_little():
    bias, relaxation = fit("force_bias", 100.0), fit("standard_linear_solid", 101.0)
    other = replace(fit("springpot", 101.0), unknowns=relaxation.unknowns + 4)
    assert other.bic > relaxation.bic + 2.0 * TIE
    assert ties([bias, relaxation, other]) == [bias, relaxation, other]
    assert ties([relaxation, other]) == [relaxation]
    worse = replace(other, cost=relaxation.cost + 1.1 * TIE)
    assert ties([bias, relaxation, worse]) == [bias, relaxation]


def test_an_effect_is_no_rival_of_one_that_it_contains():
    order = ranked([fit("standard_linear_solid", 100.0), fit("generalized_maxwell", 99.0)])
    assert names(ties(order)) == ["standard_linear_solid"]


@pytest.mark.parametrize(
    ("gain", "told"),
    [(0.9 * STRONG, False), (1.1 * STRONG, True), (0.9 * SIMPLER, True), (1.1 * SIMPLER, False)],
)
def test_what_contains_another_is_told_beside_it_where_there_is_strong_evidence(gain, told):
    """Of a large gain that is no share of the residual, nothing is believed."""
    order = ranked([fit("contact_loss", 100.0), fit("adhesion", 100.0 - gain)])
    assert names(ties(order)) == ["contact_loss", "adhesion"][: 1 + told]


def test_what_follows_an_encoders_rounding_is_no_rival_of_what_it_contains():
    simpler = replace(fit("contact_loss", 100.0, 0.99), rounding=1.1 * base().noise)
    better = fit("adhesion", simpler.bic - 2.0 * STRONG, 0.9)
    assert only_rounding(simpler)
    assert alike(simpler, [better]) == [simpler]


@given(st.lists(st.floats(-1e4, 1e4), min_size=1, max_size=4))
def test_ranking_loses_nothing_and_ties_begin_with_the_first(criteria):
    fits = [fit(name, bic) for name, bic in zip(NAMES, criteria, strict=False)]
    order = ranked(fits)
    assert sorted(names(order)) == sorted(names(fits))
    assert ties(order)[0] is order[0]
    # Only an effect that the best contains may stand before it.
    best = min(fits, key=lambda each: each.bic)
    assert order[0] is best or added(order[0]).name in added(best).simpler
