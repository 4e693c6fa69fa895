"""``info``, ``export`` and ``map`` on a recorded scan whose tissue is known."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
import pytest
import yaml
from numpy.testing import assert_array_equal
from pyarrow import csv as arrow_csv
from pyarrow import parquet

from tissue_probe.recording.bags.reader import read_recording

PHANTOM = {
    "background_stiffness": 450.0,
    "background_damping": 5.0,
    "nodules": [
        {"x": 0.01, "y": 0.01, "depth": 0.0, "radius": 0.003, "stiffness_ratio": 2.5},
        {"x": 0.03, "y": 0.03, "depth": 0.02, "radius": 0.003, "stiffness_ratio": 2.0},
    ],
}


def described(phantom):
    """Return the driver's metadata as its recorder writes them: each value in YAML."""
    description = yaml.safe_dump({"phantom": phantom})
    return {"/probe/driver": {"device_description": yaml.safe_dump(description)}}


def rows(text):
    """Return the cells of a printed table, row by row."""
    lines = [line for line in text.splitlines() if line.startswith("│")]
    return [[cell.strip() for cell in line.strip("│").split("│")] for line in lines]


def test_info_counts_topics_samples_and_sites(run, bag):
    outcome = run("info", bag())
    assert outcome.status == 0
    assert re.search(r"run\.mcap: begins 2023-11-1\d \d\d:\d\d:\d\d, lasts 4\.800 s", outcome.out)
    assert "/probe/samples: 9600 samples, 0 lost\n" in outcome.out
    assert "16 sites palpated\n" in outcome.out
    topics = " ".join(" ".join(row) for row in rows(outcome.out))
    assert "960" in topics
    assert "tissue_probe_msgs/msg/ProbeSamples" in topics
    assert "cut off" not in outcome.out


def test_info_counts_lost_samples(run, bag):
    assert "/probe/samples: 9570 samples, 30 lost\n" in run("info", bag(lost=(3, 4, 100))).out


def test_info_shows_the_parameters_of_the_run_when_asked(run, bag):
    recorded = bag(metadata={"/probe/ekf": {"tip_mass": "0.04", "topics": "[a, b]"}})
    assert run("info", recorded).out.endswith(
        "Parameters of /probe/ekf; --parameters shows them.\n"
    )
    shown = run("info", recorded, "--parameters").out
    assert shown.endswith("\n/probe/ekf\n  tip_mass: 0.04\n  topics: [a, b]\n")


def test_info_says_that_a_recording_was_cut_off(run, bag):
    recorded = bag()
    recorded.write_bytes(recorded.read_bytes()[:-3000])
    outcome = run("info", recorded)
    assert outcome.status == 0
    assert "The recording was cut off; everything up to the cut is read.\n" in outcome.out


def test_info_shows_a_recording_of_others(run, tmp_path, messages, record):
    text = struct.pack("<4sd", b"\x00\x01\x00\x00", 1.5)
    long_name = "/left/arm/with/a/name/that/is/longer/than/a/column/can/be/at/eighty/columns/value"
    recorded = record(tmp_path / "other.mcap", [(long_name, messages.FLOAT, 10**9, text)])
    outcome = run("info", recorded)
    assert outcome.status == 0
    assert "".join(row[0] for row in rows(outcome.out)) == long_name  # folded, not cut
    assert "samples," not in outcome.out


@pytest.mark.parametrize("command", ["info", "export", "map"])
def test_a_file_that_is_no_recording_is_refused_in_one_line(fails, tmp_path, command):
    assert "none.mcap: No such file or directory" in fails(command, "none.mcap")
    (tmp_path / "text.mcap").write_text("hello")
    assert "text.mcap is not an MCAP file" in fails(command, "text.mcap")
    (tmp_path / "folder").mkdir()
    assert "folder without a bag" in fails(command, "folder")


def test_export_writes_every_sample_with_every_digit(run, bag):
    recorded = bag()
    outcome = run("export", recorded)
    assert (outcome.status, outcome.out) == (0, "9600 samples written to samples.csv\n")
    recording = read_recording(recorded)
    table = arrow_csv.read_csv("samples.csv")
    signals = ["time", "position", "force", "command", "sequence"]
    assert table.column_names == [*signals, "site", "site_x", "site_y", "site_z"]
    for name in ("position", "force", "command"):
        assert_array_equal(table[name], getattr(recording, name))
    assert_array_equal(table["sequence"], np.arange(9600))
    assert_array_equal(table["site"], np.repeat(np.arange(16), 600))
    assert table["time"][0].as_py() == 0.0
    assert table["time"][-1].as_py() == pytest.approx(9599 * 5e-4)


def test_exported_csv_and_parquet_hold_the_same(run, bag):
    recorded = bag()
    run("export", recorded, "-o", "out.csv")
    run("export", recorded, "-o", "out.parquet")
    table = parquet.read_table("out.parquet")
    assert arrow_csv.read_csv("out.csv").cast(table.schema).equals(table)


def test_exported_samples_are_estimated_as_the_recording_is(run, bag):
    recorded = bag(with_sites=False)
    run("export", recorded)
    run("estimate", recorded, "-o", "of_the_recording.csv")
    columns = ("--time", "time", "--position", "position", "--force", "force")
    run("estimate", "samples.csv", "-o", "of_the_table.csv", *columns)
    of_recording, of_table = (
        arrow_csv.read_csv(f"of_the_{name}.csv") for name in ("recording", "table")
    )
    for name in ("time", "stiffness", "damping"):
        assert of_table[name].to_numpy() == pytest.approx(of_recording[name].to_numpy(), rel=1e-6)


