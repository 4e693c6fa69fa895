"""Samples are read from CSV exactly, or refused with the place and the reason."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from tissue_probe.recording.csv_file import read_csv
from tissue_probe.recording.errors import RecordingError


@pytest.fixture
def csv(tmp_path):
    """Write a CSV file and return its path."""

    def write(text):
        file = tmp_path / "measured.csv"
        file.write_text(text, encoding="utf-8")
        return file

    return write


@given(
    samples=st.lists(st.tuples(st.floats(), st.floats()), min_size=2, max_size=20),
    period=st.sampled_from([5e-4, 1e-3, 1 / 3000, 0.25, 10.0]),
    start=st.sampled_from([0.0, 2.5, 1_700_000_000.0]),
)
@settings(max_examples=60, deadline=None)
def test_samples_are_read_as_they_were_written(samples, period, start):
    lines = [f"{start + n * period!r},{u!r},{f!r}" for n, (u, f) in enumerate(samples)]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "measured.csv")
        file.write_text("\n".join(["t,u,F", *lines]))
        (block,) = read_csv(file).blocks
    assert_array_equal(block.position, [u for u, _ in samples])
    assert_array_equal(block.force, [f for _, f in samples])
    assert np.isnan(block.command).all()
    assert block.stamp == round(start * 1e9)
    assert block.sequence == 0
    assert block.sample_period == pytest.approx(period, rel=3e-3 if start > 10.0 else 1e-9)


def test_a_force_positive_in_tension_changes_its_sign(csv):
    file = csv("t,u,F\n0,1,2\n1,1,-3\n")
    assert read_csv(file).force.tolist() == [2.0, -3.0]
    assert read_csv(file, polarity="tension").force.tolist() == [-2.0, 3.0]


def test_columns_have_the_names_given_in_any_order_beside_others(csv):
    file = csv("force, note ,time,x\n2,a,0,1\n4,b,0.5,3\n")
    recording = read_csv(file, position="x", force="force", time="time")
    assert recording.position.tolist() == [1.0, 3.0]
    assert recording.force.tolist() == [2.0, 4.0]


def test_a_byte_order_mark_and_blank_lines_do_no_harm(csv):
    assert len(read_csv(csv("\ufefft,u,F\r\n0,1,2\r\n\r\n1,1,2\r\n\r\n"))) == 2


def test_an_empty_cell_and_nan_are_samples_not_known(csv):
    recording = read_csv(csv("t,u,F\n0,,2\n1,1,nan\n2,1, \n"))
    assert_array_equal(recording.position, [np.nan, 1.0, 1.0])
    assert_array_equal(recording.force, [2.0, np.nan, np.nan])


def test_times_rounded_by_their_writer_give_the_true_period(csv):
    times = [f"{n / 3000:.4f}" for n in range(3000)]
    recording = read_csv(csv("t,u,F\n" + "".join(f"{t},0,0\n" for t in times)))
    (block,) = recording.blocks
    assert block.sample_period == pytest.approx(1 / 3000, rel=1e-4)


def test_missing_samples_become_a_gap_in_the_sequence(csv):
    recording = read_csv(csv("t,u,F\n5,0,0\n6,1,0\n9,4,0\n10,5,0\n11,6,0\n"))
    first, second = recording.blocks
    assert (first.sequence, len(first), first.stamp) == (0, 2, 5 * 10**9)
    assert (second.sequence, len(second), second.stamp) == (4, 3, 9 * 10**9)
    assert second.position.tolist() == [4.0, 5.0, 6.0]


def test_a_sample_period_stands_for_the_times(csv):
    (block,) = read_csv(csv("u,F\n1,2\n3,4\n"), sample_period=5e-4).blocks
    assert (block.stamp, block.sequence, block.sample_period) == (0, 0, 5e-4)
    assert block.position.tolist() == [1.0, 3.0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no column u, F, t; its columns are none: it is empty"),
        ("t,u\n0,1\n", "no column F; its columns are t, u"),
        ("t;u;F\n0;1;2\n", "separates its cells by semicolons; write it with commas"),
        ("t\tu\tF\n0\t1\t2\n", "separates its cells by tabs; write it with commas"),
        ("t,u,F\n", "no rows"),
        ("t,u,F\n0,1,2\n", "has one row"),
        ("t,u,F\n0,1,2\n1,1,two\n", "line 3: column F is 'two'"),
        ("t,u,F\n0,1,2\n1,1\n", "line 3: 2 cells, but the header names 3 columns"),
        ("t,u,F\n0,1,2\n,1,2\n", "row 2 below the header (t = nan s): no time"),
        ("t,u,F\n0,1,2\ninf,1,2\n", "row 2 below the header (t = inf s): no time"),
        ("t,u,F\n0,1,2\n1,1,2\n1,1,2\n", "row 3 below the header (t = 1 s): a time not later"),
        ("t,u,F\n0,1,2\n1,1,2\n0.5,1,2\n", "row 3 below the header (t = 0.5 s): a time not later"),
        ("t,u,F\n0,1,2\n1,1,2\n2,1,2\n3.5,1,2\n", "row 4 below the header (t = 3.5 s): a step"),
        ("t,u,F\n0,1,2\n1,1,2\n2,1,2\n2.1,1,2\n", "row 4 below the header (t = 2.1 s): a step"),
    ],
)
def test_a_file_that_is_no_measurement_is_refused_with_the_place(text, said, csv):
    file = csv(text)
    with pytest.raises(RecordingError) as raised:
        read_csv(file)
    assert said in str(raised.value)
    assert str(file) in str(raised.value)


def test_a_step_may_deviate_by_a_quarter_of_a_period(csv):
    rows = "".join(f"{second},0,0\n" for second in range(50))
    assert len(read_csv(csv(f"t,u,F\n{rows}50.2,0,0\n"))) == 51
    with pytest.raises(RecordingError, match="row 51 below the header"):
        read_csv(csv(f"t,u,F\n{rows}50.3,0,0\n"))


def test_a_file_that_is_no_text_is_refused(tmp_path):
    (tmp_path / "run.mcap").write_bytes(b"\x89MCAP0\r\n")
    with pytest.raises(RecordingError, match="not a CSV file"):
        read_csv(tmp_path / "run.mcap")


def test_another_word_for_the_polarity_is_refused(csv):
    with pytest.raises(ValueError, match="'pull'; it is 'compression' or 'tension'"):
        read_csv(csv("t,u,F\n0,1,2\n1,1,2\n"), polarity="pull")


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan")])
def test_a_period_that_is_not_positive_is_refused(period, csv):
    with pytest.raises(ValueError, match="sample_period"):
        read_csv(csv("u,F\n1,2\n"), sample_period=period)
