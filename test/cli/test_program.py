"""The program as a newcomer meets it: its help, its errors, its completion."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import pytest

import tissue_probe as tp
from tissue_probe import __version__
from tissue_probe.estimation import ESTIMATORS, EstimatorSettings

COMMANDS = [
    *("demo", "estimate", "estimators", "map", "info", "export", "excitation", "reproduce"),
    *("compare", "diagnose", "improve", "effects", "sensor", "contact", "admittance", "mujoco"),
    *("joint", "modulus", "workbench"),
    *("challenge", "calibrate", "study"),
]

DIAGNOSING = ("compare", "diagnose", "improve")
MODEL_DEFAULTS = [
    *("into", "auto", "auto"),
    "(that of --model; compliant_probe in recordings of this suite)",
    "(that of --model, else kelvin_voigt)",
]


def in_a_process(*arguments, **environment):
    """Run the program as a user does: in its own process."""
    entry = "from tissue_probe.cli import main; main()"
    return subprocess.run(
        [sys.executable, "-c", entry, *arguments],
        env={**os.environ, "COLUMNS": "80", **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


def test_the_overview_names_every_command_with_a_whole_sentence(run):
    for arguments in (["--help"], ["-h"]):
        outcome = run(*arguments)
        assert outcome.status == 0
        listed = outcome.out.partition("Commands:\n")[2]
        assert re.findall(r"^  (\S+) +\S.*\.$", listed, re.MULTILINE) == COMMANDS
        assert "..." not in listed


@pytest.mark.parametrize(
    "command", [*COMMANDS, *(f"challenge {name}" for name in ("make", "grade"))]
)
def test_every_help_fits_80_columns_and_says_what_the_command_does(run, command):
    for option in ("--help", "-h"):
        outcome = run(*command.split(), option)
        assert outcome.status == 0
        assert outcome.err == ""
        usage, _, what, *_ = outcome.out.splitlines()
        assert usage.startswith(f"Usage: tissue_probe {command} ")
        assert re.fullmatch(r"  [A-Z].*\.", what)
        assert max(map(len, outcome.out.splitlines())) <= 80


@pytest.mark.parametrize(
    ("command", "units"),
    [
        ("estimate", ["time [s]", "(u_mm", "(F_mN", "SI units", "[N/m]", "[N s/m]"]),
        ("export", ["time [s]", "position [m]", "force [N]", "[V]"]),
        ("map", ["[m]", "[N/m]", "[s]", "[mm]"]),
        ("demo", ["[s]"]),
        ("info", ["[s]"]),
        ("excitation", ["[m]", "[Hz]", "[s]", "[N/m]", "[N s/m]", "[N]"]),
        ("reproduce", ["[N/m]", "[N s/m]", "[N]"]),
        *((command, ["[s]", "(u_mm", "(F_mN", "SI units"]) for command in DIAGNOSING),
    ],
)
def test_the_help_shows_units(run, command, units):
    said = " ".join(run(command, "--help").out.split())
    for unit in units:
        assert unit in said


@pytest.mark.parametrize(
    ("command", "defaults"),
    [
        (
            "estimate",
            [
                *("estimates.csv", "ekf", "into", "as recorded, else yes"),
                "(the recording's own, else Kelvin-Voigt tissue)",
                "(the recording's own, else compliant_probe)",
            ],
        ),
        ("export", ["samples.csv", "into"]),
        (
            "map",
            [
                *("map.png", "the recorded estimates", "into", "0.5", "1.5", "0; x>=0"),
                *("both", "0.0"),
                "(the recording's own, else compliant_probe)",
            ],
        ),
        ("demo", [".", "1.0; 0.05<=x<=60.0", "three nodules in soft tissue"]),
        (
            "excitation",
            [
                *("sine", "0.001", "10", "1", "30", "10", "10", "1", "excitation.png"),
                *("450.0; 0.001<=x<=1000000.0", "5.0; 1e-06<=x<=10000.0"),
                *("1.0; 0.01<=x<=60.0", "0.005; 1e-09<=x<=100.0", "force-offset"),
            ],
        ),
        ("reproduce", ["all", "reproduction"]),
        ("compare", [*MODEL_DEFAULTS, "compare.png"]),
        ("diagnose", MODEL_DEFAULTS),
        ("improve", [*MODEL_DEFAULTS, "improved"]),
    ],
)
def test_the_help_shows_defaults(run, command, defaults):
    said = " ".join(run(command, "--help").out.split())
    assert sorted(re.findall(r"\[default: (.*?)\]", said)) == sorted(defaults)


def test_the_help_of_estimate_says_from_where_time_counts(run):
    said = " ".join(run("estimate", "--help").out.split())
    assert "Time counts from the first sample of a recording, or from a table's own zero." in said


def test_the_version_is_printed(run):
    assert run("--version").out == f"tissue_probe {__version__}\n"


def test_without_a_command_the_help_is_shown(run):
    outcome = run()
    assert outcome.status == 2
    assert "Commands:" in outcome.out + outcome.err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["palpate"], "No such command 'palpate'"),
        (["estimate"], "Missing argument 'SAMPLES'"),
        (["estimate", "x.csv", "--frce", "F"], "No such option: --frce"),
        (["estimate", "x.csv", "--force-polarity", "pull"], "'pull' is not one of 'compression', "),
        (["demo", "--dwell-time", "0"], "Invalid value for '--dwell-time'"),
        (["demo", "--dwell-time", "long"], "Invalid value for '--dwell-time'"),
    ],
)
def test_wrong_usage_is_told_with_status_2(run, arguments, said):
    outcome = run(*arguments)
    assert outcome.status == 2
    assert said in outcome.err
    assert "Traceback" not in outcome.err


def test_effects_lists_each_with_its_meaning_in_one_line(run):
    outcome = run("effects")
    assert outcome.status == 0
    lines = [line.split(maxsplit=1) for line in outcome.out.splitlines() if line.startswith("  ")]
    told = dict(lines)
    fluid = told["poroelastic_relaxation"]
    assert fluid.endswith(" (tried only with --prior poroelastic_relaxation=1 or --add)")
    told["poroelastic_relaxation"] = fluid.partition(" (tried only")[0]
    assert told == {each["name"]: each["physics"] for each in tp.effects()}


def test_estimators_lists_every_filter_and_setting_with_default_unit_and_meaning(run):
    outcome = run("estimators")
    assert outcome.status == 0
    assert outcome.out.splitlines()[0] == "Estimators: " + ", ".join(ESTIMATORS)
    rows = []
    for line in outcome.out.splitlines():
        cells = [cell.strip() for cell in line.strip("│").split("│")]
        if len(cells) == 4 and cells[0]:
            rows.append(cells)
        elif len(cells) == 4:  # the row goes on
            rows[-1] = [
                f"{cell} {more}".strip() for cell, more in zip(rows[-1], cells, strict=True)
            ]
    assert [row[0] for row in rows] == list(EstimatorSettings.model_fields)
    for (_, default, takes, meaning), field in zip(
        rows, EstimatorSettings.model_fields.values(), strict=True
    ):
        assert default == str(field.default)
        assert meaning == field.description
        unit = (field.json_schema_extra or {}).get("unit")
        assert not unit or takes.endswith(f"[{unit}]")
    assert max(map(len, outcome.out.splitlines())) <= 80


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_of_each_shell_is_a_script_that_calls_the_program(run, shell, monkeypatch):
    monkeypatch.setattr("shellingham.detect_shell", lambda: (shell, f"/bin/{shell}"))
    outcome = run("--show-completion")
    assert outcome.status == 0
    assert "_TISSUE_PROBE_COMPLETE" in outcome.out
    assert f"complete_{shell}" in outcome.out


def test_completion_offers_commands_and_options():
    def completed(words, at):
        return in_a_process(
            _TISSUE_PROBE_COMPLETE="complete_bash", COMP_WORDS=words, COMP_CWORD=str(at)
        ).stdout.split()

    assert completed("tissue_probe est", 1) == ["estimate", "estimators"]
    assert completed("tissue_probe estimate --force-p", 2) == ["--force-polarity"]


def test_an_error_of_the_program_itself_is_one_line_and_status_1(tmp_path):
    ended = in_a_process("info", str(tmp_path / "none.mcap"))
    assert ended.returncode == 1
    assert ended.stdout == ""
    assert ended.stderr == f"tissue_probe: {tmp_path / 'none.mcap'}: No such file or directory\n"


def test_an_error_is_one_line_whatever_the_name_of_the_file(fails):
    assert "two lines.mcap: No such file or directory" in fails("info", "two\nlines.mcap")


def test_help_does_not_load_what_only_commands_need():
    heavy = "numba", "scipy", "matplotlib", "pyarrow", "rclpy", "rosbags"
    ended = subprocess.run(
        [
            sys.executable,
            "-c",
            "import sys, tissue_probe.cli; "
            f"print([name for name in {heavy!r} if name in sys.modules])",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    assert ended.stdout == "[]\n"
