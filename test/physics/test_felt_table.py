"""A phantom from a table of felt stiffness, and its file."""

import csv
import re

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.physics.felt_table import MOST_POINTS, FeltTable
from tissue_probe.physics.phantom import load_phantom


def write(path, **columns):
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(columns)
        rows.writerows(zip(*columns.values(), strict=True))
    return path


def scattered(count, seed=0):
    return 0.04 * np.random.default_rng(seed).random((2, count))


@settings(max_examples=25, deadline=None)
@given(
    st.integers(3, 60),
    st.floats(200.0, 5000.0),
    st.tuples(st.floats(-2000.0, 2000.0), st.floats(-2000.0, 2000.0)),
)
def test_a_plane_is_met_everywhere_between_the_points(count, level, slope):
    x, y = scattered(count)
    k = level + slope[0] * x + slope[1] * y
    table = FeltTable.of(x, y, k)
    weights = np.random.default_rng(1).dirichlet(np.ones(count), 20)  # places inside the hull
    inside_x, inside_y = weights @ x, weights @ y
    expected = level + slope[0] * inside_x + slope[1] * inside_y
    np.testing.assert_allclose(table.stiffness(inside_x, inside_y), expected, rtol=2e-5)


def test_a_smooth_surface_made_elsewhere_is_met_to_the_error_of_lines_between_points(tmp_path):
    def elsewhere(x, y):
        return 300.0 * (1.2 + np.sin(80.0 * x) * np.cos(60.0 * y))

    axis = np.linspace(0.0, 0.04, 41)
    x, y = (each.ravel() for each in np.meshgrid(axis, axis))
    table = load_phantom(write(tmp_path / "felt.csv", x=x, y=y, k=elsewhere(x, y)))
    at = scattered(200, seed=3)
    # Half the square of the step times the largest curvatures.
    bound = 0.5 * 0.001**2 * 300.0 * (80.0 + 60.0) ** 2
    assert np.abs(table.stiffness(*at) - elsewhere(*at)).max() < bound


def test_beyond_the_points_the_nearest_ones_value_holds():
    table = FeltTable.of([0.0, 0.01, 0.0], [0.0, 0.0, 0.01], [400.0, 500.0, 600.0])
    assert table.stiffness(-0.02, -0.02) == 400.0
    assert table.stiffness([0.05, 0.0], [0.0, 0.05]).tolist() == [500.0, 600.0]


def test_without_damping_it_follows_the_stiffness_and_with_it_is_as_given():
    places = [0.0, 0.01, 0.0], [0.0, 0.0, 0.01]
    follows = FeltTable.of(*places, [450.0, 900.0, 450.0])
    assert follows.damping(0.01, 0.0) == pytest.approx(2.0 * follows.damping(0.0, 0.0))
    given_too = FeltTable.of(*places, [450.0] * 3, beta=[1.0, 2.0, 3.0])
    assert given_too.damping(*places).tolist() == [1.0, 2.0, 3.0]


def test_the_surface_is_as_high_as_the_table_says():
    places = [0.0, 0.01, 0.0], [0.0, 0.0, 0.01]
    assert FeltTable.of(*places, [450.0] * 3).height(0.002, 0.002) == 0.0
    table = FeltTable.of(*places, [450.0] * 3, z=[0.001, 0.002, 0.001])
    assert table.height(0.005, 0.0) == pytest.approx(0.0015)


def test_the_longest_table_is_short_enough_for_a_recording_and_comes_back_the_same():
    from tissue_probe import bounded_yaml

    x, y = scattered(MOST_POINTS)
    more = np.random.default_rng(2).random((3, MOST_POINTS))
    table = FeltTable.of(x, y, 1e3 + 1e3 * more[0], -more[1], 1.0 + more[2])
    written = yaml.safe_dump(table.model_dump(mode="json"), default_flow_style=None)
    recorded = yaml.safe_dump(written)  # each parameter once more, as the recorder writes it
    back = FeltTable.model_validate(bounded_yaml.parse(bounded_yaml.parse(recorded)))
    assert back == table


GOOD = {"x": [0.0, 0.01, 0.0], "y": [0.0, 0.0, 0.01], "k": [400.0, 500.0, 600.0]}


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"k": ["400", "soft", "600"]}, "k in line 3 is 'soft': give a number"),
        ({"k": ["400", "", "600"]}, "k in line 3 is '': give a number"),
        ({"k": [400.0, -1.0, 600.0]}, "k of point 2 is -1: give a number from 1 to 100000 [N/m]"),
        ({"k": [400.0, 500.0, "nan"]}, "k of point 3 is nan"),
        ({"x": [0.0, 500.0, 0.0]}, "x of point 2 is 500"),
        ({"x": [0.0, 0.01, 0.02], "y": [0.0, 0.0, 0.0]}, "the points lie on one line"),
        ({"x": [0.0, 0.01, 0.0], "y": [0.0, 0.0, 0.0]}, "(0, 0) m stands there twice"),
        ({"beta": [1.0, 2.0, -3.0]}, "beta of point 3 is -3"),
        ({name: [] for name in "xyk"}, "the points lie on one line: give three or more"),
        ({name: list(range(MOST_POINTS + 1)) for name in "xyk"}, "takes at most"),
    ],
)
def test_a_table_that_is_no_phantom_is_refused_in_one_sentence(tmp_path, changed, told):
    path = write(tmp_path / "felt.csv", **(GOOD | changed))
    with pytest.raises(ValueError, match=re.escape(told)) as refused:
        load_phantom(path)
    assert str(path) in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("content", [b"", b"x,y\n0,0\n", b"\x00\xff\xfe\x80", b"x;y;k\n0;0;400\n"])
def test_a_file_that_is_no_such_table_is_refused_and_named(tmp_path, content):
    path = tmp_path / "felt.csv"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"felt\.csv"):
        load_phantom(path)
