"""Recordings of other units and rigs in one study: what is safe is silent, what is not is told."""

from __future__ import annotations

from pathlib import Path

import pytest
from laboratory import QUESTION, write
from test_statistics import result

import tissue_probe as tp
from tissue_probe.studies.plan import StudyPlan, recordings_of
from tissue_probe.studies.result import StudyResult

MILLINEWTON = ("F_mN", 1e3)


def study(folder: Path, **question: object) -> StudyResult:
    recordings = recordings_of(str(folder / "*.*"))
    return tp.study(
        StudyPlan(recordings, "compare", {**QUESTION, **question}, folder.parent / "answers"),
        workers=1,
    )


def written(folder: Path, *forces: tuple[str, float]) -> Path:
    (folder / "data").mkdir()
    for number, force in enumerate(forces):
        write(folder / "data" / f"{number}.csv", 300.0, seed=number, force=force)
    return folder / "data"


def test_files_that_tell_their_own_units_are_mixed_without_a_word(tmp_path):
    found = study(written(tmp_path, ("F_N", 1.0), MILLINEWTON))
    assert [row["stiffness"] for row in found.rows] == pytest.approx([300.0, 300.0], rel=0.01)
    assert {row["force_unit_from"] for row in found.rows} == {"file"}
    assert not found.notes
    assert not any("of the force" in row["notes"] for row in found.rows)


def test_a_file_without_a_unit_among_files_that_tell_theirs_is_told(tmp_path):
    """The second one is in millinewtons, and does not say so."""
    found = study(written(tmp_path, MILLINEWTON, ("F", 1e3)))
    said = "1 of 2 recordings (1.csv first) was taken in SI units since the file tells no unit of "
    assert said + "the force, and others tell theirs" in found.text
    assert "such as F_mN" in found.text
    assert "the file tells no unit of the force: it is taken in SI" in found.rows[1]["notes"]
    found.report(tmp_path / "report.html")
    assert "others tell theirs" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_files_without_a_unit_are_alike_and_no_doubt_of_the_study(tmp_path):
    assert not study(written(tmp_path, ("F", 1.0), ("F", 1.0))).notes


def test_counts_take_the_size_that_the_study_states(tmp_path):
    found = study(written(tmp_path, ("load", 4096.0), ("load", 4096.0)), force_unit=1 / 4096)
    assert [row["stiffness"] for row in found.rows] == pytest.approx([300.0, 300.0], rel=0.01)
    assert "it is taken as `force_unit` states" in found.rows[0]["notes"]
    assert not found.notes


def test_a_statement_that_overrules_a_file_is_told(tmp_path):
    found = study(written(tmp_path, ("load", 4096.0), MILLINEWTON), force_unit=1 / 4096)
    said = "1 of 2 recordings (1.csv first) was taken in the `force_unit` of the question although"
    assert said in found.text
    assert "leave out `force_unit` if the files are right" in found.text


def test_recordings_of_this_suite_among_others_are_told(tmp_path):
    folder = written(tmp_path, ("F", 1.0))
    paths = {folder / "0.csv": {}, Path("examples/scan.mcap"): {}}
    found = tp.study(
        StudyPlan(paths, "estimate", {"rig": "rigid_probe"}, tmp_path / "a"), workers=1
    )
    assert "2 done" in found.text
    assert "1 of 2 recordings (scan.mcap first) was recorded by this suite" in found.text
    assert "run a study for each rig" in found.text


@pytest.mark.parametrize("name", ["rig", "force_unit"])
def test_a_factor_that_seems_to_set_the_question_is_refused(tmp_path, name):
    plan = StudyPlan(
        {Path("a.csv"): {name: "x"}, Path("b.csv"): {name: "y"}}, output=tmp_path / "a"
    )
    with pytest.raises(tp.TissueProbeError, match=f"called {name}, .* run a study for each"):
        tp.study(plan)


def combined() -> StudyResult:
    """The rows of two studies of the same specimens, by rig."""
    found = result()
    rows = tuple(
        {**row, "question": rig, "by_rig": rig, "verdict": "adequate", "missing": ""}
        for row in found.rows[:-1]
        for rig in ("one", "other")
    )
    return StudyResult(rows, 0)


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda r: r.spread(), "the rows answer 2 questions .another task, rig"),
        (lambda r: r.spread(by="group"), "rows with group a answer 2 questions"),
        (lambda r: r.agreement(of="instrument"), "rows with instrument x answer 2 questions"),
        (lambda r: r.missing(), "the rows answer 2 questions"),
    ],
)
def test_rows_of_two_rigs_or_versions_are_not_put_together(ask, said):
    with pytest.raises(tp.TissueProbeError, match=said):
        ask(combined())


def test_rows_of_two_rigs_are_compared_by_the_factor_that_tells_them_apart():
    assert combined().agreement(of="by_rig").bias.value == pytest.approx(0.0, abs=1e-9)
    assert ("one", "other") in combined().spread(by="by_rig").contrasts
