"""The page of a study says what the rows say, links to what is there, and loads nothing."""

from __future__ import annotations

import re
from urllib.parse import unquote, urlsplit

import pytest
from test_statistics import result

import tissue_probe as tp
from tissue_probe.studies.reporting import report_folder
from tissue_probe.studies.result import StudyResult


def told(found: StudyResult) -> StudyResult:
    """Return the rows as a run leaves them."""
    run = {"task": "estimate", "version": "1", "key": "0123456789", "seconds": 0.5, "duration": 2.0}
    rows = tuple({**run, **each, "path": f"/data/{each['path']}.csv"} for each in found.rows)
    return StudyResult(rows, 0, ("a note",), {"rig": "rigid_probe"})


def page(found: StudyResult, folder, **asked) -> str:
    found.report(folder / "report.html", **asked)
    return (folder / "report.html").read_text(encoding="utf-8")


def test_it_tells_the_work_the_exclusions_and_the_means(tmp_path):
    found = told(result(damping=5.0, damping_sd=0.1))
    text = page(found, tmp_path, by="group")
    assert "24 done, 1 refused" in text
    assert "a note" in text
    assert re.search(r"bad.csv</td><td>refused</td><td[^>]*>no</td>", text)
    contrast = found.spread(by="group").contrasts["a", "b"]
    assert f"b less a: {contrast}" in text
    assert text.count('class="range"') == 2 * (24 + 2)
    assert "default-src 'none'" in text
    assert "<script" not in text


def test_a_recording_whose_report_is_there_has_a_link_and_others_the_command(tmp_path):
    found = told(result())
    own = tmp_path / report_folder(found.rows[3])
    own.mkdir(parents=True)
    (own / "report.html").write_text("its own")
    text = page(found, tmp_path)
    assert 'href="reports/3-01234567/report.html"' in text
    assert "tissue_probe improve /data/0.csv --rig rigid_probe --output" in text


def test_the_share_of_recordings_that_miss_an_effect_is_drawn(tmp_path):
    text = page(told(result(verdict="missing", missing="force_lag", task="diagnose")), tmp_path)
    assert "force_lag" in text
    assert "100 % [86 % … 100 %]" in text


def test_where_no_spread_is_told_the_page_says_why(tmp_path):
    text = page(told(result(specimen="one")), tmp_path)
    assert "1 specimens tell no spread between specimens" in text


def test_a_value_that_no_recording_has_is_refused(tmp_path):
    with pytest.raises(tp.TissueProbeError, match="no recording has a hardness"):
        told(result()).report(tmp_path / "report.html", value="hardness")


def test_a_filter_that_felt_nothing_is_left_out_and_said_so(tmp_path):
    found = told(result())
    rows = ({**found.rows[0], "quality": "no_contact", "stiffness": 1e9}, *found.rows[1:])
    text = page(StudyResult(rows, 0), tmp_path)
    assert "felt no tissue" in text
    assert "23 of 25" in text


def test_constants_given_as_lists_stand_in_the_command(tmp_path):
    found = told(result())
    asked = {"constants": {"tip_mass": [0.04, 0.001], "stiffness": 0}}
    text = page(StudyResult(found.rows, 0, (), asked), tmp_path)
    assert "--constant tip_mass=0.04+-0.001 --constant stiffness=0" in text


def test_a_study_of_which_all_is_left_out_has_a_page(tmp_path):
    found = told(result())
    rows = tuple({**each, "status": "refused", "sentence": "no unit"} for each in found.rows)
    text = page(StudyResult(rows, 0), tmp_path)
    assert "0 of 25" in text
    assert "all recordings are left out of the statistics" in text
    assert 'class="forest"' not in text


def test_a_link_leads_to_the_report_of_a_recording_of_any_name(tmp_path):
    found = told(result())
    row = {**found.rows[3], "path": "/data/liver#3 50%.csv"}
    own = tmp_path / report_folder(row)
    own.mkdir(parents=True)
    (own / "report.html").write_text("its own")
    text = page(StudyResult((row, *found.rows), 0), tmp_path)
    (address,) = set(re.findall(r'href="(reports/[^"]*)"', text))
    assert (tmp_path / unquote(urlsplit(address).path)).read_text() == "its own"


def test_a_page_that_cannot_be_written_leaves_no_part_of_it(tmp_path):
    (tmp_path / "report.html").mkdir()
    with pytest.raises(tp.TissueProbeError, match="the report cannot be written"):
        told(result()).report(tmp_path / "report.html")
    assert [each.name for each in tmp_path.iterdir()] == ["report.html"]


def over_frequency(rows):
    """Return rows with storage and loss at their frequencies, as recordings of one sine have."""
    values = [(2.0, 300.0, 40.0), (20.0, 310.0, 400.0), (20.0, 290.0, 380.0)]
    return [
        {**row, "frequency": f, "storage": k, "storage_sd": 5.0, "loss": g, "loss_sd": 30.0}
        for row, (f, k, g) in zip(rows, values, strict=False)
    ]


def test_storage_and_loss_are_drawn_over_frequency_with_the_groups_told_apart(tmp_path):
    rows = over_frequency(told(result()).rows)
    text = page(StudyResult((*rows, *told(result()).rows[3:]), 0), tmp_path, by="group")
    storage, loss = re.findall(r'<svg class="frequencies".*?</svg>\n(?=\n|<)', text, re.DOTALL)
    for drawn, said in ((storage, "300.0 [290.2 … 309.8] N/m at 2 Hz"), (loss, "N/m at 20 Hz")):
        assert said in drawn
        assert drawn.count('class="bar-of"') == 3
        left, *right = (float(each) for each in re.findall(r'class="bar-of" x1="([\d.]+)%"', drawn))
        assert left < right[0] == right[1]
        assert {"group0", "group1"} >= set(re.findall(r'<g class="(group\d)"', drawn))
    low, high = (float(re.findall(r'<svg x="[\d.]+%" y="([\d.]+)"', loss)[i]) for i in (0, 1))
    assert low > high  # from the top: the larger loss stands higher


def test_a_part_that_is_not_above_zero_is_said_not_to_be_drawn(tmp_path):
    first, second, third = over_frequency(told(result()).rows)
    rows = ({**first, "loss": -1.0}, second, third, *told(result()).rows[3:])
    text = page(StudyResult(rows, 0), tmp_path)
    assert "Not drawn, since the value is not above 0 or its error not known: 1." in text


def test_a_study_without_a_driving_frequency_has_no_such_plot(tmp_path):
    assert 'class="frequencies"' not in page(told(result()), tmp_path)
