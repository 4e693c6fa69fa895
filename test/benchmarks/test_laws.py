"""The benchmark of newer laws hides what it says, marks what is said, and goes on where it was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console
from scipy.integrate import solve_ivp

from benchmarks.laws import kept_rows
from benchmarks.laws.cases import RIGS, STRENGTHS, Case, make_case, plan_cases
from benchmarks.laws.channel import ChannelLaw
from benchmarks.laws.kept_rows import KeptRows
from benchmarks.laws.library import BEFORE, NEW_FORM, list_newer_laws, take_library_before
from benchmarks.laws.measure import measure
from benchmarks.laws.outcome import LawOutcome, Said, ask
from benchmarks.laws.tables import tables
from tissue_probe.challenge.simulator import LIBRARY
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.trajectory import DURATIONS
from tissue_probe.physics.effects import EFFECTS

CASE = Case("law", "bilinear_spring", ("bilinear_spring",), "sine10", "exact", 15.0, 600_100)
RIGHT = Said("missing", ("bilinear_spring",), seconds=1.0)


def outcome(said, hidden=CASE.hidden, **known):
    return LawOutcome(replace(CASE, hidden=hidden), 15.0, False, said, **known)


def test_all_of_the_library_that_can_be_hidden_was_there_before_or_is_newer():
    newer = list_newer_laws()
    assert set(LIBRARY) <= {*BEFORE, *newer}
    assert set(newer) & set(BEFORE) == set(NEW_FORM)
    before = take_library_before()
    assert set(before) < set(EFFECTS)
    assert all(len(before[name].forms) < len(EFFECTS[name].forms) for name in NEW_FORM)


def test_each_law_is_hidden_at_each_strength_under_each_excitation_by_seeds_of_its_own():
    laws = list_newer_laws()
    plan = [*plan_cases(laws, RIGS, 10, 600_000)]
    hidden = [each for each in plan if each.part == "law"]
    cells = {(each.law, each.rig, each.leaves, each.excitation) for each in hidden}
    assert len(hidden) == len(cells) == len(laws) * len(RIGS) * len(STRENGTHS) * len(DURATIONS)
    assert len({each.seed for each in plan}) == len(plan)
    assert {each.rig for each in plan if each.part == "clean"} == {*RIGS}
    # Of one law and one rig alone the records are the same.
    some = [*plan_cases(laws[1:2], RIGS[1:], 10, 600_000)]
    assert {each for each in some if each.part != "idle"} <= set(plan)


@pytest.mark.parametrize("lag", [0.0, 0.05])
def test_the_force_of_a_channel_is_that_of_the_equation_of_motion(lag):
    tip, law = Specimen(stiffness=800.0, damping=6.0), ChannelLaw(0.3, 0.5, lag)
    times = np.arange(1200) / 2000.0
    channel = 12.0 + 3.0 * np.sin(2.0 * np.pi * 7.0 * times)

    def felt(time, late):
        return late if lag else np.interp(time, times, channel) / 12.0

    def slope(time, state):
        x, v, late = state
        pushed = 0.3 * (felt(time, late) + 0.5 * felt(time, late) ** 2)
        cell = -tip.load_cell_stiffness * x - tip.load_cell_damping * v
        force = cell - tip.stiffness * x - tip.damping * v - pushed
        towards = np.interp(time, times, channel) / 12.0 - late
        return v, force / tip.tip_mass, towards / lag if lag else 0.0

    begun = -0.3 * 1.5 / (tip.load_cell_stiffness + tip.stiffness)
    states = solve_ivp(
        slope, (0.0, times[-1]), (begun, 0.0, 1.0), t_eval=times, max_step=1e-3, rtol=1e-8,
        atol=1e-12,
    ).y  # fmt: skip
    expected = -tip.load_cell_stiffness * states[0] - tip.load_cell_damping * states[1]
    assert law.drive(channel, tip) == pytest.approx(expected, abs=1e-4 * np.ptp(expected))


@pytest.mark.parametrize("law", ["second_input", "bouc_wen_hysteresis"])
def test_a_law_leaves_what_is_asked_for(law):
    made = make_case(replace(CASE, law=law, hidden=(law,), leaves=5.0))
    assert made.ratio == pytest.approx(5.0, rel=0.06)
    assert (made.first.input2 is not None) == (law == "second_input")
    assert np.all(np.isfinite(made.second.force))


def test_a_strong_law_is_named_and_a_clean_record_is_asked_about_by_both_libraries():
    found = ask(CASE)
    assert found.is_alone
    assert found.second == pytest.approx(1.0, abs=0.15)
    clean = ask(replace(CASE, part="clean", law="", hidden=(), leaves=None))
    assert clean.said.verdict == clean.before.verdict == "adequate"
    assert clean.before.seconds > 0.0


@pytest.mark.parametrize(
    ("said", "alone", "among"),
    [
        (RIGHT, True, True),
        (replace(RIGHT, verdict="ambiguous", tied=("bilinear_spring", "backlash")), False, True),
        (Said("ambiguous", ("backlash",), ("backlash", "bilinear_spring")), False, True),
        # Large, and of several families.
        (
            Said(
                "ambiguous",
                ("backlash",),
                ("backlash", "bilinear_spring", "hertz_contact", "adhesion"),
            ),
            False,
            False,
        ),
        # As large, and of one.
        (
            Said(
                "ambiguous",
                ("hertz_contact",),
                ("hertz_contact", "bilinear_spring", "cubic_stiffening", "saturating_spring"),
            ),
            False,
            True,
        ),
        # A further effect that is not there is said to be sure.
        (Said("ambiguous", ("mains_hum", "backlash"), ("backlash", "bilinear_spring")),
         False, False),
        (Said("missing", ("backlash",)), False, False),
        (replace(RIGHT, verdict="unexplained"), False, False),
        (Said("adequate"), False, False),
    ],
)  # fmt: skip
def test_what_is_said_is_marked(said, alone, among):
    found = outcome(said)
    assert (found.is_alone, found.is_among) == (alone, among)


def test_a_law_beside_another_effect_is_right_with_both():
    both = ("hertz_contact", "quasi_linear_relaxation")
    assert outcome(Said("missing", both), both).is_alone
    assert not outcome(Said("missing", both[:1]), both).is_among


@pytest.mark.parametrize(
    ("by_name", "explains", "cause"),
    [
        (-30.0, True, "search"),
        (4.0, True, "not to be told"),
        (30.0, True, "another explains more"),
        (2e4, False, "search, by name too"),
        (None, None, "search, by name too"),
    ],
)
def test_the_criterion_of_the_law_by_name_says_why_it_is_not_named(by_name, explains, cause):
    said = Said("missing", ("backlash",))
    assert outcome(said, by_name=by_name, explains_by_name=explains).cause == cause


def test_a_run_that_is_interrupted_goes_on_where_it_was(tmp_path, monkeypatch):
    asked = []

    def answer(case):
        asked.append(case)
        return replace(outcome(RIGHT, second=1.0), case=case)

    monkeypatch.setattr(kept_rows, "ask", answer)
    cases = [replace(CASE, seed=seed) for seed in range(3)]
    before = next(KeptRows(tmp_path).ask_all(cases))
    (file,) = tmp_path.iterdir()
    with file.open("a") as torn:
        torn.write('{"case": {"part"')
    outcomes = [*KeptRows(tmp_path).ask_all(cases)]
    assert outcomes[0] == before
    assert asked == [each.case for each in outcomes] == cases
    assert [*KeptRows(tmp_path).ask_all(cases)] == outcomes


def test_a_run_that_is_ended_by_hand_returns_the_records_so_far(tmp_path, monkeypatch):
    answers = iter([RIGHT, RIGHT])

    def answer(case):
        if (said := next(answers, None)) is None:
            raise KeyboardInterrupt
        return replace(outcome(said), case=case)

    monkeypatch.setattr(kept_rows, "ask", answer)
    lines = []
    found = measure(tmp_path, ["bilinear_spring"], ["exact"], 1, 600_000, lines.append)
    assert len(found) == 2
    assert "first 2 records" in lines[-1]


def test_the_tables_count_shares_alarms_and_times():
    def clean(verdict, seconds):
        case = replace(CASE, part="clean", law="", hidden=())
        before = Said("adequate", seconds=2.0)
        return LawOutcome(case, 1.0, False, Said(verdict, seconds=seconds), before)

    missed = outcome(Said("missing", ("backlash",)), by_name=-40.0, explains_by_name=True)
    found = [outcome(RIGHT, second=1.01), missed, clean("adequate", 3.0), clean("missing", 4.0)]
    console = Console(record=True, width=180)
    console.print(*tables(found))
    text = console.export_text()
    assert "1 of 2, 50 %" in text
    assert "search" in text
    assert "backlash 1" in text
    assert "0 of 2, 0 %" in text
    assert "1.75" in text
