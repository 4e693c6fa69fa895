"""`tissue_probe study run`, as a user at a shell has it."""

from __future__ import annotations

import csv
import subprocess
import sys

import numpy as np
import pytest


@pytest.fixture
def plan(tmp_path):
    t = np.arange(1000) / 1000.0
    for number, stiffness in enumerate((300.0, 500.0)):
        u = 1e-3 * (1.0 - np.cos(30.0 * t))
        f = stiffness * u + 3.0 * np.gradient(u, t)
        f += 2e-3 * np.random.default_rng(number).standard_normal(t.size)
        np.savetxt(
            tmp_path / f"s{number}.csv", np.column_stack([t, u, f]), "%.9f", ",",
            header="t,u,F", comments="",
        )  # fmt: skip
    path = tmp_path / "study.yaml"
    path.write_text(
        "recordings: s*.csv\npattern: 's{specimen}.csv'\ntask: compare\n"
        "question: {rig: rigid_probe, force_polarity: compression}\noutput: answers\n"
    )
    return path


def run(*words):
    command = [sys.executable, "-m", "tissue_probe", "study", "run", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True)


def test_a_study_is_run_and_its_table_is_there(plan):
    done = run(plan, "--workers", 1)
    assert done.returncode == 0, done.stderr
    assert "2 recordings, 2 computed now: 2 done" in done.stdout
    with (plan.parent / "answers" / "table.csv").open(newline="") as table:  # notes have lines
        header, *rows = csv.reader(table)
    assert "specimen" in header
    assert len(rows) == 2
    assert "0 computed now" in run(plan).stdout


def test_a_plan_that_is_none_is_told_in_one_line(tmp_path):
    (tmp_path / "study.yaml").write_text("recordings: none/*.csv\n")
    done = run(tmp_path / "study.yaml")
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert "no file is named" in done.stderr
