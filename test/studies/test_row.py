"""One recording is one row of numbers and texts, whatever becomes of it."""

from __future__ import annotations

import json
import pickle
import subprocess
import sys

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


#: A process without threads, which may make a copy of itself.
DIAGNOSED = """
import json, os, sys
import tissue_probe as tp
before = os.times().children_user
row = tp.row(sys.argv[1], "diagnose", **json.loads(sys.argv[2]))
print(json.dumps([os.times().children_user - before, row]))
"""


@pytest.mark.whole_library
def test_a_diagnosis_in_one_process_gives_verdict_and_probabilities(laboratory):
    call = [sys.executable, "-c", DIAGNOSED, str(laboratory / "c_1.csv"), json.dumps(QUESTION)]
    said = subprocess.run(call, capture_output=True, text=True, check=True, timeout=300).stdout
    elsewhere, row = json.loads(said)
    assert elsewhere == 0.0  # seconds of a copy of the process: other rows are computed beside it
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
