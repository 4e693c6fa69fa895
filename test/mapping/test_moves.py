"""The moves of a chain: each alone leaves the prior as it is, at sites that say nothing."""

import numpy as np
import pytest
from numba import njit
from scipy.stats import ks_2samp

from tissue_probe.mapping.posterior.background import Background
from tissue_probe.mapping.posterior.domain import Domain
from tissue_probe.mapping.posterior.moves import (
    KINDS,
    begin_state,
    make_scratch,
    propose_birth,
    propose_change,
    propose_death,
    propose_level,
    propose_redraw,
)
from tissue_probe.mapping.posterior.outliers import VARIANCES, prior_of, propose_errors
from tissue_probe.mapping.posterior.prior import (
    FURTHER,
    LOG_CONTRAST,
    MOST_INCLUSIONS,
    OVERLAP_POWER,
    PARAMETERS,
    X,
    Y,
    draw_contrast,
    draw_shape,
)
from tissue_probe.mapping.posterior.shape import measure_distance

DRAWS = 2500
#: Moves after each draw: enough that most draws are changed by it.
MOVES = 12
#: So improbable a difference is none of chance, in any of 64 comparisons.
ODD = 1e-4

ALONG = np.linspace(0.0, 40.0, 5)
SX, SY = (each.ravel() for each in np.meshgrid(ALONG, ALONG))
REGION = Domain.of(SX, SY, np.empty((0, 2))).region(SX, SY)
BACKGROUND = Background.of(SX, SY, None, np.full(SX.size, 1e3))
Q = BACKGROUND.precision[0]
NO_OUTLIER = np.zeros(SX.size, dtype=np.int8)


@njit
def seeded(seed):
    """Seed the draws of compiled code, which are not those of Python."""
    np.random.seed(seed)  # noqa: NPY002 - Numba has no other for its own


def from_prior(rng):
    """Draw inclusions from the prior, each set as likely as it leaves one another room."""
    while True:
        count = rng.geometric(1.0 - FURTHER) - 1
        rows = np.zeros((MOST_INCLUSIONS, PARAMETERS))
        for row in rows[:count]:
            draw_shape(row)
            row[LOG_CONTRAST] = draw_contrast()
            row[X], row[Y] = rng.uniform(REGION.box[::2], REGION.box[1::2])
        if rng.random() < room(rows[:count]):
            return rows, count


def room(rows):
    share = 1.0
    for i, one in enumerate(rows):
        for other in rows[:i]:
            apart = np.hypot(one[X] - other[X], one[Y] - other[Y])
            inside = min(
                measure_distance(one, other[X], other[Y]), measure_distance(other, one[X], one[Y])
            )
            both = np.exp(one[2]) + np.exp(other[2])
            share *= min(apart / both, 1.0) ** OVERLAP_POWER if inside >= 1.0 else 0.0
    return share


coin = np.random.default_rng(3)


def birth_or_death(state, count, scratch, beta):
    move = propose_birth if coin.random() < 0.5 else propose_death
    return move(state, count, beta, REGION, scratch)


def anew(state, count, scratch, beta):
    propose_redraw(state, count, beta, REGION, scratch)
    return count


def change_of(kind):
    def change(state, count, scratch, beta):
        propose_change(state, count, kind, beta, REGION, scratch)
        return count

    return change


MOVE = {
    "birth or death": birth_or_death,
    "anew": anew,
    **{f"change {kind}": change_of(kind) for kind in range(KINDS)},
}


@pytest.fixture(scope="module")
def other_draws():
    rng = np.random.default_rng(1)
    seeded(1)
    draws = [from_prior(rng) for _ in range(DRAWS)]
    return np.array([n for _, n in draws]), np.concatenate([rows[:n] for rows, n in draws])


