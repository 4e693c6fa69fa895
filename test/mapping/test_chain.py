"""The chain: without data it draws from the prior, whatever its moves."""

import numpy as np
import pytest

from tissue_probe.mapping.posterior.background import Background
from tissue_probe.mapping.posterior.domain import Domain
from tissue_probe.mapping.posterior.outliers import prior_of
from tissue_probe.mapping.posterior.prior import (
    CONTRAST_SCALE,
    FURTHER,
    LOG_CONTRAST,
    LOG_RADIUS,
    RADIUS,
    RADIUS_SPREAD,
    SOFT,
)
from tissue_probe.mapping.posterior.sampling import Chains, States


@pytest.fixture(scope="module")
def prior_states():
    along = np.linspace(0.0, 40.0, 4)
    x, y = (each.ravel() for each in np.meshgrid(along, along))
    noise = np.full(16, 1e3)  # sites that say nothing
    domain = Domain.of(x, y, np.empty((0, 2)))
    background = Background.of(x, y, None, noise)
    chains = Chains(np.zeros(16), domain.region(x, y), background, prior_of(None))
    return States.join_parts([chains.further() for _ in range(24)])


def test_each_further_inclusion_is_as_likely_as_the_prior_says(prior_states):
    counts = np.bincount(prior_states.count.ravel())
    assert counts[1] / counts[0] == pytest.approx(FURTHER, rel=0.1)


def test_extent_and_contrast_are_those_of_the_prior(prior_states):
    rows, count, _, _ = prior_states.flat()
    lone = rows[count == 1, 0]
    assert lone[:, LOG_RADIUS].mean() == pytest.approx(np.log(RADIUS), abs=0.05)
    assert lone[:, LOG_RADIUS].std() == pytest.approx(RADIUS_SPREAD, rel=0.15)
    size = np.abs(lone[:, LOG_CONTRAST])
    assert size.mean() == pytest.approx(2.0 * CONTRAST_SCALE, rel=0.1)
    assert (lone[:, LOG_CONTRAST] < 0.0).mean() == pytest.approx(SOFT, abs=0.05)
