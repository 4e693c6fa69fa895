"""Files of any kind become segments that can be fitted; the options say what they hold."""

import os
from pathlib import Path

import numpy as np
import pytest
import typer
from numpy.testing import assert_allclose
from typer.testing import CliRunner

from tissue_probe.analysis.measurements import read
from tissue_probe.analysis.segments import segments
from tissue_probe.cli import measurement_options
from tissue_probe.cli.groups import add_groups
from tissue_probe.cli.question_options import Asked
from tissue_probe.diagnosis.inspection.inspection import inspect
from tissue_probe.quantities import FORCE

PERIOD = 5e-4


@pytest.fixture
def options():
    """Run a command with the shared options on a command line; return what it read."""
    found = []
    app = typer.Typer()

    @app.command()
    @add_groups
    def command(
        measurements: measurement_options.Measurements,
        signals: measurement_options.Signals,
        asked: Asked,
    ):
        said = asked.keywords()
        read = measurement_options.read(measurements, signals.layout())
        found.extend(segments(read, said["starts"], said.get("site")))

    def run(*arguments):
        CliRunner().invoke(app, [str(each) for each in arguments], catch_exceptions=False)
        return found

    return run


def test_the_command_line_of_the_documents_reads_a_csv_file(csv, options):
    compression, tension = csv(), csv("other.csv", sign=-1.0)
    named = ("--position", "u", "--force", "F", "--starts", "at-rest")
    options(compression, *named)
    first, second = options(tension, *named, "--force-polarity", "tension")
    assert_allclose(first.force, second.force)
    assert first.sample_period == pytest.approx(PERIOD)
    assert (first.starts, first.notes) == ("at-rest", ())


def test_units_and_rate_come_from_the_command_line(tmp_path, options):
    wave = np.sin(np.arange(400) / 10.0)
    np.savetxt(
        tmp_path / "x.csv", np.column_stack([wave, wave]), delimiter=",", header="x,f", comments=""
    )
    named = ("--position", "x", "--force", "f", "--force-polarity", "compression")
    units = ("--position-unit", "mm", "--force-unit", "35.15", "--sample-rate", "1000")
    (segment,) = options(tmp_path / "x.csv", *named, *units, "--position-polarity", "out")
    assert_allclose(segment.position, -1e-3 * wave)
    assert_allclose(segment.force, 35.15 * wave)
    assert segment.sample_period == 1e-3


def test_a_bag_and_its_export_say_the_same(bag, run, options):
    path = bag()
    run("export", path, "--output", "samples.csv")
    (from_bag,) = options(path, "--site", "5")
    _, table = options("samples.csv", "--site", "5")  # both that were read so far
    assert_allclose(from_bag.position, table.position, rtol=1e-15)
    assert_allclose(from_bag.force, table.force, rtol=1e-15)


def test_the_site_of_a_scan_is_asked_for(bag, run, options):
    path = bag()
    run("export", path, "--output", "samples.csv")
    for file in (path, "samples.csv"):
        with pytest.raises(ValueError, match=r"palpates 16 sites, .* choose one with `site`"):
            options(file)


def test_gaps_make_segments_and_only_the_first_is_at_rest(csv, tmp_path, options):
    lines = csv().read_text().splitlines()
    gapped = tmp_path / "gapped.csv"
    gapped.write_text("\n".join([*lines[:1001], *lines[1501:1511], *lines[2501:], ""]))
    first, second = options(gapped, "--starts", "at-rest")
    assert [segment.position.size for segment in (first, second)] == [1000, 1500]
    assert [segment.starts for segment in (first, second)] == ["at-rest", "moving"]
    assert [segment.source for segment in (first, second)] == [
        f"{gapped}, part 1",
        f"{gapped}, part 2",
    ]
    assert "2 gaps" in first.notes[0]
    assert "1 piece between gaps is too short" in first.notes[1]
    assert second.notes == ()
    # Both on one clock: each row is 0.5 ms after the one before.
    assert first.run == second.run == str(gapped)
    assert (first.begins, second.begins) == (0.0, pytest.approx(2500 * 5e-4, abs=1e-9))


def test_holes_are_filled_and_it_is_said(csv, options):
    path = csv()
    lines = path.read_text().splitlines()
    time, position, _ = lines[100].split(",")
    lines[100] = f"{time},{position},"
    path.write_text("\n".join([*lines, ""]))
    (segment,) = options(path)
    assert np.isfinite(segment.force).all()
    assert "1 samples of the even grid lie in gaps: filled in" in segment.notes[0]


def test_what_is_filled_in_does_not_count_as_measured(csv, options):
    path = csv()
    lines = path.read_text().splitlines()
    time, position, _ = lines[100].split(",")
    lines[100] = f"{time},{position},"
    lines[200:203] = [f"{row.split(',')[0]},,{row.split(',')[2]}" for row in lines[200:203]]
    path.write_text("\n".join([*lines, ""]))
    (segment,) = options(path)
    assert list(np.flatnonzero(~segment.measured)) == [99, 199, 200, 201]
    assert segment.position[99] == float(position)
    fitted = segment.measurement(FORCE)
    assert not fitted.used[[99, 199, 200, 201]].any()
    assert np.count_nonzero(fitted.used) == 3996
    assert (
        "4 samples of the even grid lie in gaps: filled in by a cubic spline, and left out"
        in segment.notes[0]
    )


