"""Every command reads the same files by the same options."""

import inspect

import numpy as np
import pytest
from pyarrow import csv as arrow_csv

from tissue_probe.cli.compare import compare
from tissue_probe.cli.diagnose import diagnose
from tissue_probe.cli.estimate import estimate
from tissue_probe.cli.export import export
from tissue_probe.cli.improve import improve
from tissue_probe.cli.map import map_command

OPTIONS = (
    "position", "force", "time", "sample_rate", "position_unit", "force_unit", "time_unit",
    "force_polarity", "position_polarity", "topic", "clock", "adapter",
)  # fmt: skip


@pytest.mark.parametrize("command", [compare, diagnose, estimate, export, improve, map_command])
def test_every_command_takes_the_same_options_on_files(command):
    taken = inspect.signature(command).parameters
    reference = inspect.signature(compare).parameters
    assert {name: taken[name].annotation for name in OPTIONS} == {
        name: reference[name].annotation for name in OPTIONS
    }


@pytest.fixture
def machine(csv, tmp_path):
    """The same measurement as a testing machine writes it, and as this suite does."""
    own = csv()
    rows = [line.split(",") for line in own.read_text().splitlines()[1:]]
    lines = ["Operator;Smith", "", "Time;Extension;Load", "s;mm;N"]
    for t, u, f in rows:
        cells = (t, f"{1e3 * float(u):.17g}", f)
        lines.append(";".join(cells).replace(".", ","))
    path = tmp_path / "machine.txt"
    path.write_text("\n".join([*lines, ""]))
    return own, path


def test_estimate_reads_what_a_testing_machine_writes(run, machine):
    own, foreign = machine
    run("estimate", own, "-o", "own.csv")
    outcome = run("estimate", foreign, "-o", "foreign.csv", "--force-polarity", "compression")
    assert outcome.status == 0, outcome.err
    assert "semicolons, decimal commas; 2 lines of preamble; units from the row" in outcome.out
    found, expected = (arrow_csv.read_csv(f"{name}.csv") for name in ("foreign", "own"))
    np.testing.assert_allclose(found["stiffness"], expected["stiffness"], rtol=1e-9)


def test_export_makes_a_table_that_needs_no_option(run, machine):
    own, foreign = machine
    run("export", foreign, "-o", "exported.csv", "--force-polarity", "compression")
    run("estimate", own, "-o", "own.csv")
    outcome = run("estimate", "exported.csv", "-o", "again.csv")
    assert outcome.status == 0, outcome.err
    found, expected = (arrow_csv.read_csv(f"{name}.csv") for name in ("again", "own"))
    np.testing.assert_allclose(found["stiffness"], expected["stiffness"], rtol=1e-9)


def test_what_must_be_stated_is_named_as_an_option(fails, machine):
    _, foreign = machine
    assert "state --force-polarity (compression or tension" in fails("estimate", foreign)


def test_info_tells_the_columns_of_a_table(run, machine):
    _, foreign = machine
    told = run("info", foreign).out
    assert "semicolons, decimal commas; 2 lines of preamble" in told
    assert [name in told for name in ("Time", "Extension", "Load", "mm", "4000")] == [True] * 5


def test_a_scan_is_mapped_from_its_exported_table(run, bag):
    path = bag()
    run("export", path, "-o", "samples.csv")
    run("map", path, "--estimator", "lock_in", "-o", "bag.png")
    outcome = run("map", "samples.csv", "--estimator", "lock_in", "-o", "table.png")
    assert outcome.status == 0, outcome.err
    assert "16 of 16 sites measured" in outcome.out


def test_a_rejected_model_names_the_command_that_tells_more(run, csv):
    path = csv(seconds=0.5)
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    rows[:, 2] += 0.4 * np.sign(np.gradient(rows[:, 1]))  # dry friction
    np.savetxt(path, rows, delimiter=",", header="t,u,F", comments="", fmt="%.17g")
    outcome = run("estimate", path)
    assert "model_rejected" in outcome.out
    assert f"Why, tells: tissue_probe diagnose {path}" in outcome.out


def test_info_takes_the_options_of_the_other_commands(run, fails, tmp_path):
    rows = "\n".join(f"{1e-3 * n:.3f},{n % 50},{n % 7}" for n in range(300))
    (tmp_path / "x.csv").write_text(f"zeit (s),weg,kraft\n{rows}\n")
    units = ("--position-unit", "um", "--force-unit", "mN")
    assert "--force-polarity" in fails("info", "x.csv", *units)
    outcome = run("info", "x.csv", *units, "--force-polarity", "tension")
    assert outcome.status == 0, outcome.err
    assert "Position and force: 300 samples at 1000 Hz" in outcome.out
