"""What an estimator does between blocks: cuts, gaps, repeats, restarts, bad samples."""

import dataclasses

import numpy as np
import pytest
from measured import START, block_of

from benchmarks.estimators_simulator import Experiment
from tissue_probe.estimation import ESTIMATORS, Estimator, EstimatorSettings
from tissue_probe.signals import TissueEstimates

SETTINGS = EstimatorSettings()


@pytest.fixture(params=list(ESTIMATORS))
def name(request):
    return request.param


@pytest.fixture(scope="module")
def block():
    return block_of(Experiment(duration=0.6))


def process_in_parts(estimator, blocks):
    return TissueEstimates.concatenate([estimator.process(part) for part in blocks])


def assert_identical(first, second):
    for one, other in zip(first.arrays(), second.arrays(), strict=True):
        np.testing.assert_array_equal(one, other)


def cut(block, *sizes):
    parts, begin = [], 0
    while begin < len(block):
        size = sizes[len(parts) % len(sizes)]
        parts.append(block[begin : begin + size])
        begin += size
    return parts


@pytest.mark.parametrize("sizes", [(1,), (10,), (7, 1, 64, 3)])
def test_estimates_do_not_depend_on_how_the_stream_is_cut(name, block, sizes):
    spoilt = block.force.copy()
    spoilt[[100, 300, 301]] = np.nan
    block = dataclasses.replace(block, force=spoilt)
    whole, parts = Estimator(name, SETTINGS), Estimator(name, SETTINGS)
    for estimator in (whole, parts):
        estimator.restart_at(int(block.stamps[505]) - 3)
    assert_identical(whole.process(block), process_in_parts(parts, cut(block, *sizes)))
    assert (whole.missing, whole.restarts) == (parts.missing, parts.restarts) == (3, 1)


def test_an_estimate_carries_its_samples_stamp_and_sequence(name, block):
    estimates = Estimator(name, SETTINGS).process(dataclasses.replace(block, sequence=40))
    assert estimates.estimator == name
    np.testing.assert_array_equal(estimates.stamp, block.stamps)
    np.testing.assert_array_equal(estimates.sequence, 40 + np.arange(len(block)))


def test_an_unknown_name_is_refused_with_the_known_ones(name):
    with pytest.raises(ValueError, match=name):
        Estimator("particle", SETTINGS)


def test_a_gap_keeps_the_tissue_and_forgets_the_motion(name, block):
    estimator = Estimator(name, SETTINGS)
    before = estimator.process(block[:600])
    after = estimator.process(block[737:])
    assert (estimator.gaps, estimator.lost, estimator.restarts) == (1, 137, 0)
    assert after.stiffness[0] == pytest.approx(before.stiffness[-1], rel=0.02)
    assert after.damping[0] == pytest.approx(before.damping[-1], rel=0.05)
    assert np.all(np.abs(after.stiffness - 450) < 15)
    assert np.all(np.abs(after.damping - 5) < 0.25)


def test_a_repeat_is_ignored_and_counted(name, block):
    clean, repeated = Estimator(name, SETTINGS), Estimator(name, SETTINGS)
    expected = clean.process(block)
    parts = [repeated.process(block[:300])]
    nothing = repeated.process(block[100:200])
    parts.append(repeated.process(block[250:]))
    assert len(nothing) == 0
    assert_identical(expected, TissueEstimates.concatenate(parts))
    assert (repeated.repeats, repeated.gaps) == (150, 0)


def test_a_sequence_that_begins_again_forgets_everything(name, block):
    again, fresh = Estimator(name, SETTINGS), Estimator(name, SETTINGS)
    again.process(block[:400])
    assert_identical(again.process(block), fresh.process(block))
    assert again.restarts == 1


def test_a_new_activation_is_recognised_though_its_first_block_was_missed(name, block):
    again, fresh = Estimator(name, SETTINGS), Estimator(name, SETTINGS)
    again.process(block[:900])
    later = dataclasses.replace(block, stamp=block.end + 5_000_000_000)[10:]
    assert_identical(again.process(later), fresh.process(later))
    assert (again.restarts, again.repeats) == (1, 0)


def test_another_sample_period_forgets_everything(name, block):
    estimator, fresh = Estimator(name, SETTINGS), Estimator(name, SETTINGS)
    estimator.process(block[:400])
    slower = block_of(Experiment(duration=0.5, sample_period=1e-3), first=400)
    assert_identical(estimator.process(slower), fresh.process(slower))
    assert estimator.restarts == 1


def test_restart_equals_a_new_estimator(name, block):
    estimator = Estimator(name, SETTINGS)
    estimator.process(block[:300])
    estimator.restart()
    fresh = Estimator(name, SETTINGS).process(block[300:])
    assert_identical(estimator.process(block[300:]), fresh)


@pytest.mark.parametrize(
    ("stamp", "forgets_at"),
    [
        (START + 200_000_000, 400),
        (START + 200_000_001, 401),
        (START - 5_000_000_000, 300),
        (START + 149_750_000, 300),
    ],
)
def test_restart_at_forgets_at_the_first_sample_of_that_time(name, block, stamp, forgets_at):
    estimator = Estimator(name, SETTINGS)
    estimator.process(block[:300])
    estimator.restart_at(stamp)
    estimates = estimator.process(block[300:])
    fresh = Estimator(name, SETTINGS).process(block[forgets_at:])
    assert_identical(estimates[forgets_at - 300 :], fresh)
    assert estimator.restarts == 1


def test_restart_at_waits_for_a_time_to_come(name, block):
    estimator = Estimator(name, SETTINGS)
    estimator.restart_at(block.end + 10_000_000)
    estimator.process(block)
    assert estimator.restarts == 0
    late = dataclasses.replace(block, stamp=block.end, sequence=len(block))
    estimator.process(late)
    assert estimator.restarts == 1


@pytest.mark.parametrize("channel", ["position", "force"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_missing_sample_has_no_innovation_and_spoils_nothing(name, block, channel, value):
    values = getattr(block, channel).copy()
    values[[0, 500, 501, 502, 700]] = value
    estimator = Estimator(name, SETTINGS)
    estimates = estimator.process(dataclasses.replace(block, **{channel: values}))
    assert estimator.missing == 5
    for entry in (estimates.innovation, estimates.normalized_innovation_squared):
        assert np.flatnonzero(np.isnan(entry)).tolist() == [0, 500, 501, 502, 700]
    for entry in dataclasses.fields(estimates)[1:-1]:  # all but the names
        if entry.name not in ("innovation", "normalized_innovation_squared"):
            assert np.all(np.isfinite(getattr(estimates, entry.name))), entry.name
    assert estimates.stiffness[-1] == pytest.approx(450, rel=0.01)
    assert estimates.damping[-1] == pytest.approx(5, rel=0.02)
