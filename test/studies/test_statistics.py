"""Statistics of a study: intervals that hold, and values known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binomtest

import tissue_probe as tp
from tissue_probe.studies.agreement import agreement_of
from tissue_probe.studies.result import StudyResult
from tissue_probe.studies.shares import shares_missing
from tissue_probe.studies.spread import spread_of


def drawn(seed, specimens=8, repeats=3, between=8.0, within=4.0, sd=2.0, gap=20.0):
    """A study of two groups: values, the errors that are stated, specimens, groups, truths."""
    rng = np.random.default_rng(seed)
    of = np.repeat(np.arange(specimens), repeats)
    group = of % 2
    stated = sd * rng.uniform(0.5, 1.5, of.size)
    truth = (
        100.0
        + gap * group
        + between * rng.standard_normal(specimens)[of]
        + within * rng.standard_normal(of.size)
    )
    values = truth + stated * rng.standard_normal(of.size)
    return values, stated, of.astype(str), np.array(["a", "b"])[group], truth


def test_spreads_of_a_large_balanced_study_are_those_of_the_analysis_of_variance():
    y, _, of, _, _ = drawn(3, specimens=150, gap=0.0, sd=0.0)
    found = spread_of(y, np.zeros(y.size), of)
    table = y.reshape(150, 3)
    within = table.var(axis=1, ddof=1).mean()
    between = table.mean(axis=1).var(ddof=1) - within / 3.0
    assert found.within.value == pytest.approx(np.sqrt(within), rel=0.02)
    assert found.between.value == pytest.approx(np.sqrt(between), rel=0.03)
    assert found.reliability.value == pytest.approx(between / (between + within), abs=0.02)
    assert found.means[""].value == pytest.approx(y.mean(), rel=1e-3)


@pytest.mark.parametrize(
    "seeds", [range(12), pytest.param(range(100, 300), marks=pytest.mark.battery)], ids=len
)
@pytest.mark.timeout(600)
def test_intervals_hold_the_truth_in_95_of_100_studies(seeds):
    held = {"between": 0, "within": 0, "mean": 0, "contrast": 0}
    for seed in seeds:
        y, sd, of, group, _ = drawn(seed)
        found = spread_of(y, sd, of, group)
        told = {
            "between": (found.between, 8.0),
            "within": (found.within, 4.0),
            "mean": (found.means["a"], 100.0),
            "contrast": (found.contrasts["a", "b"], 20.0),
        }
        for name, (interval, truth) in told.items():
            held[name] += interval.low <= truth <= interval.high
    for name, count in held.items():
        assert binomtest(count, len(seeds), 0.95).pvalue > 1e-3, (name, count)


def test_a_short_record_borrows_from_its_specimen_and_is_nearer_the_truth():
    alone, borrowed = [], []
    for seed in range(6):
        y, sd, of, group, truth = drawn(seed, within=1.0, sd=6.0)
        found = spread_of(y, sd, of, group)
        alone.append(y - truth)
        borrowed.append(found.borrowed - truth)
        assert np.all(found.borrowed_sd < sd)
    assert np.std(borrowed) < 0.7 * np.std(alone)


def test_limits_of_agreement_and_their_intervals_hold():
    inside = 0
    for seed in range(400):
        rng = np.random.default_rng(seed)
        first = rng.normal(300.0, 50.0, 10)
        found = agreement_of(first, first + rng.normal(5.0, 10.0, 10))
        inside += found.upper.low <= 5.0 + 1.96 * 10.0 <= found.upper.high
    assert binomtest(inside, 400, 0.95).pvalue > 1e-3


def test_the_share_that_misses_an_effect_has_the_interval_of_wilson():
    rows = [{"verdict": "missing", "missing": "hertz_contact, force_lag"}] * 5
    rows += [{"verdict": "adequate", "missing": ""}] * 5
    found = shares_missing(rows)
    assert found["force_lag"].value == 0.5
    assert found["force_lag"].low == pytest.approx(0.2366, abs=1e-4)
    assert found["force_lag"].high == pytest.approx(0.7634, abs=1e-4)


def result(**changes):
    y, sd, of, group, _ = drawn(1)
    rows = [
        {
            "path": str(number),
            "status": "done",
            "stiffness": value,
            "stiffness_sd": error,
            "specimen": specimen,
            "group": kind,
            "instrument": "xy"[number % 2],
            **changes,
        }
        for number, (value, error, specimen, kind) in enumerate(zip(y, sd, of, group, strict=True))
    ]
    return StudyResult((*rows, {"path": "bad", "status": "refused", "sentence": "no"}), 0)


def test_a_study_tells_its_spread_and_its_agreement_by_factors():
    found = result()
    assert found.spread(by="group").contrasts["a", "b"].value == pytest.approx(20.0, abs=15.0)
    assert found.agreement(of="instrument").pairs == 8
    assert "reliability (ICC)" in found.spread().text


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda r: r.spread("hardness"), "no recording has a hardness; there are path"),
        (lambda r: r.spread(specimen="group"), "2 specimens tell no spread"),
        (lambda r: r.spread(specimen="path"), "each specimen was measured once"),
        (lambda r: r.agreement(of="specimen"), "two are compared"),
        (lambda r: r.missing(), "run the study with task: diagnose"),
    ],
)
def test_a_question_that_the_rows_do_not_answer_is_refused_in_a_sentence(ask, said):
    with pytest.raises(tp.TissueProbeError, match=said):
        ask(result())
