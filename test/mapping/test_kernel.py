"""The kernel of the map's Gaussian processes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.distance import pdist, squareform

from tissue_probe.mapping.kernel import correlate_places, slope

steps = st.floats(-3.0, 3.0)


@given(st.lists(st.tuples(steps, steps), min_size=2, max_size=8, unique=True))
def test_places_are_a_covariance_whatever_they_are(places):
    likeness = correlate_places(squareform(pdist(np.array(places))))
    assert np.diag(likeness) == pytest.approx(1.0)
    assert np.linalg.eigvalsh(likeness).min() > -1e-12


@given(steps, steps)
def test_the_slope_is_the_change_of_the_correlation(x, y):
    step = 1e-5
    here = np.array([x, y])
    for axis in np.eye(2):
        ends = [correlate_places(np.linalg.norm(here + sign * step * axis)) for sign in (1.0, -1.0)]
        due = (ends[0] - ends[1]) / (2.0 * step)
        assert slope(here) @ axis == pytest.approx(due, abs=1e-8)