def test_export_refuses_a_table_of_another_kind(fails, bag, tmp_path):
    assert "samples.txt ends in '.txt'; tables are .csv or .parquet" in fails(
        "export", bag(), "-o", "samples.txt"
    )
    assert not (tmp_path / "samples.txt").exists()


@pytest.mark.drawn
def test_map_finds_the_stiff_site(run, bag, tmp_path):
    outcome = run("map", bag(), "--estimator", "ekf")
    assert outcome.status == 0
    found = re.match(r"16 of 16 sites measured; background ([\d.]+) ±", outcome.out)
    assert found
    assert float(found[1]) == pytest.approx(450.0, abs=5.0)
    ((number, place, probability, stiffness, ratio),) = rows(outcome.out)
    assert number == "1"
    assert [float(each) for each in place.split(",")] == pytest.approx([10.0, 10.0], abs=2.0)
    assert float(probability) > 0.9
    assert float(stiffness.split("±")[0]) == pytest.approx(1125.0, rel=0.1)
    assert float(ratio) == pytest.approx(2.5, rel=0.15)
    assert outcome.out.endswith("The map is in map.png.\n")
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")


def test_map_holds_what_it_finds_against_the_recorded_phantom(run, bag):
    outcome = run("map", bag(metadata=described(PHANTOM)), "-e", "ekf", "-e", "ukf")
    assert outcome.status == 0
    first, second = rows(outcome.out)[-2:]
    assert first[:2] == ["10.0, 10.0", "0"]
    assert second[0] == "30.0, 30.0"
    assert second[2] == "missed"
    assert "1 of 2 nodules found, 0 inclusions where there is no nodule\n" in outcome.out


@pytest.mark.parametrize("width", ["80", "72"])
def test_a_map_beside_its_phantom_keeps_its_numbers_in_a_narrow_window(
    run, bag, monkeypatch, width
):
    recorded = bag(metadata=described(PHANTOM))
    monkeypatch.setenv("COLUMNS", "200")
    wide = rows(run("map", recorded, "-e", "ekf").out)[-2]
    monkeypatch.setenv("COLUMNS", width)
    told = run("map", recorded, "-e", "ekf").out
    assert "…" not in told
    for number in " ".join(wide).split():
        assert number in told


def test_map_tells_the_truth_of_a_phantom_from_a_table_where_it_found_something(run, bag):
    table = {"x": [0.0, 0.02, 0.0], "y": [0.0, 0.0, 0.02], "k": [700.0, 700.0, 700.0]}
    outcome = run("map", bag(metadata=described(table)), "-e", "ekf", "-e", "ukf")
    assert outcome.status == 0
    assert rows(outcome.out)[0][-1] == "700.0"


@pytest.mark.parametrize(
    "description", ["a: b: c", "5", "'phantom: {}'", "", "'phantom: {nodules: soft}'"]
)
def test_map_does_without_a_phantom_that_is_not_known(run, bag, description):
    recorded = bag(metadata={"/rig": {"device_description": description}})
    outcome = run("map", recorded, "-e", "ekf")
    assert outcome.status == 0
    assert "nodule" not in outcome.out


def estimate_entries(messages, scan):
    """Yield what a live filter says at the end of each dwell, were it exact."""
    blocks, _ = scan
    for number in range(16):
        block = blocks[60 * (number + 1) - 1]
        stamp = int(block.stamps[-1])
        stiffness = 1125.0 if number == 5 else 450.0
        values = (stiffness, stiffness / 90, 1e-3, 1.0, 0.01, 0.0, 0.0, 0.1, 0.0, 1.0)
        for back in range(20, -1, -1):
            at = stamp - back * 5_000_000
            data = messages.estimate(at, block.sequence + 9 - 10 * back, "ekf", values, 1)
            yield "/probe/ekf/estimate", messages.ESTIMATE, at, data


@pytest.mark.drawn
def test_map_takes_the_recorded_estimates_unless_a_filter_is_named(run, bag, messages, scan):
    recorded = bag(more=sorted(estimate_entries(messages, scan), key=lambda entry: entry[2]))
    outcome = run("map", recorded, "-o", "map.svg")
    assert outcome.status == 0
    background = re.search(r"background ([\d.]+) ±", outcome.out)[1]
    assert float(background) == pytest.approx(450.0, abs=5.0)
    assert float(rows(outcome.out)[-1][3].split("±")[0]) == pytest.approx(1125.0, rel=0.1)


def test_map_of_a_recording_without_estimates_asks_for_a_filter(fails, bag):
    recorded = bag()
    told = fails("map", recorded)
    assert "run.mcap has no recorded estimates: give a filter by --estimator" in told
    told = fails("map", recorded, "--rig", "rigid_probe")
    assert "--effects and --rig are for filters that run on the samples" in told


def test_map_of_a_recording_without_sites_says_so(fails, bag):
    recorded = bag(with_sites=False)
    assert "announces no palpation sites: there is nothing to map" in fails(
        "map", recorded, "-e", "ekf"
    )


def test_map_refuses_an_unknown_filter_and_an_unknown_picture(fails, bag):
    recorded = bag()
    assert "there is no estimator 'magic'" in fails("map", recorded, "-e", "magic")
    assert "ends in .png, .svg or .pdf" in fails("map", recorded, "-e", "ekf", "-o", "map.xyz")


def test_estimates_of_one_site_begin_at_time_zero(bag, run):
    outcome = run("estimate", bag(), "--site", "5", "--output", "estimates.csv")
    assert outcome.status == 0, outcome.err
    first = Path("estimates.csv").read_text().splitlines()[1]
    assert float(first.split(",")[0]) == 0.0
