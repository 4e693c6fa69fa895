"""The commands and the Python of README and of its pages, run on the examples that they name."""

import re
import shlex
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from tissue_probe import cli

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
README = (ROOT / "README.md").read_text(encoding="utf-8")
PYTHON = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")

pytestmark = pytest.mark.timeout(600)


def blocks(text: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.M | re.S)


def commands() -> list[str]:
    lines = "".join(blocks(README, "sh")).splitlines()
    return [line for line in lines if line.startswith("tissue_probe ")]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder with the examples beside, where commands run."""
    shutil.copytree(EXAMPLES, tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(line: str, monkeypatch, capsys) -> str:
    monkeypatch.setattr(sys, "argv", shlex.split(line))
    status: object = 0
    try:
        cli.main()
    except SystemExit as ended:
        status = ended.code
    assert not status
    return capsys.readouterr().out


def test_the_commands_of_the_readme_find_the_hidden_effect(folder, monkeypatch, capsys):
    compare, diagnose, improve = commands()
    assert "Where it fails" in run(compare, monkeypatch, capsys)
    assert "Missing: hertz_contact (probability " in run(diagnose, monkeypatch, capsys)
    assert "Missing: hertz_contact (probability " in run(improve, monkeypatch, capsys)
    assert (folder / "improved" / "report.html").exists()


def test_the_python_of_readme_and_pages_runs(folder, capsys):
    (snippet,) = blocks(README, "python")
    names: dict[str, object] = {}
    exec(compile(snippet, "README.md", "exec"), names)
    assert capsys.readouterr().out == "missing ('hertz_contact',)\n"
    names["diagnosis"].model.save("model.yaml")
    for snippet in blocks(PYTHON, "python"):
        exec(compile(snippet, "docs/python.md", "exec"), {})
    error, noise = map(float, capsys.readouterr().out.splitlines()[-1].split())
    assert error == pytest.approx(noise, rel=0.1)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        (
            "diagnose examples/cyclic.csv --rig compliant_probe --force-polarity compression "
            "--starts at-rest",
            "Missing: ",
        ),
        (
            "compare examples/testing_machine.csv --rig compliant_probe --force-polarity tension",
            "decimal commas",
        ),
        ("map examples/scan.mcap --estimator robust_ekf", "16 of 16 sites measured"),
        (
            "calibrate force 0=examples/weight_0.csv 0.1=examples/weight_0.1.csv "
            "0.2=examples/weight_0.2.csv 0.5=examples/weight_0.5.csv",
            "force_per_volt = ",
        ),
    ],
)
def test_each_example_serves_its_command(line, told, folder, monkeypatch, capsys):
    assert told in run(f"tissue_probe {line}", monkeypatch, capsys)


def test_the_examples_are_those_that_their_script_makes(tmp_path):
    from examples.make import write_pair, write_weights

    write_pair(tmp_path)
    write_weights(tmp_path)
    made = sorted(tmp_path.iterdir())
    assert len(made) == 6
    for path in made:
        kept = np.loadtxt(EXAMPLES / path.name, delimiter=",", skiprows=1)
        np.testing.assert_allclose(
            np.loadtxt(path, delimiter=",", skiprows=1), kept, rtol=0.0, atol=2e-5
        )
