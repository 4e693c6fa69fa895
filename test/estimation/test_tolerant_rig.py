"""Constants that are off within their tolerances: what is claimed then, and what is not rejected.

Records are the challenge's, which shares no code with the filters; of clean tissue.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from measured import START, block_of

from benchmarks.estimators_simulator import Experiment
from tissue_probe.challenge import make_challenge
from tissue_probe.estimation import Estimator, EstimatorSettings
from tissue_probe.signals import SampleBlock, Status

TOLERANT, EXACT = EstimatorSettings().tolerant(), EstimatorSettings()
KALMAN = ["robust_ekf", "ekf"]
SEEDS = range(9000, 9008)


def recorded(seed, excitation="chirp60"):
    """A record and its tissue."""
    challenge = make_challenge(seed, (), excitation, "tolerant")
    position, force = (
        np.asarray(each) for each in (challenge.recording.position, challenge.recording.force)
    )
    block = SampleBlock(START, 0, 5e-4, position, force, np.full(position.size, np.nan))
    return block, challenge.answer.tissue


@pytest.fixture(scope="module")
def chirps():
    return [recorded(seed) for seed in SEEDS]


@pytest.mark.parametrize("name", KALMAN)
def test_clean_tissue_is_not_rejected_and_is_where_it_is_said_to_be(name, chirps):
    for block, tissue in chirps:
        found = Estimator(name, TOLERANT).process(block)
        assert not np.any(found.status == Status.MODEL_REJECTED)
        for value in ("stiffness", "damping"):
            error = getattr(found, value)[-1] - tissue[value]
            assert abs(error) < 4.0 * math.sqrt(getattr(found, f"{value}_variance")[-1])


def test_a_filter_that_takes_its_constants_as_exact_fails_the_same_test(chirps):
    found = [Estimator("ekf", EXACT).process(block) for block, _ in chirps]
    assert any(np.any(each.status == Status.MODEL_REJECTED) for each in found)


def test_a_mass_that_is_off_shows_in_the_stated_stiffness():
    """One steady sine cannot tell mass from stiffness, dk = dm w^2; its start tells some."""
    block = block_of(Experiment(duration=1.0, frequency=10.0))
    stated, errors = [], []
    for tolerance in (0.0, 0.01):
        off = EXACT.model_copy(update={"tip_mass": 0.0404, "tip_mass_tol": tolerance})
        found = Estimator("robust_ekf", off).process(block)
        stated.append(math.sqrt(found.stiffness_variance[-1]))
        errors.append(abs(found.stiffness[-1] - 450.0))
    by_mass = 0.01 * 0.04 * (20.0 * math.pi) ** 2
    assert 2.0 * stated[0] < stated[1] < math.hypot(stated[0], by_mass)
    assert errors[0] > 3.0 * stated[0]
    assert errors[1] < 2.0 * stated[1]


def test_a_place_of_contact_that_is_off_is_a_constant_force():
    """Without a tolerance it would be a harmonic that contradicts the model."""
    block = block_of(Experiment(duration=1.0, frequency=10.0))
    moved = replace(block, position=block.position + 3e-4)
    only_touch = EXACT.model_copy(update={"contact_position_tol": 3e-4})
    found = Estimator("ekf", only_touch).process(moved)
    assert not np.any(found.status == Status.MODEL_REJECTED)
    assert found.stiffness[-1] == pytest.approx(450.0, rel=0.01)
    # The tissue yields beside the load cell: 450 and 9700 N/m in series.
    assert found.force_offset[-1] == pytest.approx(-3e-4 * 450 * 9700 / 10150, rel=0.1)


def test_constants_that_are_exact_are_not_considered():
    block = block_of(Experiment(duration=0.3))
    exact = Estimator("ekf", EXACT).process(block)
    considered = Estimator("ekf", TOLERANT).process(block)
    assert considered.stiffness_variance[-1] > exact.stiffness_variance[-1]


def test_samples_that_are_lost_forget_nothing_of_the_constants():
    block = block_of(Experiment(duration=1.0))
    estimator = Estimator("robust_ekf", TOLERANT)
    estimator.process(block[:1500])
    found = estimator.process(block[1600:])
    assert found.stiffness[-1] == pytest.approx(450.0, rel=0.02)
    assert np.all(np.isfinite(found.stiffness_variance))
