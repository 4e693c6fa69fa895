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
from tissue_probe.diagnosis.improvement import queue
from tissue_probe.diagnosis.sharing import map_shared
from tissue_probe.physics.composition import Composition


@pytest.fixture(scope="module")
def measured():
    return [measurement(challenge(30).recording)]


def _promised(problem):
    starts = [begun.mean for begun in problem.begin(problem.nominal)]
    return promise(problem, problem.nominal, starts)


def test_a_model_evaluated_once_takes_a_response_for_each_value_and_state(measured):
    problem, effort = Problem(Composition(), measured, EXACT), Effort(measured)
    with effort.count_responses():
        _promised(problem)
    assert effort.done == problem.count + problem.states


def test_half_of_the_samples_take_half_of_the_effort(measured):
    effort = Effort(measured)
    with effort.count_responses():
        count([np.empty((measured[0].force.size // 2, 3))])
    assert effort.done == 1.5


@given(st.lists(st.integers(1, 20), min_size=2, max_size=12))
@settings(max_examples=25, deadline=None)
def test_what_a_copy_of_the_process_does_is_counted_too(measured, responses):
    samples, effort = measured[0].force.size, Effort(measured)
    with effort.count_responses():
        map_shared(lambda each: count([np.empty((samples, each))]), responses)
    assert effort.done == sum(responses)


def test_an_effort_counts_what_is_done_within_others_too(measured):
    samples, whole, part = measured[0].force.size, Effort(measured), Effort(measured)
    with whole.count_responses():
        count([np.empty((samples, 2))])
        with part.count_responses():
            map_shared(lambda each: count([np.empty((samples, each))]), (3, 4))
        count([np.empty((samples, 1))])
    assert (whole.done, part.done) == (10.0, 7.0)


def test_effort_is_counted_from_nothing_and_only_where_that_is_asked_for(measured):
    effort, response = Effort(measured), np.empty((measured[0].force.size, 1))
    count([response])
    assert effort.done == 0.0
    with effort.count_responses():
        count([response])
    count([response])
    assert effort.done == 1.0
    with effort.count_responses():
        assert effort.done == 0.0


@pytest.fixture(scope="module")
def friction():
    """A recording with friction and an error of the load cell."""
    made = challenge(30, "load_cell_stiffness_error", "coulomb_friction")
    return [measurement(made.recording)]


@pytest.mark.parametrize(
    ("effects", "most", "curtailed"),
    [
        (("load_cell_stiffness_error", "mains_hum"), 0, True),
        (("load_cell_stiffness_error", "mains_hum"), queue.BUDGET, False),
        (("load_cell_stiffness_error", "coulomb_friction"), 0, False),
    ],
)
def test_that_not_all_was_tried_is_told_where_something_is_left(
    friction, monkeypatch, effects, most, curtailed
):
    monkeypatch.setattr(queue, "BUDGET", most)
    found = diagnose(Composition(), friction, EXACT, library(*effects))
    assert ("curtailed" in [finding.name for finding in found.findings]) == curtailed
    assert (found.verdict == "unexplained") == ("mains_hum" in effects)
