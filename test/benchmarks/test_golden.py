"""The golden records are the same every time, made right, and two results are compared."""

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from rich.console import Console
from scipy.signal import lsim

from benchmarks.golden import records, tables
from benchmarks.golden.compared import Ratio, changes, ratio
from benchmarks.golden.experiments import EXPERIMENTS, experiment
from benchmarks.golden.specimens import driven, held, points, pressed, rubbing
from benchmarks.golden.told import Told, ask, measure

TOLD = Told(True, "missing", ("a",), {"a": 0.99, "b": 0.01}, ("quieter",), 100.0, 2.0)


def test_a_branch_relaxes_after_a_ramp_as_the_exponential_does():
    course = points([0.0, 1.0, 2.0, 9.0], [0.0, 0.0, 1e-3, 1e-3], 0.05)
    times, depth, force = pressed(
        course, 800, 1e-2, lambda x, v: 100.0 * x + 3.0 * v, [(300.0, 2.0)]
    )
    held_for = times > 3.0
    # Of a ramp of 1 s; rounded corners of standard deviation s delay its mean by (r s)^2 / 2.
    ramp = 300.0 * 1e-3 * np.expm1(2.0) / 2.0 * np.exp((2.0 * 0.05) ** 2 / 2.0)
    expected = 100.0 * 1e-3 + ramp * np.exp(-2.0 * (times - 1.0))
    assert force[held_for] == pytest.approx(expected[held_for], rel=1e-3)
    assert depth[held_for] == pytest.approx(1e-3)


def test_a_driven_mass_moves_as_the_linear_equation_says():
    period, mass, damping, stiffness = 1e-3, 0.02, 0.8, 4200.0
    times = period * np.arange(1000)
    force = np.sin(2.0 * np.pi * 7.0 * times) ** 3
    found = driven(force, period, mass, lambda now: (stiffness * now[0] + damping * now[1],))
    expected = lsim(([1.0], [mass, damping, stiffness]), force, times, interp=True)[1]
    assert found == pytest.approx(expected, abs=2e-3 * np.ptp(expected))


def test_a_held_force_presses_as_far_as_it_says():
    assert held(np.ones(3000), 1e-3, 0.05, 1.0, 200.0)[-1] == pytest.approx(1.0 / 200.0)


def test_friction_holds_a_mass_up_to_its_force_and_then_slows_it():
    still = rubbing(np.full(100, 0.5), 1e-2, 0.3, 2.0, 0.6)
    moving = rubbing(np.full(300, 1.6), 1e-2, 0.3, 2.0, 0.6)
    assert np.all(still == 0.0)
    assert np.diff(moving)[-1] / 1e-2 == pytest.approx((1.6 - 0.6) / 2.0)


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_an_experiment_is_the_same_every_time(name):
    one, other = experiment(name), experiment(name)
    for first, second in ((one.first, other.first), (one.second, other.second)):
        assert (first is None) == (second is None)
        if first is not None:
            assert np.array_equal(first.force, second.force)
            assert np.array_equal(first.position, second.position)
            assert np.all(np.diff(first.time) > 0.0)
            assert np.all(np.isfinite([first.force, first.position]))


def test_records_are_of_all_sets_and_made_by_names_of_their_own():
    every = records.makers()
    # Each by the arguments of what makes it: without making any.
    assert len({(make.func, make.args) for make in every}) == len(every)
    assert {make.func for make in every} == {
        records._protocol,
        records._experiment,
        records._challenge,
    }


def test_two_runs_agree_but_for_the_time():
    asked = [partial(records._experiment, name) for name in ("half_a_sine", "stale_force")]
    one, other = measure(asked), measure(asked)
    assert list(one) == ["experiment half_a_sine", "experiment stale_force"]
    assert all(told.responses > 0.0 and told.seconds > 0.0 for told in one.values())
    assert one["experiment half_a_sine"].right
    untimed = ({name: replace(t, seconds=0.0) for name, t in each.items()} for each in (one, other))
    assert next(untimed) == next(untimed)


def test_a_record_without_a_diagnosis_is_kept_with_the_sentence():
    def make():
        made = experiment("half_a_sine")
        short = {name: column[:5] for name, column in made.first.columns().items()}
        first = replace(made.first, time=short["t"], position=short["u"], force=short["F"])
        return records.Asked("short", first, None, made.arguments, lambda answer: True)

    name, told = ask(make)
    assert (name, told.verdict, told.right) == ("short", "refused", False)
    assert told.refused


def test_changes_are_told_those_first_that_are_no_longer_right():
    before = {"same": TOLD, "better": replace(TOLD, right=False), "worse": TOLD, "gone": TOLD}
    after = {
        "same": replace(TOLD, seconds=5.0, probabilities={"a": 0.95, "b": 0.04}),
        "better": replace(TOLD, verdict="ambiguous"),
        "worse": replace(TOLD, right=False, effects=("b",), probabilities={"b": 0.9}, revisions=()),
        "new": TOLD,
    }
    worse, better = changes(before, after)
    assert (worse.name, better.name) == ("worse", "better")
    assert list(worse.kinds) == ["right -> wrong", "effects", "revisions", "probabilities"]
    assert worse.kinds["effects"] == "a -> b"
    assert worse.kinds["probabilities"] == "a 0.99 -> 0.00, b 0.01 -> 0.90"
    assert better.kinds == {"wrong -> right": "", "verdict": "missing -> ambiguous"}


def test_ratios_are_of_the_sums_and_of_the_median_record():
    before = {"a": TOLD, "b": TOLD, "c": replace(TOLD, responses=800.0), "refused": TOLD}
    after = {
        "a": replace(TOLD, responses=50.0),
        "b": replace(TOLD, responses=200.0),
        "c": replace(TOLD, responses=800.0),
        "refused": Told(False, "refused"),
    }
    assert ratio(before, after, "responses") == Ratio(1050.0 / 1000.0, 1.0)
    assert ratio({}, after, "responses") is None


def test_a_result_is_written_and_read_again_and_differs_in_nothing_from_itself(tmp_path):
    found = {"protocol x": TOLD, "experiment y": Told(False, "refused", refused="too short")}
    file = tmp_path / "result.json"
    file.write_text(json.dumps({tables.KEY: tables.kept(found)}))
    read = tables.read(file)
    assert changes(found, read) == []
    console = Console(record=True, width=150)
    console.print(*tables.tables(found), *tables.differences(read, found))
    assert "0 of 2 records" in console.export_text()
    with pytest.raises(SystemExit, match="no result of `golden`"):
        tables.read(tmp_path / "none.json")
