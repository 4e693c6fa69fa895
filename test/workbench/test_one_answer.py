"""One question has one answer: on the command line, in Python, on the page, and in the report."""

from __future__ import annotations

import json
import re
import subprocess
import sys

import pytest

import tissue_probe as tp
from served import EXAMPLES, serving

FILES = [str(EXAMPLES / name) for name in ("sweep.csv", "sweep_second.csv")]
STATED = ("--rig", "compliant_probe", "--starts", "at-rest", "--force-polarity", "compression")
#: Of two searches in different processes the last digits may differ.
ALIKE = 1e-6


@pytest.fixture(scope="module")
def on_the_command_line(tmp_path_factory):
    folder = tmp_path_factory.mktemp("answer")
    command = [sys.executable, "-m", "tissue_probe", "improve", FILES[0], *STATED]
    command += ["--validate", FILES[1], "--json", folder / "answer.json", "-o", folder / "kept"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    report = (folder / "kept" / "report.html").read_text(encoding="utf-8")
    return json.loads((folder / "answer.json").read_text()), done.stdout, report


@pytest.fixture(scope="module")
def in_python():
    first, second = (tp.read(each, force_polarity="compression") for each in FILES)
    return tp.diagnose(first, validate=second, rig="compliant_probe", starts="at-rest")


def same(one, other):
    """Whether two answers have the same verdict, rig, effects, probabilities, values and errors."""
    for name in ("verdict", "effects", "asked", "sentences", "says"):
        assert one[name] == other[name]
    for mine, theirs in zip(one["values"], other["values"], strict=True):
        assert mine["name"] == theirs["name"]
        assert mine["value"] == pytest.approx(theirs["value"], rel=ALIKE)
        assert mine["deviation"] == pytest.approx(theirs["deviation"], rel=1e-3)
    for name, error in one["errors"].items():
        assert error == pytest.approx(other["errors"][name], rel=ALIKE)
    probable = [
        {each["effect"]: each["probability"] for each in a["ranking"]} for a in (one, other)
    ]
    assert probable[0] == pytest.approx(probable[1], abs=1e-3)


def test_the_command_line_and_python_say_the_same(on_the_command_line, in_python):
    answer, printed, _ = on_the_command_line
    same(answer, in_python.to_dict())
    words = re.sub(r"\s+", " ", printed)
    for sentence in answer["sentences"]:
        assert re.sub(r"\s+", " ", sentence) in words


def test_the_report_says_the_same(on_the_command_line):
    answer, _, report = on_the_command_line
    assert answer["asked"] in report
    for sentence in answer["sentences"]:
        assert sentence.replace(">", "&gt;").replace("'", "&#39;") in report
    assert "compliant_probe" in report
    assert "--rig compliant_probe" in report


def test_the_page_says_the_same(on_the_command_line, open_page, tmp_path):
    with serving(tmp_path, *FILES, *STATED) as server:
        page = open_page(server.address)
        page.wait_for_selector(".rung")
        page.keyboard.press("r")
        page.wait_for_selector(".verdict")
        told = page.evaluate(
            "import('/app.js').then((app) => JSON.stringify(app.told.desk.ranking.answer))"
        )
        answer = on_the_command_line[0]
        same(json.loads(told), answer)
        assert page.inner_text(".verdict p >> nth=0") == answer["sentences"][0]
        page.close()
