"""Model files with effects of the user's own: their code runs where it is named, and only there."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from tissue_probe.physics.composition import Composition
from tissue_probe.physics.library import load_effects
from tissue_probe.physics.model_file import save

EXAMPLE = Path(__file__).parents[2] / "docs" / "my_effect.py"


@pytest.fixture
def own(tmp_path) -> Path:
    """A model.yaml with an effect whose Python file, own.py, tells when it was run."""
    file, ran = tmp_path / "own.py", tmp_path / "ran"
    file.write_text(EXAMPLE.read_text())
    composition = Composition(effects=load_effects(file))
    values = {entry.name: entry.default for entry in composition.values} | {"stiffness": 450.0}
    save(tmp_path / "model.yaml", composition, values, {}, effect_files=[file])
    file.write_text(f"open({str(ran)!r}, 'w')\n{file.read_text()}")
    return ran


def recorded(model: Path) -> dict[str, dict[str, str]]:
    """What a live estimator on this model tells of itself in its recording."""
    own = [str(model.parent / "own.py")]
    told = {"estimator": "robust_ekf", "model": str(model), "effects": own}
    return {"/probe/robust_ekf": {name: yaml.safe_dump(value) for name, value in told.items()}}


STATED = ("--force-polarity", "compression")
REFUSED = {
    "estimate": ("estimate", "measured.csv", "-e", "robust_ekf", "--model", "model.yaml"),
    "compare": ("compare", "measured.csv", "--model", "model.yaml"),
    "diagnose": ("diagnose", "measured.csv", "--model", "model.yaml"),
    "improve": ("improve", "measured.csv", "--model", "model.yaml"),
    "a recorded setting": ("estimate", "run.mcap", "-e", "robust_ekf"),
    "a recorded setting, for a map": ("map", "run.mcap", "-e", "robust_ekf"),
}


@pytest.mark.parametrize("how", REFUSED)
def test_no_command_runs_code_that_a_model_file_or_a_recording_names(
    fails, csv, bag, own, tmp_path, how
):
    csv()
    bag(metadata=recorded(tmp_path / "model.yaml"))
    told = fails(*REFUSED[how], *(STATED if "measured.csv" in REFUSED[how] else ()))
    assert not own.exists()
    assert "model.yaml needs the effect 'quadratic_drag'" in told
    assert "the Python file" in told
    assert "own.py" in told
    assert told.endswith("name it by --effects\n")


@pytest.mark.slow
def test_every_command_takes_the_file_that_the_user_names(run, csv, bag, own, tmp_path):
    csv()
    bag(metadata=recorded(tmp_path / "model.yaml"))
    named = ("--effects", "own.py")
    for how in ("estimate", "a recorded setting", "a recorded setting, for a map"):
        outcome = run(*REFUSED[how], *named)
        assert outcome.status == 0, outcome.err
        assert own.exists()
        own.unlink()
    outcome = run(*REFUSED["compare"], *STATED, *named)
    assert outcome.status == 0, outcome.err
    assert "quadratic_drag" in outcome.out


ENDS = {
    "an exit": ("raise SystemExit", "SystemExit"),
    "an exit with status 0": ("import sys\nsys.exit(0)", "SystemExit: 0"),
    "an error": ("1 / 0", "ZeroDivisionError: division by zero"),
}


@pytest.mark.parametrize("how", ENDS)
@pytest.mark.parametrize("command", ["estimate", "compare"])
def test_a_file_of_effects_that_ends_the_program_is_told_by_name(
    fails, csv, own, tmp_path, command, how
):
    csv()
    code, word = ENDS[how]
    (tmp_path / "own.py").write_text(code)
    told = fails(*REFUSED[command], *STATED, "--effects", "own.py")
    assert f"own.py cannot be run: {word}" in told


UNUSABLE = {
    "a syntax error": ("def (", "SyntaxError"),
    "an import of what is not there": ("import no_such_module", "No module named"),
    "no effect": ("", "defines no effect"),
    "no file": (None, "there is no such file of effects"),
}


@pytest.mark.parametrize("how", UNUSABLE)
@pytest.mark.parametrize("command", ["compare", "diagnose"])
def test_an_unusable_file_of_effects_is_told_where_no_model_file_is_given(
    fails, csv, tmp_path, command, how
):
    csv()
    code, word = UNUSABLE[how]
    if code is not None:
        (tmp_path / "mine.py").write_text(code)
    told = fails(command, "measured.csv", *STATED, "--effects", "mine.py")
    assert "mine.py" in told
    assert word in told
    assert not (tmp_path / "compare.png").exists()


def test_effects_without_a_model_that_needs_them_are_refused_by_a_filter(fails, csv, own):
    csv()
    told = fails("estimate", "measured.csv", *STATED, "--effects", "own.py")
    assert "--effects is for effects that a model file needs: give --model" in told


def test_the_file_cannot_be_named_as_a_setting(fails, csv, own):
    csv()
    told = fails(*REFUSED["estimate"], "--set", "effects=own.py")
    assert told.endswith("name the Python file by --effects\n")
    assert not own.exists()
