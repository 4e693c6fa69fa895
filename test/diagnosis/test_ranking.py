"""The rules by which fits are compared, on fits of which only the figures that count are set."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from hidden import EXACT, challenge, measurement
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.diagnosis.evidence.adequacy import ROUGHLY, STRAINED, explained
from tissue_probe.diagnosis.ranking.candidates import fit_base
from tissue_probe.diagnosis.ranking.rules import (
    LEAST_GAIN,
    LEAST_SHARE,
    SIMPLER,
    TIE,
    added,
    only_rounding,
    ranked,
    significant,
)
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS

#: Residual over noise of a model that does not explain all.
MUCH = 1.1
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
    lag = fit("force_lag", 100.0, 2.0 * MUCH)
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


def test_every_effect_that_contains_another_stands_back():
    for effect in EFFECTS.values():
        for simpler in effect.simpler:
            order = ranked([fit(effect.name, 100.0 - 0.5 * SIMPLER), fit(simpler, 100.0)])
            assert names(order) == [simpler, effect.name]


def test_what_alone_explains_all_need_only_be_told_from_what_does_not():
    better = fit("mains_hum", 1000.0)
    plain = fit("force_bias", 1000.0 + 1.1 * TIE, 1.1 * MUCH)
    assert explained(better)
    assert significant(plain, better)
    assert not significant(replace(plain, misfits=fit("force_bias", 0.0, 1.02).misfits), better)
    assert not significant(fit("force_bias", 1000.0 + 0.9 * TIE, 1.1 * MUCH), better)


@given(st.lists(st.floats(-1e4, 1e4), min_size=1, max_size=4))
def test_ranking_loses_nothing(criteria):
    fits = [fit(name, bic) for name, bic in zip(NAMES, criteria, strict=False)]
    order = ranked(fits)
    assert sorted(names(order)) == sorted(names(fits))
    # Only an effect that the best contains may stand before it.
    best = min(fits, key=lambda each: each.bic)
    assert order[0] is best or added(order[0]).name in added(best).simpler
