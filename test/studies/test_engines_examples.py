"""Each example of another engine, run as it says, gives the rows that the study gives."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
from test_study import plan_of

import tissue_probe as tp

EXAMPLES = Path(__file__).parents[2] / "examples" / "engines"


def needs(package: str) -> pytest.MarkDecorator:
    absent = importlib.util.find_spec(package) is None
    return pytest.mark.skipif(absent, reason=f"pip install {package}")


def run(*command: str, folder: Path) -> None:
    # A program started elsewhere finds the package by the path of this one.
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(each for each in sys.path if each)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_no_example_is_longer_than_25_lines():
    for path in EXAMPLES.iterdir():
        if path.is_file():
            assert len(path.read_text().splitlines()) <= 25, path.name


@pytest.mark.parametrize(
    "name", ["with_joblib.py", pytest.param("with_dask.py", marks=needs("distributed"))]
)
def test_an_engine_gives_a_row_a_recording(name, laboratory, tmp_path):
    run(sys.executable, str(EXAMPLES / name), "data/*.csv", "rows.csv", folder=tmp_path)
    assert list(pd.read_csv(tmp_path / "rows.csv")["status"]) == 6 * ["done"]


@needs("snakemake")
def test_snakemake_gives_a_row_a_recording(laboratory, tmp_path):
    shutil.copy(EXAMPLES / "Snakefile", tmp_path)
    command = (sys.executable, "-m", "snakemake", "--cores", "2", "--config", "recordings=data")
    run(*command, folder=tmp_path)
    assert list(pd.read_csv(tmp_path / "rows.csv")["status"]) == 6 * ["done"]


@pytest.mark.parametrize(
    ("name", "rows"),
    [
        ("with_pandas.py", "table.parquet"),
        pytest.param("with_duckdb.py", "rows", marks=needs("duckdb")),
    ],
)
def test_a_program_reads_the_rows_of_a_study(name, rows, laboratory, tmp_path):
    tp.study(plan_of(laboratory), workers=1)
    run(sys.executable, str(EXAMPLES / name), f"answers/{rows}", "found.csv", folder=tmp_path)
    found = pd.read_csv(tmp_path / "found.csv").set_index("specimen")
    assert found["mean"].to_dict() == pytest.approx({"a": 300.0, "b": 400.0, "c": 500.0}, rel=0.01)
    assert list(found["count"]) == 3 * [2]