def test_missing_rows_are_filled_in_as_missing_values_are(csv, options):
    path = csv()
    (whole,) = options(path)
    lines = path.read_text().splitlines()
    lost = [50, 51, 52, *range(200, 3900, 40)]
    path.write_text("\n".join([*(line for n, line in enumerate(lines) if n - 1 not in lost), ""]))
    segment = options(path)[1]
    assert list(np.flatnonzero(~segment.measured)) == lost
    assert_allclose(segment.force[segment.measured], whole.force[segment.measured])
    assert_allclose(segment.position, whole.position, atol=2e-7)
    assert segment.notes == (
        f"{path}: {len(lost)} samples of the even grid lie in gaps: filled in by a cubic spline, "
        "and left out of the fit",
    )


def test_longer_runs_of_missing_values_are_cut_out_and_it_is_said(csv, options):
    path = csv()
    lines = path.read_text().splitlines()
    for first, stop in ((501, 511), (2001, 2101)):
        lines[first:stop] = [f"{row.split(',')[0]},," for row in lines[first:stop]]
    path.write_text("\n".join([*lines, ""]))
    pieces = options(path)
    assert [segment.position.size for segment in pieces] == [500, 1490, 1900]
    (note,) = pieces[0].notes
    assert "110 samples in 2 runs are not known, 100 of them 1 s after the first sample" in note


def test_what_remains_between_gaps_is_told(csv, options):
    path = csv()
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:1001], *lines[1501:1511], *lines[2501:], ""]))
    note = options(path)[0].notes[1]
    assert "1 piece between gaps is too short to be used; 2500 of 2510 samples remain" in note


def test_what_is_filled_in_stays_unmeasured_behind_a_low_pass(csv):
    path = csv()
    lines = path.read_text().splitlines()
    lines[104:107] = [f"{row.split(',')[0]},," for row in lines[104:107]]
    path.write_text("\n".join([*lines, ""]))
    every = 8  # of 2 kHz, 2.5 samples a cycle of 100 Hz
    (segment,) = segments(read(path), lowpass=100.0)
    assert segment.force.size == 4000 // every
    assert list(np.flatnonzero(~segment.measured)) == [104 // every]


def test_nothing_known_is_refused(tmp_path, options):
    (tmp_path / "x.csv").write_text("t,u,F\n0.0,1,\n1.0,,1\n2.0,1,\n")
    with pytest.raises(ValueError, match="no sample whose position and force are both known"):
        options(tmp_path / "x.csv")


def test_fewer_samples_than_tell_anything_are_refused_with_how_many_do(fails, csv, tmp_path):
    lines = csv().read_text().splitlines()
    (tmp_path / "short.csv").write_text("\n".join(lines[:64]) + "\n")
    for command in ("compare", "diagnose", "estimate"):
        told = fails(command, "short.csv", "--force-polarity", "compression")
        assert "short.csv has 63 samples without a gap" in told
        assert "give at least 64" in told


@pytest.fixture
def foreign():
    """The folder of measured data that others made; it is not part of the repository."""
    beside = Path(__file__).parents[2].parent / "shared" / "data"
    folder = Path(os.environ.get("TISSUE_PROBE_SHARED_DATA", beside))
    if not (folder / "emps").is_dir():
        pytest.skip("no measured data: set TISSUE_PROBE_SHARED_DATA to their folder")
    return folder


def test_volts_of_a_positioning_system_are_read_in_newtons(foreign, options):
    named = (
        "--position",
        "qm",
        "--position-unit",
        "m",
        "--force",
        "vir",
        "--force-unit",
        "35.1507",
    )
    path = foreign / "emps" / "DATA_EMPS.mat"
    (segment,) = options(path, *named, "--force-polarity", "compression")
    assert segment.sample_period == pytest.approx(1e-3)
    assert segment.position.size == 24841
    assert 100.0 < segment.force.max() < 351.507
    assert not inspect(segment.position, segment.force, segment.sample_period).findings


def test_a_tensile_test_is_read_in_the_units_its_columns_name(foreign, options):
    path = foreign / "vhb4910_elastomer" / "cyc_0d01_2d0.csv"
    (segment,) = options(path, "--position", "disp_mm", "--force-polarity", "compression")
    assert segment.sample_period == pytest.approx(0.02)
    assert 0.079 < segment.position.max() < 0.081
    assert "resampled by a cubic spline at 50 Hz" in segment.notes[0]


def test_probing_in_steps_is_read_by_its_number_of_steps(foreign, options):
    path = foreign / "pig_liver_probing" / "pig_liver_20150826_region1.csv"
    named = ("--position", "depth_mm", "--force", "fn_N", "--force-polarity", "compression")
    (segment,) = options(path, *named, "--sample-rate", "10")
    assert 1e-3 < segment.position.max() < 3e-3
    assert segment.force.max() < 1.0
