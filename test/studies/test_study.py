"""A study is one row a recording; what is done stays done, whatever ends a run."""

from __future__ import annotations

import os
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
import pytest
from laboratory import QUESTION, write

import tissue_probe as tp
from tissue_probe.studies.dataset import Dataset
from tissue_probe.studies.plan import StudyPlan, read_plan, recordings_of


def plan_of(folder: Path, **changes: object) -> StudyPlan:
    asked = {
        "recordings": recordings_of(str(folder / "*.csv"), "{specimen}_{day}.csv"),
        "task": "compare",
        "question": QUESTION,
        "output": folder.parent / "answers",
    }
    return StudyPlan(**{**asked, **changes})


def stored(folder: Path) -> list[dict]:
    return pq.read_table(folder.parent / "answers" / "rows").to_pylist()


def test_each_recording_is_a_row_with_its_factors(laboratory):
    found = tp.study(plan_of(laboratory), workers=2)
    assert found.computed == 6
    assert found.text.startswith("6 recordings, 6 computed now: 6 done")
    by_specimen = found.to_frame().groupby("specimen")["stiffness"].mean()
    assert by_specimen.to_dict() == pytest.approx({"a": 300.0, "b": 400.0, "c": 500.0}, rel=0.01)
    paths = sorted(row["path"] for row in found.rows)
    assert sorted(row["path"] for row in stored(laboratory)) == paths
    table = pd.read_csv(laboratory.parent / "answers" / "table.csv")
    assert list(table["stiffness"]) == [row["stiffness"] for row in found.rows]


def test_a_second_run_computes_what_has_changed_alone(laboratory):
    plan = plan_of(laboratory)
    tp.study(plan, workers=1)
    assert tp.study(plan, workers=1).computed == 0
    write(laboratory / "a_1.csv", 350.0, seed=9)
    (laboratory / "b_1.csv").touch()  # another date, the same bytes
    found = tp.study(plan, workers=1)
    assert found.computed == 1
    assert "a_1.csv has changed since its row was computed: it was computed again" in found.text
    (changed,) = (row for row in found.rows if row["path"].endswith("a_1.csv"))
    assert changed["stiffness"] == pytest.approx(350.0, rel=0.01)
    assert len(stored(laboratory)) == 6
    assert tp.study(plan_of(laboratory, task="estimate"), workers=1).computed == 6


def test_another_file_of_the_same_size_and_date_is_noticed(laboratory):
    plan = plan_of(laboratory, task="estimate", question={"force_polarity": "compression"})
    tp.study(plan, workers=1)
    file = laboratory / "a_1.csv"
    status, text = file.stat(), file.read_text()
    other = laboratory.parent / "other"
    other.write_text(text[:-3] + ("1" if text[-3] != "1" else "2") + text[-2:])
    os.utime(other, ns=(status.st_atime_ns, status.st_mtime_ns))
    os.replace(other, file)
    assert (file.stat().st_size, file.stat().st_mtime_ns) == (status.st_size, status.st_mtime_ns)
    assert tp.study(plan, workers=1).computed == 1


def test_a_change_within_a_folder_is_noticed(laboratory):
    """A folder, as bags are, keeps its own date when a file in it is written anew."""
    folder = laboratory / "d_1.csv"
    folder.mkdir()
    (folder / "part").write_text("one")
    plan = plan_of(laboratory, recordings={folder: {}})
    assert tp.study(plan, workers=1).computed == 1
    assert tp.study(plan, workers=1).computed == 0
    (folder / "part").write_text("two")
    assert tp.study(plan, workers=1).computed == 1


def test_a_batch_that_is_written_twice_is_there_once(tmp_path):
    """So an interrupt between a batch's writing and the next line doubles no row."""
    rows = [{"path": "a", "stiffness": 1.0}, {"path": "b", "stiffness": 2.0}]
    kept = Dataset(tmp_path / "rows")
    kept.write(rows)
    kept.write(rows)
    assert kept.read() == rows


def test_other_factors_are_taken_over_without_computing(laboratory):
    tp.study(plan_of(laboratory), workers=1)
    plan = plan_of(laboratory)
    named = {path: {"group": factors["specimen"]} for path, factors in plan.recordings.items()}
    found = tp.study(plan_of(laboratory, recordings=named), workers=1)
    assert found.computed == 0
    assert {row["group"] for row in stored(laboratory)} == {"a", "b", "c"}
    assert all("specimen" not in row or row["specimen"] is None for row in stored(laboratory))


