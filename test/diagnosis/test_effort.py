"""The effort of a search is counted, in both processes, and bounds what is tried."""

from __future__ import annotations

import numpy as np
import pytest
from hidden import EXACT, challenge, library, measurement
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.fitting.effort import Effort, count
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.search import promise
from tissue_probe.diagnosis.improvement import further as further_effects
from tissue_probe.diagnosis.improvement import paths
from tissue_probe.diagnosis.improvement.exchange import _needed
from tissue_probe.diagnosis.improvement.further import COMPARED, SOUGHT, Further, asked
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates
from tissue_probe.diagnosis.ranking.rules import SIMPLER, added, explained
from tissue_probe.diagnosis.sharing import mapped
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS


@pytest.fixture(scope="module")
def measured():
    return [measurement(challenge(30).recording)]


def _promised(problem):
    starts = [begun.mean for begun in problem.begin(problem.nominal)]
    return promise(problem, problem.nominal, starts)


def test_a_model_evaluated_once_takes_a_response_for_each_value_and_state(measured):
    problem, effort = Problem(Composition(), measured, EXACT), Effort(measured)
    with effort.counted():
        _promised(problem)
    assert effort.done == problem.count + problem.states


def test_half_of_the_samples_take_half_of_the_effort(measured):
    effort = Effort(measured)
    with effort.counted():
        count([np.empty((measured[0].force.size // 2, 3))])
    assert effort.done == 1.5


@given(st.lists(st.integers(1, 20), min_size=2, max_size=12))
@settings(max_examples=25, deadline=None)
def test_what_a_copy_of_the_process_does_is_counted_too(measured, responses):
    samples, effort = measured[0].force.size, Effort(measured)
    with effort.counted():
        mapped(lambda each: count([np.empty((samples, each))]), responses)
    assert effort.done == sum(responses)


def test_effort_is_counted_from_nothing_and_only_where_that_is_asked_for(measured):
    effort, response = Effort(measured), np.empty((measured[0].force.size, 1))
    count([response])
    assert effort.done == 0.0
    with effort.counted():
        count([response])
    count([response])
    assert effort.done == 1.0
    with effort.counted():
        assert effort.done == 0.0


def _after(responses, measured):
    """Return the effort after so many responses."""
    effort = Effort(measured)
    with effort.counted():
        count([np.broadcast_to(0.0, (measured[0].force.size, responses))])
    return effort


@pytest.fixture(scope="module")
def friction():
    """A recording with friction, what is fitted to it, and what alone explains some of it."""
    made = challenge(30, "load_cell_stiffness_error", "coulomb_friction")
    measured = [measurement(made.recording)]
    base = fit_base(Composition(), measured, EXACT)
    names = ("coulomb_friction", "mains_hum", "load_cell_stiffness_error")
    return measured, base, [fit_candidates(base, [EFFECTS[name]], EXACT)[0] for name in names]


def test_once_so_much_was_done_beside_one_first_effect_none_is_sought_beside_another(friction):
    measured, base, (first, second, _) = friction
    found = {}
    for responses in (SOUGHT, SOUGHT + 1):
        further = Further(base, EXACT, library("force_bias"), EFFECTS, _after(responses, measured))
        longer = further.of([(first,), (second,)])
        assert not explained(longer[0][-1])
        found[responses] = {added(path[0]).name for path in longer}
    assert found == {
        SOUGHT: {"coulomb_friction", "mains_hum"},
        SOUGHT + 1: {"coulomb_friction"},
    }


def test_where_all_is_explained_more_is_done_to_tell_it_from_others(friction):
    measured, base, (first, _, cell) = friction
    (both,) = fit_candidates(first, [added(cell)], EXACT)
    assert explained(both)
    for responses, spent in ((SOUGHT, (False, False)), (SOUGHT + 1, (True, False))):
        further = Further(base, EXACT, EFFECTS, EFFECTS, _after(responses, measured))
        assert (further.is_spent(first), further.is_spent(both)) == spent
    further = Further(base, EXACT, EFFECTS, EFFECTS, _after(COMPARED + 1, measured))
    assert further.is_spent(both)


def test_what_takes_an_effects_place_late_must_leave_a_good_part_less(friction):
    measured, base, (first, second, cell) = friction
    (wrong,) = fit_candidates(first, [added(second)], EXACT)
    (both,) = fit_candidates(first, [added(cell)], EXACT)
    assert explained(both)
    assert not explained(wrong)
    for responses, needed in ((SOUGHT, wrong.cost + SIMPLER), (SOUGHT + 1, asked(wrong))):
        further = Further(base, EXACT, EFFECTS, EFFECTS, _after(responses, measured))
        assert _needed(wrong, further) == needed
    further = Further(base, EXACT, EFFECTS, EFFECTS, _after(COMPARED + 1, measured))
    assert _needed(both, further) == both.cost + SIMPLER


def test_where_pairs_that_promise_most_took_the_effort_no_other_is_sought(friction, monkeypatch):
    measured, base, (first, second, _) = friction

    def searched_long(path, further):
        count([np.broadcast_to(0.0, (measured[0].force.size, SOUGHT + 1))])
        return path

    monkeypatch.setattr(paths, "anew", searched_long)
    monkeypatch.setattr(Further, "of", lambda *_: pytest.fail("another was sought"))
    effort = Effort(measured)
    further = Further(base, EXACT, library("mains_hum", "force_bias"), EFFECTS, effort)
    with effort.counted():
        found = paths.longest(further, [(first,)], [first, second], [first])
        assert further.is_spent()
    assert not explained(found[-1])


@pytest.mark.parametrize(
    ("effects", "most", "curtailed"),
    [
        (("load_cell_stiffness_error", "mains_hum"), 0, True),
        (("load_cell_stiffness_error", "mains_hum"), SOUGHT, False),
        (("load_cell_stiffness_error", "coulomb_friction"), 0, False),
    ],
)
def test_that_not_all_was_tried_is_told_where_something_is_left(
    friction, monkeypatch, effects, most, curtailed
):
    monkeypatch.setattr(further_effects, "SOUGHT", most)
    found = diagnose(Composition(), friction[0], EXACT, library(*effects))
    assert ("curtailed" in [finding.name for finding in found.findings]) == curtailed
    assert (found.verdict == "unexplained") == ("mains_hum" in effects)
