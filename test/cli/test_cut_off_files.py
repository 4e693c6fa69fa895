"""Files that end before their end: read up to there, or refused in one sentence by their name."""

from __future__ import annotations

from pathlib import Path

import pytest
from pyarrow import csv as arrow_csv
from pyarrow import parquet
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tissue_probe.configuration import stock_configuration
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.model_file import save
from tissue_probe.physics.phantom import Phantom

STATED = ("--rig", "compliant_probe", "--force-polarity", "compression")
CUTS = (0.02, 0.35, 0.5, 0.8, 0.97)


def cut(path: Path, part: float) -> Path:
    content = path.read_bytes()
    path.write_bytes(content[: round(part * len(content))])
    return path


def is_told(outcome, path: Path) -> bool:
    """Whether the program ended with status 1 and one sentence that names the file."""
    return (
        outcome.status == 1
        and outcome.err.startswith("tissue_probe: ")
        and outcome.err.count("\n") == 1
        and path.name in outcome.err
    )


@pytest.mark.parametrize("part", CUTS)
def test_a_recording_is_read_up_to_the_cut_or_told_to_hold_nothing(run, bag, part):
    path = cut(bag(), part)
    outcome = run("info", path)
    if outcome.status:
        assert part < 0.1
        assert "run.mcap: nothing in it can be read" in outcome.err
    else:
        assert "The recording was cut off" in outcome.out
    outcome = run("export", path)
    assert outcome.status == 0 or is_told(outcome, path), outcome.err


@pytest.mark.parametrize("part", CUTS)
def test_a_db3_file_that_is_cut_off_is_told(run, tmp_path, messages, scan, part):
    folder = tmp_path / "bag"
    with Writer(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        store = get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(messages.definitions[messages.SAMPLES], messages.SAMPLES))
        connection = writer.add_connection("/samples", messages.SAMPLES, typestore=store)
        for block in scan[0]:
            writer.write(connection, block.stamp, messages.samples(block))
    (path,) = folder.glob("*.db3")
    for command in ("info", "export"):
        outcome = run(command, cut(path, part))
        assert is_told(outcome, path), outcome.err or outcome.out


@pytest.mark.parametrize("part", CUTS)
@pytest.mark.parametrize("kind", ["csv", "parquet"])
@pytest.mark.parametrize("command", ["estimate", "compare"])
def test_a_table_that_is_cut_off_is_read_up_to_there_or_told(run, csv, command, kind, part):
    path = csv()
    if kind == "parquet":
        path = path.with_suffix(".parquet")
        parquet.write_table(arrow_csv.read_csv(csv()), path)
    outcome = run(command, cut(path, part), *STATED)
    # The last row of a text may end within a number: nobody can tell. Parquet ends in its index.
    assert (outcome.status == 0 and kind == "csv") or is_told(outcome, path), outcome.err


@pytest.fixture
def model(tmp_path) -> Path:
    composition = Composition()
    values = {entry.name: entry.default for entry in composition.values}
    save(tmp_path / "model.yaml", composition, values, {})
    return tmp_path / "model.yaml"


@pytest.mark.parametrize("part", CUTS)
def test_a_model_file_that_is_cut_off_is_told(run, csv, model, part):
    csv()
    outcome = run("compare", "measured.csv", *STATED, "--model", cut(model, part))
    assert is_told(outcome, model), outcome.err or outcome.out


@pytest.mark.parametrize("part", [0.02, 0.35, 0.5, 0.8])
def test_a_calibration_that_is_cut_off_is_told_and_stays_as_it_is(run, bag, tmp_path, part):
    path = tmp_path / "calibration.yaml"
    path.write_text(stock_configuration("calibration.yaml").read_text())
    left = cut(path, part).read_bytes()
    assert is_told(run("export", bag(), "--calibration", path), path)
    assert path.read_bytes() == left


def test_a_phantom_is_cut_off_between_two_nodules_or_told(tmp_path):
    content = stock_configuration("phantom.yaml").read_bytes()
    whole, path, told = Phantom.load(stock_configuration("phantom.yaml")), tmp_path / "p.yaml", 0
    for end in range(0, len(content), 3):
        path.write_bytes(content[:end])
        try:
            left = Phantom.load(path)
            assert left.nodules == whole.nodules[: len(left.nodules)]
        except ValueError as error:
            told += str(error).startswith(str(path)) and "\n" not in str(error)
        else:
            told += 1
    assert told == len(range(0, len(content), 3))
