"""The rules by which fits are compared, on fits of which only the figures that count are set."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hidden import EXACT, challenge, measurement
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.diagnosis.evidence.posterior import (
    FORM_SHARE,
    SECOND,
    evidence,
    library_size,
    posterior,
)
from tissue_probe.diagnosis.ranking.candidates import fit_base
from tissue_probe.diagnosis.ranking.rules import find_added_effect, in_limit, rank_fits, significant
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
            unknowns=made.unknowns + len(effect.parameters),
        )
    made = replace(made, misfits=tuple(scale**2 * misfit for misfit in made.misfits))
    return replace(made, cost=made.cost * np.exp((bic - made.bic) / made.samples))


def names(fits):
    return [find_added_effect(each).name for each in fits]


def test_the_figures_of_the_fits_are_those_asked_for():
    made = fit("mains_hum", 1234.0, 1.7)
    assert abs(made.bic - 1234.0) < 1e-6
    assert abs(made.ratio - 1.7) < 1e-9


def test_the_colour_of_a_residual_is_one_of_noise_and_more_where_an_effect_is_missing():
    assert abs(base().colour - 1.0) < 0.1
    wrong = fit_base(
        Composition(), [measurement(challenge(7, "cubic_stiffening").recording)], EXACT
    )
    assert wrong.colour > 1.2


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


def test_the_most_probable_model_comes_first():
    fits = [fit("mains_hum", 300.0), fit("cubic_stiffening", 100.0), fit("force_bias", 200.0)]
    assert names(rank_fits(base(), fits)) == ["cubic_stiffening", "force_bias", "mains_hum"]


def test_a_fit_is_better_where_it_alone_would_be_sure_beside_the_other():
    simple = fit("cubic_stiffening", 1000.0)
    odds = 2.0 * np.log(0.95 / 0.05)
    assert significant(simple, fit("force_bias", 1000.0 - 1.01 * odds), base())
    assert not significant(simple, fit("force_bias", 1000.0 - 0.99 * odds), base())
    assert not significant(simple, simple, base())


def test_an_effect_must_make_up_for_the_many_that_might_be_missing():
    plain = base()
    needed = 2.0 * (np.log(library_size()) + np.log(0.95 / 0.05))
    assert significant(plain, fit("cubic_stiffening", plain.bic - 1.01 * needed), plain)
    assert not significant(plain, fit("cubic_stiffening", plain.bic - 0.99 * needed), plain)


def test_a_second_effect_is_less_likely_than_one_before_anything_was_measured():
    one = fit("cubic_stiffening", 1000.0)
    needed = 2.0 * (np.log(library_size()) + SECOND + np.log(0.95 / 0.05))
    assert significant(one, fit("cubic_stiffening+force_bias", 1000.0 - 1.01 * needed), base())
    assert not significant(one, fit("cubic_stiffening+force_bias", 1000.0 - 0.99 * needed), base())


@pytest.mark.parametrize(
    ("richer", "simpler"),
    [
        (effect.name, simpler)
        for effect in EFFECTS.values()
        for simpler in effect.simpler
        if len(effect.parameters) > len(EFFECTS[simpler].parameters)
    ],
)
def test_an_effect_that_contains_another_stands_back_where_it_explains_no_more(richer, simpler):
    more, less = (replace(fit(name, 0.0), cost=base().cost) for name in (richer, simpler))
    assert names(rank_fits(base(), [more, less])) == [simpler, richer]


def test_an_effect_is_the_one_that_it_contains_where_it_ended_in_that_limit():
    found, simple = fit("bouc_wen_hysteresis", 0.0), fit("coulomb_friction", 0.0)
    lacking = replace(base(), misfits=tuple(4.0 * each for each in base().misfits))
    assert not in_limit(found)
    assert len(posterior(lacking, [found, simple]).likely) == 2
    at_once = found.values.copy()
    at_once[-1] = EFFECTS["bouc_wen_hysteresis"].parameters[1].lower
    assert in_limit(replace(found, values=at_once))
    told = posterior(lacking, [replace(found, values=at_once), simple])
    assert told.likely == (simple,)
    # Hertz's law of an exponent that is one but for the error of a form is mere loss of contact.
    hertz, lost = fit("hertz_contact", 0.0), fit("contact_loss", 20.0)
    hertz.values[-1] = 1.0 + 0.5 * FORM_SHARE
    assert names(posterior(lacking, [hertz, lost]).likely) == ["contact_loss"]
    hertz.values[-1] = 1.0 + 2.0 * FORM_SHARE
    assert names(posterior(lacking, [hertz, lost]).likely) == ["hertz_contact"]
    # Where the simpler one was found badly the larger one remains.
    bad = fit("coulomb_friction", 100.0, 1.2)
    assert names(posterior(lacking, [replace(found, values=at_once), bad]).likely) == [
        "bouc_wen_hysteresis"
    ]
    # A bound where it remains what it is tells nothing.
    sharp = fit("stribeck_friction", 0.0)
    sharp.values[-1] = EFFECTS["stribeck_friction"].parameters[-1].lower
    assert not in_limit(sharp)


@given(st.lists(st.floats(-1e4, 1e4), min_size=1, max_size=4))
def test_ranking_loses_nothing(criteria):
    fits = [fit(name, bic) for name, bic in zip(NAMES, criteria, strict=False)]
    order = rank_fits(base(), fits)
    assert sorted(names(order)) == sorted(names(fits))
    worse = [evidence(order[0], base()) < evidence(each, base()) for each in fits]
    assert not any(worse)
