"""One recording is one row of numbers and texts, whatever becomes of it."""

from __future__ import annotations

import pickle

import pytest
from laboratory import QUESTION, write

import tissue_probe as tp


def test_a_comparison_is_a_row_of_plain_data_that_pickles(laboratory):
    row = tp.row(laboratory / "a_1.csv", "compare", **QUESTION)
    assert row["status"] == "done"
    assert row["stiffness"] == pytest.approx(300.0, abs=4.0 * row["stiffness_sd"])
    assert row["damping"] == pytest.approx(3.0, abs=4.0 * row["damping_sd"])
    assert row["noise"] == pytest.approx(2e-3, rel=0.1)
    assert row["samples"] == 1000
    assert row["duration"] == pytest.approx(1.0)
    assert all(isinstance(value, (int, float, str)) for value in row.values())
    assert pickle.loads(pickle.dumps(row)) == row


def test_a_filter_gives_a_row_with_its_status(laboratory):
    row = tp.row(laboratory / "b_1.csv", **QUESTION, estimator="robust_ekf")
    assert row["task"] == "estimate"
    assert row["stiffness"] == pytest.approx(400.0, rel=0.05)
    assert row["quality"] == "converged"


@pytest.mark.whole_library
def test_a_diagnosis_gives_verdict_and_probabilities(laboratory):
    row = tp.row(laboratory / "c_1.csv", "diagnose", **QUESTION)
    assert row["verdict"] == "adequate"
    assert row["missing"] == ""
    assert row["over_noise"] == pytest.approx(1.0, abs=0.1)
    assert all(0.0 <= p <= 1.0 for name, p in row.items() if name.startswith("probability."))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("t,u,F\n", "no rows below it"),
        ("t,u\n0,1\n1,2\n", "does not say which column is"),
        (None, "No such file"),
    ],
)
def test_a_recording_that_cannot_be_read_is_a_row_with_its_sentence(tmp_path, content, said):
    path = tmp_path / "x.csv"
    if content is not None:
        path.write_text(content)
    row = tp.row(path, "compare", **QUESTION)
    assert row["status"] == "refused"
    assert said in row["sentence"]
    assert "stiffness" not in row


def test_the_key_changes_with_file_question_and_task_alone(tmp_path):
    first, second = tmp_path / "first.csv", tmp_path / "second.csv"
    write(first, 300.0, seed=1)
    second.write_bytes(first.read_bytes())
    row = tp.row(first, "compare", **QUESTION)
    assert tp.row(second, "compare", **QUESTION)["key"] == row["key"]
    assert tp.row(first, "compare", **QUESTION, lowpass=100.0)["key"] != row["key"]
    assert tp.row(first, "estimate", **QUESTION)["key"] != row["key"]
    write(second, 300.0, seed=2)
    assert tp.row(second, "compare", **QUESTION)["key"] != row["key"]


def test_a_keyword_that_the_task_does_not_take_is_refused(laboratory):
    with pytest.raises(tp.TissueProbeError, match="estimate takes no `tissue`; it takes estimator"):
        tp.row(laboratory / "a_1.csv", tissue="hertz")
