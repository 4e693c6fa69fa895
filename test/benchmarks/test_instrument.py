"""The instrument's measure is right by itself: its world against closed forms, and its marks."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from benchmarks.instrument import resonance, rezeroed, two_rates, uneven, zero_of_position
from benchmarks.instrument.case import Truth
from benchmarks.instrument.groups import GROUPS
from benchmarks.instrument.laws import LAWS, PLAIN
from benchmarks.instrument.motion import driven, linear
from benchmarks.instrument.multisine import drawn
from benchmarks.instrument.outcome import (
    HALF_WIDTH,
    Outcome,
    law_is_right,
    mark_carries_over,
    mark_values,
    off_by,
)
from benchmarks.instrument.pressed import Tissue
from benchmarks.instrument.tables import tables
from benchmarks.instrument.widths import widths
from benchmarks.instrument.written_cases import WRITTEN, judge

TIP = {"tip_mass": 0.02, "stiffness": 4200.0, "damping": 0.8}
BRANCHES = ((300.0, 2.0), (150.0, 0.2))


def pushed(seed=0):
    random = np.random.default_rng(seed)
    return drawn(random, 5.0, 90.0, 1.6, 0.5).from_its_mean().about(0.3)


def test_a_driven_linear_tip_moves_as_its_closed_form_to_one_part_in_a_thousand_million():
    force, times = pushed(), np.arange(1200) / 600.0
    found = driven(PLAIN, TIP, force, times, (1e-4, 0.0), 1e-3)
    expected = linear(TIP, force, times, (1e-4, 0.0))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.ptp(expected))


def test_a_driven_branch_answers_as_its_transfer_function_does():
    law = next(each for each in LAWS if each.rate)
    values = {**TIP, "relaxing_stiffness": 2000.0, "relaxation_rate": 300.0}
    force, times = pushed(), np.linspace(0.0, 2.0, 801)
    found = driven(law, values, force, times, (0.3 / 4200.0, 0.0), 1e-3)
    steady = force.through(
        lambda s: 1.0 / (0.02 * s**2 + 0.8 * s + 4200.0 + 2000.0 * s / (s + 300.0))
    )
    late = times > 1.5  # the free motion has decayed by exp(-40)
    error = found[late] - steady(times)[late]
    assert np.abs(error).max() < 1e-8 * np.ptp(found)


def test_a_sum_of_sines_from_its_mean_begins_there_and_keeps_its_size():
    force = pushed()
    assert float(force(0.0)) == pytest.approx(0.3, abs=1e-12)
    assert np.std(force(np.arange(0.0, 2.0, 1e-3))) == pytest.approx(1.6, rel=1e-9)


def test_the_force_on_ramps_and_holds_is_that_of_the_integrated_branches():
    tissue = Tissue(400.0, 3.0, BRANCHES)
    corners, depths = (
        np.array([0.0, 1.0, 4.0, 5.0, 9.0]),
        np.array([0.0, 1.0, 1.0, 0.4, 0.4]) * 1e-3,
    )
    times = 0.05 + 0.1 * np.arange(90)

    def rates(time, forces, slope):
        return [k * slope - r * q for (k, r), q in zip(BRANCHES, forces, strict=True)]

    expected, forces = np.empty(times.size), np.zeros(2)
    for i in range(4):
        slope = np.diff(depths)[i] / np.diff(corners)[i]
        at = (times > corners[i]) & (times <= corners[i + 1])
        asked = np.append(times[at], corners[i + 1])
        found = solve_ivp(
            rates, (corners[i], corners[i + 1]), forces, "DOP853", asked, rtol=1e-11, atol=1e-14,
            args=(slope,),
        ).y  # fmt: skip
        expected[at], forces = found.sum(axis=0)[:-1] + 3.0 * slope, found[:, -1]
    expected += 400.0 * np.interp(times, corners, depths)
    np.testing.assert_allclose(tissue.on_path(corners, depths, times), expected, atol=1e-9)


def test_the_force_of_a_motion_that_goes_on_is_that_of_integrated_branches():
    tissue, times = Tissue(400.0, 3.0, ((300.0, 2.0),)), np.linspace(0.0, 20.0, 401)
    depth = drawn(np.random.default_rng(1), 0.1, 3.0, 1e-3, 0.1).about(4e-3)
    speed = depth.through(lambda s: s)
    branch = solve_ivp(
        lambda time, q: 300.0 * speed(time) - 2.0 * q, (0.0, 20.0), [0.0], "DOP853", times,
        rtol=1e-11, atol=1e-13,
    ).y[0]  # fmt: skip
    expected = 400.0 * depth(times) + 3.0 * speed(times) + branch
    late = times > 15.0
    np.testing.assert_allclose(tissue.in_motion(depth, times)[late], expected[late], atol=1e-9)


def test_widths_of_a_line_are_those_of_its_regression():
    abscissa, noise = np.linspace(0.0, 1.0, 50), 0.1
    known = widths(
        lambda sets: np.outer(sets["slope"], abscissa) + np.reshape(sets["level"], (-1, 1)),
        {"slope": 3.0, "level": -2.0},
        noise,
    )
    matrix = np.stack([abscissa, np.ones(50)])
    exact = noise * np.sqrt(np.diag(np.linalg.inv(matrix @ matrix.T)))
    assert [known["slope"], known["level"]] == pytest.approx(exact.tolist(), rel=1e-6)


@pytest.mark.slow
def test_a_resonant_record_keeps_its_bounds():
    case = resonance.make(4)
    first, values = case.first, case.truth.values
    period = 2.0 * np.pi * np.sqrt(values["tip_mass"] / values["stiffness"])
    samples = period / np.diff(first.time)[0]
    assert resonance.PER_PERIOD[0] <= samples <= resonance.PER_PERIOD[1]
    power = np.abs(np.fft.rfft(first.force)) ** 2
    above = np.fft.rfftfreq(first.force.size) > max(0.25, resonance.ABOVE / samples) + 1e-3
    assert power[above].sum() < 1e-9 * power.sum()
    assert case.second.noise == first.noise
    assert set(case.truth.widths) == set(values)


@pytest.mark.parametrize(
    "make", [zero_of_position.make, rezeroed.make, uneven.make, two_rates.make]
)
def test_the_same_seed_makes_the_same_record_and_another_one_another(make):
    same, again, other = (make(seed).first for seed in (5, 5, 6))
    np.testing.assert_array_equal(same.force, again.force)
    assert same.force.size != other.force.size or np.any(same.force != other.force)


@pytest.mark.parametrize("seed", range(5))
def test_the_touch_is_never_lost_where_the_zero_of_the_position_is_off(seed):
    case = zero_of_position.make(seed)
    travel = np.ptp(case.first.position)
    assert np.abs(case.first.position).max() > 0.05 * travel
    # A plain spring's force, pressed from its touch on, is that of a depth above 0.
    if not case.truth.effects:
        slow = case.first.force.mean() / case.truth.values["stiffness"]
        assert 0.0 < slow < 2.0 * travel


def answered(verdict, effects=(), values=None, error=1.0, carries_over=True):
    families = {"cubic_stiffening": "stiffening", "hertz_contact": "stiffening"}
    families |= {"force_bias": "offset", "springpot": "relaxation"}
    told = {name: {"value": v, "deviation": sd} for name, (v, sd) in (values or {}).items()}
    return {
        "verdict": verdict,
        "effects": list(effects),
        "ranking": [{"effect": name, "family": family} for name, family in families.items()],
        "ladder": [{"parameters": told}],
        "rmse": {"heldout": {"final": error}},
        "carries_over": carries_over,
        "findings": [],
    }  # fmt: skip


CUBIC = Truth({"cubic_stiffening": "stiffening"}, {"stiffness": 100.0, "cubic_stiffness": 5.0})
PLAIN_ZEROED = Truth({}, {"stiffness": 100.0}, besides=("offset",))


@pytest.mark.parametrize(
    ("verdict", "effects", "truth", "family", "name"),
    [
        ("missing", ["cubic_stiffening"], CUBIC, True, True),
        ("missing", ["hertz_contact"], CUBIC, True, False),
        ("ambiguous", ["cubic_stiffening"], CUBIC, False, False),
        ("missing", ["cubic_stiffening", "springpot"], CUBIC, False, False),
        ("missing", ["cubic_stiffening", "force_bias"], CUBIC, False, False),
        ("adequate", [], PLAIN_ZEROED, True, True),
        ("missing", ["force_bias"], PLAIN_ZEROED, True, True),
        ("missing", ["springpot"], PLAIN_ZEROED, False, False),
        ("unexplained", [], PLAIN_ZEROED, False, False),
        ("missing", ["force_bias"], replace(PLAIN_ZEROED, besides=()), False, False),
    ],
)
def test_a_law_is_right_by_family_and_by_name(verdict, effects, truth, family, name):
    answer = answered(verdict, effects)
    assert law_is_right(answer, truth) is family
    assert law_is_right(answer, truth, by_name=True) is name


def test_values_are_counted_that_lie_in_their_intervals():
    outcome = Outcome("resonance", "cubic", 1)
    within = (100.0 + 0.99 * HALF_WIDTH, 1.0)
    answer = answered("missing", values={"stiffness": within, "cubic_stiffness": (8.0, 1.0)})
    missed = mark_values(outcome, answer, CUBIC.values)
    assert (outcome.inside, outcome.intervals, list(missed)) == (1, 2, ["cubic_stiffness"])
    assert off_by(answer, CUBIC.values)["cubic_stiffness"] == pytest.approx(0.6)
    assert off_by(answered("missing"), CUBIC.values)["stiffness"] == np.inf


@pytest.mark.parametrize(
    ("verdict", "error", "carries_over", "right"),
    [
        ("missing", 1.09, True, True),
        ("missing", 1.11, True, False),
        ("unexplained", 1.0, True, False),
        ("missing", 1.0, None, False),
        ("missing", None, True, False),
    ],
)
def test_a_model_carries_over_that_leaves_the_noise(verdict, error, carries_over, right):
    outcome = Outcome("in_motion", "fast", 1)
    answer = answered(verdict, error=error, carries_over=carries_over)
    mark_carries_over(outcome, answer, 1.0)
    assert outcome.marks["carries over"] is right
    assert bool(outcome.wrong) is not right


def test_a_recording_of_a_folder_is_judged_by_its_truth():
    written = WRITTEN["rezero_gap"]
    right, wrong = Outcome("cases", "a", 0), Outcome("cases", "b", 0)
    judge(right, answered("missing", ["force_bias"], {"stiffness": (321.0, 0.1)}), written)
    judge(wrong, answered("missing", ["springpot"], {"stiffness": (186.0, 90.0)}), written)
    assert right.wrong == []
    assert wrong.wrong == ["another law", "stiffness off by 42 %"]


def test_tables_tell_shares_and_what_was_wrong():
    columns = GROUPS["two_rates"].columns
    outcomes = [
        Outcome("two_rates", "plain", 1, marks=dict.fromkeys(columns, True)),
        Outcome("two_rates", "plain", 2, marks=dict.fromkeys(columns, False), wrong=["a [law]"]),
    ]
    shares, wrong = tables(outcomes)
    assert list(shares.columns[1].cells) == ["1 of 2 (1 to 99)"]
    assert wrong.row_count == 1
