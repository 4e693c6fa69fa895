"""Machine code is given arrays only of the sizes that it takes them to have."""

import numpy as np
import pytest
from measured import block_of

from benchmarks.estimators_simulator import Experiment
from tissue_probe.estimation import ESTIMATORS, EstimatorSettings
from tissue_probe.estimation.run import Run

SETTINGS = EstimatorSettings()
BLOCK = block_of(Experiment(duration=0.05))
COUNT = len(BLOCK)


@pytest.fixture(params=["robust_ekf", "rls"])
def run(request):
    return Run(ESTIMATORS[request.param].kernel(SETTINGS), SETTINGS, BLOCK.sample_period)


def test_nothing_is_done_before_there_are_samples(run):
    assert run.filter(0, 10) == 0


def test_only_samples_that_there_are_are_filtered(run):
    estimates = [np.full((11, COUNT), -1.0) for _ in range(2)]
    for each, (begin, end) in zip(estimates, [(0, COUNT), (-5, COUNT + 1000)], strict=True):
        run.start()
        run.take(BLOCK.position, BLOCK.force, each)
        assert run.filter(begin, end) == 0
    np.testing.assert_array_equal(*estimates)


def test_others_are_left_as_they_were(run):
    estimates = np.full((11, COUNT), -1.0)
    run.take(BLOCK.position, BLOCK.force, estimates)
    run.filter(10, 20)
    assert np.all(estimates[:, :10] == -1.0)
    assert np.all(estimates[:, 20:] == -1.0)
    assert np.all(np.isfinite(estimates[0, 10:20]))


def test_arrays_that_do_not_match_are_refused(run):
    with pytest.raises(ValueError, match="do not match"):
        run.take(BLOCK.position, BLOCK.force[1:], np.empty((11, COUNT)))
    with pytest.raises(ValueError, match="do not match"):
        run.take(BLOCK.position, BLOCK.force, np.empty((COUNT, 11)))


def test_estimates_of_another_kind_are_refused(run):
    """Numbers of half the length, every second number, numbers that must not be written."""
    fixed = np.empty((11, COUNT))
    fixed.flags.writeable = False
    others = np.empty((11, COUNT), np.float32), np.empty((11, 2 * COUNT))[:, ::2], fixed
    for other in others:
        with pytest.raises((TypeError, ValueError)):
            run.take(BLOCK.position, BLOCK.force, other)


def test_samples_may_be_any_arrays(run):
    estimates = [np.empty((11, COUNT)) for _ in range(2)]
    apart = np.column_stack([BLOCK.position, BLOCK.force]).T
    for each, (position, force) in zip(
        estimates, [(BLOCK.position, BLOCK.force), apart], strict=True
    ):
        run.start()
        run.take(position, force, each)
        run.filter(0, COUNT)
    np.testing.assert_array_equal(*estimates)
