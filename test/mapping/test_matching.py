"""Found places held against true ones."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.mapping.matching import match


def test_a_match_names_pairs_missed_and_false():
    found = [(0.031, 0.01), (0.0, 0.04)]
    result = match(found, [(0.01, 0.01), (0.03, 0.01)], tolerance=0.005)
    assert result.pairs == ((0, 1, pytest.approx(0.001)),)
    assert result.missed == (0,)
    assert result.false == (1,)


def test_a_match_prefers_more_pairs_to_nearer_ones():
    found = [(0.000, 0.0), (0.004, 0.0)]
    result = match(found, [(0.001, 0.0), (-0.004, 0.0)], tolerance=0.005)
    assert {pair[:2] for pair in result.pairs} == {(0, 1), (1, 0)}


places = st.lists(st.tuples(st.floats(0.0, 0.04), st.floats(0.0, 0.04)), max_size=5)


@given(places, places, st.floats(1e-4, 0.05))
def test_every_found_place_and_every_true_one_is_accounted_for_once(found, true, tolerance):
    result = match(found, true, tolerance)
    assert sorted([p[0] for p in result.pairs] + list(result.false)) == list(range(len(found)))
    assert sorted([p[1] for p in result.pairs] + list(result.missed)) == list(range(len(true)))
    assert all(distance <= tolerance for _, _, distance in result.pairs)
