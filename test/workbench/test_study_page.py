"""The workbench shows the table of a study, finds rows, and opens a recording by one click."""

from __future__ import annotations

import numpy as np
import pytest

import tissue_probe as tp
from served import EXAMPLES, PATIENCE, serving

STUDY = """
recordings: data/*.csv
pattern: '{specimen}_{day}.csv'
question: {force_polarity: compression, rig: compliant_probe}
output: answers
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A server beside a study of two recordings, of which one is none."""
    folder = tmp_path_factory.mktemp("study")
    (folder / "data").mkdir()
    (folder / "study.yaml").write_text(STUDY)
    (folder / "data" / "liver_monday.csv").write_bytes((EXAMPLES / "sweep.csv").read_bytes())
    np.savetxt(folder / "data" / "kidney_friday.csv", np.zeros((3, 1)), header="t", comments="")
    tp.study(folder / "study.yaml", workers=1)
    with serving(tmp_path_factory.mktemp("state"), "--study", folder / "study.yaml") as found:
        yield found


def rows(page):
    return page.locator(".study tbody tr")


def test_the_table_is_filtered_and_a_click_opens_the_recording(study, open_page):
    page = open_page(study.address)
    rows(page).first.wait_for()
    assert rows(page).count() == 2
    assert "refused" in rows(page).first.inner_text()
    page.fill(".study input[type=search]", "LIVER done")
    assert rows(page).count() == 1
    rows(page).locator("button").click()
    page.wait_for_selector(".rung", timeout=PATIENCE)
    assert "liver_monday.csv" in page.inner_text(".column .head")


def test_a_recording_that_is_none_says_why_and_is_asked_about(study, open_page):
    page = open_page(study.address)
    page.keyboard.press("1")
    page.fill(".study input[type=search]", "kidney")
    rows(page).locator("button").click()
    page.wait_for_selector("article .problem", timeout=PATIENCE)


def test_no_path_of_the_machine_is_told(study, open_page):
    page = open_page(study.address)
    page.keyboard.press("1")
    rows(page).first.wait_for()
    assert str(study.folder.parent) not in page.content()
