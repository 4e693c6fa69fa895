"""The rigid motion between point pairs, and whether its stated errors hold."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.registration import register

angles = st.floats(-np.pi, np.pi)
lengths = st.floats(-0.5, 0.5)


def spread(count, dimensions=3, seed=0):
    return 0.05 * np.random.default_rng(seed).random((count, dimensions))


@settings(max_examples=50, deadline=None)
@given(st.integers(3, 8), st.tuples(angles, angles, angles), st.tuples(lengths, lengths, lengths))
def test_an_exact_motion_is_found_from_three_pairs_on(count, turn, shift):
    places = spread(count)
    turned = Rotation.from_euler("xyz", turn).as_matrix()
    found = register(places, places @ turned.T + shift)
    np.testing.assert_allclose(found.rotation, turned, atol=1e-7)
    np.testing.assert_allclose(found.move_places(places), places @ turned.T + shift, atol=1e-9)
    assert found.fiducial_error < 1e-9


@given(angles, st.tuples(lengths, lengths))
def test_in_the_plane_it_turns_about_z_and_keeps_the_height(angle, shift):
    places = spread(4, dimensions=2)
    turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    found = register(places, places @ turned.T + shift)
    at = np.array([[0.01, 0.02, 0.003]])
    np.testing.assert_allclose(found.move_places(at)[0, :2], turned @ at[0, :2] + shift, atol=1e-9)
    assert found.move_places(at)[0, 2] == pytest.approx(0.003, abs=1e-9)


@pytest.mark.parametrize(("dimensions", "count"), [(3, 3), (3, 6), (2, 3), (2, 6)])
def test_the_stated_errors_are_those_that_noisy_pairs_make(dimensions, count):
    rng = np.random.default_rng(5)
    places = spread(count, dimensions)
    noise = 0.0002  # of each coordinate
    target = np.array([[0.12, -0.03, 0.02]])[:, : 3 if dimensions == 3 else 2]
    in_space = np.column_stack([target, np.zeros((1, 3 - dimensions))])
    off, stated, localised = [], [], []
    for _ in range(1500):
        found = register(places, places + noise * rng.standard_normal(places.shape))
        off.append(np.linalg.norm(found.move_places(in_space) - in_space))
        stated.append(found.target_error(in_space)[0])
        localised.append(found.localisation_error)
    # Means of squares of 1500 draws, which are known to some 5 %; the theory is of first order.
    assert np.mean(np.square(off)) == pytest.approx(np.mean(np.square(stated)), rel=0.15)
    assert np.mean(np.square(localised)) == pytest.approx(dimensions * noise**2, rel=0.15)


CORNERS = np.array([[0.0, 0.0, 0.0], [0.04, 0.0, 0.0], [0.0, 0.03, 0.0], [0.04, 0.03, 0.01]])


@pytest.mark.parametrize(
    ("places", "others", "told"),
    [
        (CORNERS[:2], CORNERS[:2], "2 pairs tell no rotation: give 3 or more"),
        (CORNERS[[0, 1, 1]], CORNERS[:3], "lie on a line in the map's frame"),
        (CORNERS[:3], CORNERS[[0, 1, 0]], "lie on a line in the other frame"),
        (CORNERS, CORNERS[[1, 0, 2, 3]], "no rigid motion fits the pairs"),
        (CORNERS, 1000.0 * CORNERS, "look at their order, units"),
        (CORNERS, CORNERS + np.array([0.0, np.nan, 0.0]), "pair 1 has no place in the other frame"),
        (CORNERS[:, :2], CORNERS[:, 1::-1], "mirror images"),
    ],
)
def test_pairs_that_tell_no_motion_are_refused_in_one_sentence(places, others, told):
    with pytest.raises(ParameterError, match=told) as refused:
        register(places, others)
    assert "\n" not in str(refused.value)


def test_the_pair_that_fits_worst_is_named():
    others = CORNERS + 0.0
    others[2, 2] += 0.05
    with pytest.raises(ParameterError, match=r"pair [123] most"):
        register(CORNERS, others)