def test_a_bad_recording_is_a_row_and_the_others_are_done(laboratory):
    (laboratory / "d_1.csv").write_text("nothing\n")
    found = tp.study(plan_of(laboratory), workers=1)
    assert "6 done, 1 refused" in found.text
    (bad,) = (row for row in found.rows if row["status"] == "refused")
    assert bad["specimen"] == "d"
    assert bad["sentence"]


def test_a_damaged_file_of_rows_is_set_aside_and_its_recordings_are_computed_again(laboratory):
    plan = plan_of(laboratory)
    tp.study(plan, workers=1)
    for file in plan.output.glob("rows/*.parquet"):
        file.write_bytes(file.read_bytes()[:100])
    found = tp.study(plan, workers=1)
    assert found.computed == 6
    assert "was damaged and is set aside" in found.text
    assert len(stored(laboratory)) == 6


def test_the_same_file_twice_is_told(laboratory):
    (laboratory / "e_1.csv").write_bytes((laboratory / "a_1.csv").read_bytes())
    found = tp.study(plan_of(laboratory), workers=1)
    assert "has the same bytes as" in found.text


def test_a_recording_whose_process_dies_is_told_and_no_other_is_lost(laboratory, tmp_path):
    """A file of effects that ends the process stands for memory that runs out in one of them."""
    killer = tmp_path / "killer.py"
    killer.write_text(
        "import os, signal, sys\n"
        f"if os.path.exists({str(tmp_path / 'armed')!r}):\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n" + Path("docs/my_effect.py").read_text()
    )
    two = recordings_of(str(laboratory / "a_*.csv"))
    asked = {**QUESTION, "effects": [str(killer)]}
    plan = plan_of(laboratory, recordings=two, question=asked)
    (tmp_path / "armed").touch()
    found = tp.study(plan, workers=2)
    assert {row["status"] for row in found.rows} == {"failed"}
    assert all("ended from outside" in row["sentence"] for row in found.rows)
    (tmp_path / "armed").unlink()
    assert "2 done" in tp.study(plan, workers=2).text


def test_an_interrupt_keeps_the_rows_that_are_done(laboratory):
    plan = plan_of(laboratory)

    def interrupt(done: int, of: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tp.study(plan, workers=1, progress=interrupt)
    assert len(stored(laboratory)) == 2
    assert tp.study(plan, workers=1).computed == 4


def test_the_plan_is_read_from_a_file(laboratory, tmp_path):
    (tmp_path / "study.yaml").write_text(
        "recordings: data/*.csv\npattern: '{specimen}_{day}.csv'\ntask: compare\n"
        "question: {rig: rigid_probe, force_polarity: compression}\noutput: rows\n"
    )
    plan = read_plan(tmp_path / "study.yaml")
    assert plan.factors == ("specimen", "day")
    assert plan.output == tmp_path / "rows"
    assert tp.study(tmp_path / "study.yaml", workers=1).computed == 6


def test_a_table_names_recordings_and_factors(laboratory, tmp_path):
    (tmp_path / "all.csv").write_text("path,operator\ndata/a_1.csv,Ann\ndata/b_1.csv,Bo\n")
    found = recordings_of("all.csv", folder=tmp_path)
    assert list(found.values()) == [{"operator": "Ann"}, {"operator": "Bo"}]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("recordings: none/*.csv", "no file is named"),
        ("task: compare", "describes no study: give `recordings`"),
        ("recordings: data/*.csv\nsubject: 1", "no field subject; there are recordings"),
        ("recordings: data/*.csv\ntask: guess", "it is one of estimate, compare, diagnose"),
        ("recordings: data/*.csv\npattern: '{a}-{b}.csv'", "a_1.csv is no such name"),
        ("recordings: data/*.csv\nquestion: {rigg: 1}", "takes no `rigg`"),
        ("recordings: data/*.csv\npattern: '{status}_{day}.csv'", "as a column of rows is"),
        ("recordings: twice.csv", "line 3: .*a_1.csv is named a second time"),
        ("recordings: hole.csv", "line 2: no operator is given: fill it in"),
        ("recordings: away.csv", "line 2: there is no "),
        ("[", "cannot be read|no YAML|it "),
    ],
)
def test_a_plan_that_is_none_is_refused_in_a_sentence(laboratory, tmp_path, text, said):
    (tmp_path / "twice.csv").write_text("path\ndata/a_1.csv\ndata/a_1.csv\n")
    (tmp_path / "hole.csv").write_text("path,operator\ndata/a_1.csv,\n")
    (tmp_path / "away.csv").write_text("path\ndata/z.csv\n")
    (tmp_path / "study.yaml").write_text(text)
    with pytest.raises(tp.TissueProbeError, match=said):
        tp.study(tmp_path / "study.yaml", workers=1)
