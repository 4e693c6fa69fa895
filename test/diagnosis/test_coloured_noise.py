"""Coloured noise is made white from the first sample of every stretch on."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import cholesky, toeplitz
from scipy.signal import lfilter

from tissue_probe.diagnosis.observation.coloured_noise import Coloured

#: A resonance with a period of ten samples that rings for some twenty.
POLE = 0.95 * np.exp(0.2j * np.pi)
RINGS = np.array([1.0, -2.0 * POLE.real, abs(POLE) ** 2])


def ringing(count, random):
    return lfilter([1.0], RINGS, random.standard_normal(count + 500))[500:]


def covariance(count):
    answer = lfilter([1.0], RINGS, np.eye(1, 2000)[0])
    return toeplitz([answer[lag:] @ answer[: answer.size - lag] for lag in range(count)])


@pytest.fixture(scope="module")
def whitening():
    return Coloured.of([ringing(400_000, np.random.default_rng(0))], 4, force=1.0, own=0.0)


def test_the_rows_are_those_of_the_covariance(whitening):
    exact = np.linalg.inv(cholesky(covariance(5), lower=True))
    np.testing.assert_allclose(whitening.rows, exact, atol=0.02)


def test_its_deviations_are_those_of_the_noise_and_of_its_news(whitening):
    assert np.sqrt(whitening.power) == pytest.approx(np.sqrt(covariance(1)[0, 0]), rel=0.02)
    assert whitening.news == pytest.approx(1.0, rel=0.01)


@given(seed=st.integers(0, 10_000), first=st.integers(0, 30), gap=st.integers(1, 9))
def test_each_stretch_is_as_probable_as_by_its_own_covariance(seed, first, gap):
    random = np.random.default_rng(seed)
    exact = Coloured(0.0, covariance(3), force=1.0)
    values = ringing(60, random)
    used = np.ones(60, dtype=bool)
    used[first : first + gap] = False
    white = exact.white(values, used)
    assert np.all(white[~used] == 0.0)
    expected = sum(
        own @ np.linalg.solve(covariance(own.size), own)
        for own in (values[:first], values[first + gap :])
        if own.size
    )
    assert white @ white == pytest.approx(expected, rel=1e-6)


def test_columns_are_whitened_alike(whitening):
    values = ringing(90, np.random.default_rng(1)).reshape(30, 3)
    used = np.arange(30) != 7
    together = whitening.white(values, used)
    for column in range(3):
        np.testing.assert_allclose(together[:, column], whitening.white(values[:, column], used))


def test_a_wrong_start_is_not_free_of_charge(whitening):
    """The free motion from a wrong start has the same root as the noise."""
    decay = 50.0 * (POLE ** np.arange(300)).real
    white = whitening.white(decay, np.ones(300, dtype=bool))
    assert np.sum(white**2) > 0.5 * 50.0**2 / np.sqrt(whitening.power) ** 2


@pytest.mark.parametrize(("force", "own"), [(0.3, 0.1), (0.05, 2.0), (0.4, 0.0), (0.0, 0.7)])
def test_both_noises_are_told_from_a_residual(whitening, force, own):
    random, count = np.random.default_rng(2), 20_000
    residual = force * ringing(count, random) + own * random.standard_normal(count)
    found = whitening.likeliest(residual, np.ones(count, dtype=bool))
    assert found.force == pytest.approx(force, rel=0.2, abs=0.01)
    assert found.own == pytest.approx(own, rel=0.2, abs=0.02)


def test_noise_of_the_force_is_no_larger_than_it_may_be(whitening):
    residual = 3.0 * ringing(5000, np.random.default_rng(3))
    assert whitening.likeliest(residual, np.ones(5000, dtype=bool)).force <= whitening.force