@pytest.mark.parametrize("name", MOVE)
def test_each_kind_of_move_alone_gives_the_prior_back(name, other_draws):
    rng, scratch, move = np.random.default_rng(0), make_scratch(SX.size), MOVE[name]
    seeded(2)
    counts, found, changed = [], [], 0
    for _ in range(DRAWS):
        rows, count = from_prior(rng)
        begin = rows.copy(), count
        state = begin_state(rows, count, NO_OUTLIER, Q, np.zeros(SX.size), REGION)
        for _ in range(MOVES):
            count = move(state, count, scratch, 1.0)
        changed += count != begin[1] or not np.array_equal(rows[:count], begin[0][:count])
        counts.append(count)
        found.append(state.inclusions[:count].copy())
    assert changed > 0.4 * DRAWS
    true_counts, true_rows = other_draws
    assert ks_2samp(counts, true_counts).pvalue > ODD
    for column, here in enumerate(np.concatenate(found).T):
        assert ks_2samp(here, true_rows[:, column]).pvalue > ODD, f"column {column}"


def test_the_level_alone_gives_its_prior_back():
    weight = np.log(np.linspace(1.0, 3.0, BACKGROUND.log_weight.size))
    state = begin_state(
        np.zeros((MOST_INCLUSIONS, PARAMETERS)), 0, NO_OUTLIER, Q, np.zeros(SX.size), REGION
    )
    scratch = make_scratch(SX.size)
    seeded(4)
    level, times = 0, np.zeros(weight.size)
    for _ in range(40_000):
        level = propose_level(state, level, 1.0, BACKGROUND.precision, weight, scratch)
        times[level] += 1
    lower = times[: weight.size // 2].sum() / times.sum()
    expected = np.exp(weight[: weight.size // 2]).sum() / np.exp(weight).sum()
    assert lower == pytest.approx(expected, abs=0.03)


@pytest.mark.parametrize(
    ("share", "mean", "variance"), [(None, 0.01, 0.01 * 0.99 / 101), (0.1, 0.1, 0.0)]
)
def test_outliers_alone_give_their_prior_back(share, mean, variance):
    n = SX.size
    kinds = NO_OUTLIER.copy()
    state = begin_state(np.zeros((MOST_INCLUSIONS, PARAMETERS)), 0, kinds, Q, np.zeros(n), REGION)
    seeded(5)
    counts, each = np.zeros(60_000), np.zeros(VARIANCES.size)
    for i in range(counts.size):
        propose_errors(state, 1.0, prior_of(share))
        counts[i] = np.count_nonzero(kinds)
        each += np.bincount(kinds, minlength=each.size)
    # Of a beta-binomial number.
    assert counts.mean() == pytest.approx(n * mean, rel=0.08)
    expected = n * mean * (1 - mean) + n * (n - 1) * variance
    assert counts.var() == pytest.approx(expected, rel=0.2)
    assert each[1:] / each[1:].sum() == pytest.approx(
        np.full(each.size - 1, 1 / (each.size - 1)), abs=0.03
    )


def test_no_site_is_an_outlier_where_none_is_stated():
    kinds = NO_OUTLIER.copy()
    y = np.where(np.arange(SX.size) == 12, 1.0, 0.0)
    exact = Background.of(SX, SY, None, np.full(SX.size, 0.02)).precision[0]
    state = begin_state(np.zeros((MOST_INCLUSIONS, PARAMETERS)), 0, kinds, exact, y, REGION)
    for _ in range(100):
        propose_errors(state, 1.0, prior_of(0.0))
    assert not kinds.any()


def test_precision_residuals_and_determinant_are_those_of_the_outliers():
    rng = np.random.default_rng(6)
    kinds, y = NO_OUTLIER.copy(), 0.05 * rng.standard_normal(SX.size)
    background = Background.of(SX, SY, None, np.full(SX.size, 0.02))
    exact = background.precision[0]
    state = begin_state(np.zeros((MOST_INCLUSIONS, PARAMETERS)), 0, kinds, exact, y, REGION)
    seeded(6)
    for _ in range(300):
        propose_errors(state, 0.3, prior_of(0.3))
    assert kinds.any()
    covariance = np.linalg.inv(exact) + np.diag(VARIANCES[kinds])
    assert state.precision == pytest.approx(np.linalg.inv(covariance), rel=1e-6, abs=1e-6)
    assert state.residual == pytest.approx(np.linalg.solve(covariance, y), rel=1e-6, abs=1e-6)
    both = np.linalg.slogdet(exact)[1] + np.linalg.slogdet(covariance)[1]
    assert state.log_det[0] == pytest.approx(-0.5 * both, abs=1e-6)
