"""Challenges made, sealed and graded by the program."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tissue_probe import cli
from tissue_probe.challenge import SIMULATED_EFFECTS
from tissue_probe.physics import effects as library
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.model_file import save
from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.bags.reader import read_recording
from tissue_probe.recording.layout import Layout

SERIES = ("--count", 4, "--seed", 3, "--excitation", "sine10")


def samples_of(table):
    return read_any(table, Layout())[0]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a series and its answers."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("series"))
        done = CliRunner().invoke(cli.app, ["challenge", "make", *map(str, SERIES), "made"])
        assert done.exit_code == 0
        return Path.cwd()


@pytest.fixture
def series(made, tmp_path):
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    return json.loads((tmp_path / "answers.sealed.json").read_text())["answers"]


def diagnose(tmp_path, answers, right):
    for name, answer in answers.items():
        first = answer["effects"][0] if answer["effects"] else None
        diagnosis = {
            "verdict": "missing" if first else "adequate",
            "ranking": [{"effect": first if right else "hertz_contact"}] if first else [],
            "indistinguishable": [],
            "unseen": [],
            "effects": answer["effects"],
        }
        (tmp_path / "made" / f"{name}.json").write_text(json.dumps(diagnosis))


def test_a_series_is_made_with_second_recordings(series, tmp_path):
    names = sorted(path.name for path in (tmp_path / "made").iterdir())
    assert names == sorted(f"000{n}{end}.csv" for n in range(1, 5) for end in ("", "_second"))
    recording = samples_of(tmp_path / "made" / "0001.csv")
    assert len(recording) == 4000
    assert recording.blocks[0].sample_period == pytest.approx(5e-4)
    assert np.ptp(recording.position) > 1e-3


def test_a_single_recording_is_told_as_one(run):
    told = run("challenge", "make", "--count", 1, "--excitation", "sine10", "made").out
    assert "1 recording, and a second one, are in made." in told


@pytest.mark.parametrize("ending", ["csv", "mcap"])
def test_nothing_among_the_recordings_tells_the_answer(run, tmp_path, ending):
    run("challenge", "make", *SERIES, "made", "--format", ending, "--answers", "sealed.json")
    words = [name.encode() for name in SIMULATED_EFFECTS] + [
        b"stiffness",
        b"effect",
        b"seed",
        b"sine10",
    ]
    for path in (tmp_path / "made").rglob("*"):
        content = path.read_bytes()
        assert not [word for word in words if word in content + path.name.encode()]
        if ending == "mcap":
            assert not read_recording(path).metadata
    assert set(json.loads((tmp_path / "sealed.json").read_text())["answers"]) == {
        f"000{n}" for n in range(1, 5)
    }


def test_a_bag_holds_what_the_table_holds(run, tmp_path, series):
    run("challenge", "make", *SERIES, "bags", "--format", "mcap", "--answers", "other.json")
    table = samples_of(tmp_path / "made" / "0002_second.csv")
    bag = read_recording(tmp_path / "bags" / "0002_second.mcap")
    np.testing.assert_allclose(bag.position, table.position, atol=1e-12)
    np.testing.assert_allclose(bag.force, table.force, atol=1e-8)


def test_right_diagnoses_are_marked_right(run, tmp_path, series):
    diagnose(tmp_path, series, right=True)
    outcome = run("challenge", "grade", "made", "--json", "marks.json")
    assert outcome.status == 0
    marks = json.loads((tmp_path / "marks.json").read_text())
    assert marks["version"] == 1
    assert marks["undiagnosed"] == []
    assert marks["first"]["right"] == marks["first"]["total"]
    assert sum(sum(named.values()) for named in marks["confusion"].values()) == 4
    assert "one effect hidden: ranked first" in outcome.out
    assert max(map(len, outcome.out.splitlines())) <= 80


def test_a_missing_diagnosis_is_told_and_counts_as_wrong(run, tmp_path):
    run("challenge", "make", *SERIES, "--hide", "one", "made")
    answers = json.loads((tmp_path / "answers.sealed.json").read_text())["answers"]
    diagnose(tmp_path, answers, right=True)
    (tmp_path / "made" / "0003.json").unlink()
    outcome = run("challenge", "grade", "made", "--json", "marks.json")
    assert "Without a diagnosis, and so wrong: 0003." in outcome.out
    marks = json.loads((tmp_path / "marks.json").read_text())
    assert marks["first"]["right"] == marks["first"]["total"] - 1
    assert sum(named.get("no diagnosis", 0) for named in marks["confusion"].values()) == 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["make", "out", "--answers", "out/answers.json"], "lies among the recordings"),
        (["make", "out", "--excitation", "square"], "there is no excitation 'square'"),
        (["make", "out", "--excitation", "run.csv"], "and no such file; there are sine10, "),
        (["make", "out", "--excitation", "any", "--site", "1"], "are of a file's motion"),
        (["make", "out", "--rig", "bent"], "there is no rig 'bent'"),
        (["make", "out", "--hide", "all"], "cannot hide 'all'"),
        (["make", "out", "--format", "bag"], "recordings are csv or mcap"),
        (["grade", "nowhere"], "No such file"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line(fails, arguments, said):
    assert said in fails("challenge", *arguments)


def write_motion(path, header="t,u", scale=1.0):
    time = np.arange(2_000) / 1_000
    moved = np.round(2e-3 + 1e-3 * np.sin(2.0 * np.pi * (3.0 + 4.0 * time) * time), 7)
    np.savetxt(
        path, np.column_stack([time, scale * moved]), "%.7g", ",", header=header, comments=""
    )


def test_the_users_own_motion_is_repeated_and_its_recordings_can_be_diagnosed(run, tmp_path):
    write_motion(tmp_path / "mine.csv")
    made = run(
        *("challenge", "make", "made", "--excitation", "mine.csv", "--starts", "moving"),
        *("--count", 1, "--hide", "none"),
    )
    assert made.status == 0, made.err
    assert "The coil moves as in mine.csv: 1.9995 s, begun in motion, by 1.0" in made.out
    answers = json.loads((tmp_path / "answers.sealed.json").read_text())["answers"]
    assert answers["0001"]["excitation"]["source"] == "mine.csv"
    mine, recording = (
        np.loadtxt(tmp_path / n, delimiter=",", skiprows=1) for n in ("mine.csv", "made/0001.csv")
    )
    assert len(recording) == pytest.approx(4_000, abs=2)
    np.testing.assert_allclose(recording[::2, 1], mine[: len(recording[::2]), 1], atol=5e-7)
    found = run(
        "diagnose",
        "made/0001.csv",
        "--rig",
        "compliant_probe",
        "--known-rig",
        "--json",
        "0001.json",
    )
    assert found.status == 0, found.err
    assert json.loads((tmp_path / "0001.json").read_text())["verdict"] == "adequate"


def test_a_recording_is_repeated_as_a_table_is(run, tmp_path):
    for ending in ("csv", "mcap"):
        source = ("--excitation", "msine60", "--hide", "none", "--count", 1, "--format", ending)
        run("challenge", "make", ending, *source, "--answers", f"{ending}.json")
        again = ("--excitation", f"{ending}/0001.{ending}", "--hide", "one", "--count", 1)
        assert run("challenge", "make", f"{ending}2", *again, "--answers", f"{ending}2.json").out
    one, other = (samples_of(tmp_path / f"{ending}2" / "0001.csv") for ending in ("csv", "mcap"))
    np.testing.assert_allclose(one.force, other.force, atol=1e-6)


def test_a_motion_that_cannot_be_repeated_is_told_in_one_line(fails, tmp_path):
    make = ("challenge", "make", "out", "--excitation")
    write_motion(tmp_path / "mm.csv", scale=1e3)
    assert "give u in metres" in fails(*make, "mm.csv")
    write_motion(tmp_path / "named.csv", header="t,position")
    assert "named.csv has no column u; its columns are t, position" in fails(*make, "named.csv")
    (tmp_path / "notes.mcap").write_text("none")
    assert "notes.mcap" in fails(*make, "notes.mcap")
    write_motion(tmp_path / "mine.csv")
    assert "no samples at site 3" in fails(*make, "mine.csv", "--site", 3)
    assert not (tmp_path / "out").exists()


def test_an_opened_seal_shows_what_is_true_beside_what_was_found(run, fails, series, tmp_path):
    composition = Composition().plus(library.EFFECTS["coulomb_friction"].plain)
    values = {entry.name: entry.default for entry in composition.values}
    save(tmp_path / "model.yaml", composition, {**values, "stiffness": 432.1}, {})
    outcome = run("challenge", "open", "0001", "--model", "model.yaml")
    assert outcome.status == 0, outcome.err
    (row,) = [line for line in outcome.out.splitlines() if line.startswith("│ stiffness ")]
    assert f"{series['0001']['tissue']['stiffness']:.5g}" in row
    assert "432.1 +- 0" in row
    assert "coulomb_friction" in outcome.out
    assert "has no 9999; it has 0001" in fails("challenge", "open", "9999", "--model", "model.yaml")


def test_answers_and_recordings_are_never_overwritten(fails, series):
    assert "never overwritten" in fails("challenge", "make", *SERIES, "elsewhere")
    assert "exists" in fails("challenge", "make", *SERIES, "made", "--answers", "new.json")


def test_a_folder_without_diagnoses_and_a_broken_one_are_told(fails, series, tmp_path):
    assert "holds none of 0001.json to 0004.json" in fails("challenge", "grade", "made")
    (tmp_path / "made" / "0001.json").write_text("{")
    assert "0001.json is not JSON" in fails("challenge", "grade", "made")
