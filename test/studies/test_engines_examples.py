"""Each example of another engine, run as it says, gives the rows that the study gives."""

from __future__ import annotations

import importlib.util
import os
import shutil
import socket
import subprocess
import sys
import tempfile
from pathlib import Path

import pandas as pd
import pytest
from test_study import plan_of

import tissue_probe as tp

EXAMPLES = Path(__file__).parents[2] / "examples" / "engines"


def needs(package: str) -> pytest.MarkDecorator:
    absent = importlib.util.find_spec(package) is None
    return pytest.mark.skipif(absent, reason=f"pip install {package}")


def run(*command: str, folder: Path, **variables: str) -> None:
    # A program started elsewhere finds the package by the path of this one.
    paths = os.pathsep.join(each for each in sys.path if each)
    environment = os.environ | {"PYTHONPATH": paths} | variables
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


@pytest.fixture
def database(tmp_path):
    """A PostgreSQL server of this test's own; it runs as no root."""
    if shutil.which("initdb") is None or not hasattr(os, "geteuid"):
        pytest.skip("there is no PostgreSQL: apt-get install postgresql")
    home = Path(tempfile.mkdtemp(dir="/tmp"))  # the path of its socket has 107 letters at most
    user = {"user": "nobody"} if os.geteuid() == 0 else {}
    if user:
        shutil.chown(home, "nobody")
    data, port = home / "data", free_port()
    shared = {"check": True, "capture_output": True, "cwd": home, **user}
    control = ["pg_ctl", "-D", str(data), "-w"]
    subprocess.run(["initdb", "-D", str(data), "-U", "probe", "-A", "trust"], **shared)
    options = ["-o", f"-p {port} -k {home}", "-l", str(home / "log"), "start"]
    subprocess.run([*control, *options], **shared)
    yield {"DJ_HOST": "127.0.0.1", "DJ_PORT": str(port), "DJ_USER": "probe", "DJ_PASS": "none",
           "DJ_BACKEND": "postgresql"}  # fmt: skip
    subprocess.run([*control, "-m", "immediate", "stop"], **shared)
    shutil.rmtree(home, ignore_errors=True)


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


@needs("datajoint")
@needs("psycopg2")
def test_datajoint_answers_each_recording_once(laboratory, tmp_path, database):
    paths = sorted(map(str, laboratory.glob("*.csv")))
    script = str(EXAMPLES / "with_datajoint.py")
    for _ in range(2):
        run(sys.executable, script, *paths, folder=tmp_path, **database)
    import psycopg2

    with psycopg2.connect(host="127.0.0.1", port=database["DJ_PORT"], user="probe",
                          dbname="postgres") as found:  # fmt: skip
        cursor = found.cursor()
        cursor.execute("SELECT path, status FROM palpation.__answer ORDER BY path")
        assert cursor.fetchall() == [(path, "done") for path in paths]


@needs("snakemake")
@pytest.mark.timeout(600)
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
