"""The report as a page: all that was given is on it, and it needs nothing but itself."""

import re
import shutil
import subprocess
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from example import equations, example
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.report.contents import (
    Report,
    ReportParameter,
    ReportRig,
    ReportStep,
    ReportSymbol,
)
from tissue_probe.report.page import render

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")


class _Reader(HTMLParser):
    """Collects visible text, and every address that the browser would load or follow."""

    def __init__(self):
        super().__init__()
        self.text, self.loaded, self.tags, self._hidden = [], [], [], None

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        if tag in ("script", "style"):
            self._hidden = tag
        self.loaded += [value for name, value in attributes if name in ("src", "href", "data")]

    def handle_endtag(self, tag):
        if tag == self._hidden:
            self._hidden = None

    def handle_data(self, data):
        if self._hidden is None:
            self.text.append(data)


def read(page):
    reader = _Reader()
    reader.feed(page)
    reader.words = re.sub(r"\s+", " ", "".join(reader.text))
    return reader


@pytest.fixture(scope="module")
def page():
    return render(example())


@pytest.fixture(scope="module")
def reader(page):
    return read(page)


def test_an_effect_whose_search_did_not_settle_is_marked_and_the_mark_explained(reader):
    assert "coulomb_friction (gave up or did not settle)" in reader.words
    assert reader.words.count("(gave up or did not settle)") == 1
    assert "1 effects for which the search gave up" in reader.words
    assert "the numbers are a guess, no result" in reader.words
    settled = replace(example(), ranking=example().ranking[:2])
    assert "did not settle" not in read(render(settled)).words


def test_the_page_says_all_that_was_given(reader):
    report = example()
    expected = [report.title, *report.summary, *report.findings, report.created]
    expected += [step.model for step in report.steps]
    expected += [step.reason for step in report.steps]
    expected += [each.effect for each in report.ranking]
    expected += [each.description for each in report.ranking]
    expected += [test.finding for test in (*report.base_tests, *report.final_tests)]
    expected += [test.hint for test in report.base_tests]
    (excitation,) = report.excitations
    expected += [excitation.reason, excitation.command, *excitation.notes]
    expected += [report.sources[0].name, report.sources[0].description]
    expected += [f"{name} {version}" for name, version in report.versions.items()]
    expected += [report.signals[0].base_localisation.here.describe()]
    assert not [text for text in expected if text not in reader.words]


def test_errors_stand_in_millinewtons_and_in_multiples_of_the_noise(page):
    report = example()
    (row,) = re.findall(r"<td>1</td><td><b>\+ cubic_stiffening</b>(.*?)</tr>", page, re.S)
    cells = re.findall(r'<td class="number">(.*?)</td>', row)
    errors = (1e3 * report.steps[1].training_rmse, 1e3 * report.steps[1].heldout_rmse)
    ratio = report.steps[1].heldout_rmse / report.noise_floor
    assert [float(cell) for cell in cells] == pytest.approx([*errors, ratio], rel=5e-3)


def test_parameters_have_symbol_interval_and_unit(reader):
    assert "k = 800.3 N/m [798.9 … 801.7]" in reader.words
    assert "β = 4.012 N s/m [3.994 … 4.030]" in reader.words


def test_equations_are_mathml(page, reader):
    assert page.count('display="block"') >= 4
    assert reader.tags.count("mfrac") >= 8
    assert r"\frac" not in reader.words


def test_nothing_is_loaded_and_nothing_can_be_sent(page, reader):
    assert reader.loaded == []
    assert "Content-Security-Policy" in page
    assert page.count("data-plots=") == 2


def test_the_script_of_the_plots_is_there_once_and_the_page_is_small(page):
    assert page.count("https://github.com/leeoniya/uPlot") == 1
    assert len(page) < 1e6


def test_symbols_rig_command_and_what_goes_together_are_told(page):
    rig = ReportRig("a_rig", "Tip on a spring", "<svg></svg>")
    symbol = ReportSymbol("k_3", "cubic stiffness", "N/m^3")
    told = replace(
        example(), rig=rig, symbols=(symbol,), correlations=(("k", "k_3", -0.97),),
        command="tissue_probe improve a.csv --rig a_rig",
    )  # fmt: skip
    words = read(render(told)).words
    for each in ("a_rig: Tip on a spring.", "cubic stiffness", "N/m^3", "-0.97", told.command):
        assert each in words


@pytest.mark.parametrize(("size", "unit"), [(1437.0, "kN"), (1.88e-9, "nN"), (0.03, "mN")])
def test_errors_stand_in_the_unit_in_which_they_are_read_easily(size, unit):
    step = ReportStep("Kelvin-Voigt", "", (), (), size, size)
    page = render(Report("Title", "adequate", (), size, (step,)))
    assert f"[{unit}]" in page
    assert "× 10" not in read(page).words


def test_data_cannot_break_out_of_the_page():
    evil = "<script>alert('x')</script>"
    report = example()
    steps = (replace(report.steps[0], model=evil), report.steps[1])
    signals = (replace(report.signals[0], name=evil),)
    reader = read(render(replace(report, title=evil, steps=steps, signals=signals)))
    assert reader.words.count(evil) >= 3
    assert reader.tags.count("script") == read(render(report)).tags.count("script")


@pytest.mark.parametrize(
    ("verdict", "words"),
    [
        ("adequate", "Adequate"),
        ("missing", "An effect is missing"),
        ("ambiguous", "Cannot be told"),
        ("unexplained", "Unexplained"),
    ],
)
def test_the_verdict_stands_in_words(verdict, words):
    assert words in read(render(replace(example(), verdict=verdict))).words


def test_the_least_report_is_a_base_model():
    step = ReportStep("Kelvin-Voigt", "base model", equations(False), (), 0.0051, float("nan"))
    reader = read(render(Report("Adequate", "adequate", ("Nothing is missing.",), 0.005, (step,))))
    for absent in ("Ranking", "Tests of the residual", "What to measure next", "nan"):
        assert absent not in reader.words
    assert "1.02" in reader.words


def test_a_test_that_this_record_cannot_decide_is_not_called_passed(page):
    untold = [test for test in example().final_tests if np.isnan(test.statistic)]
    assert untold
    assert page.count('class="result untold"') >= len(untold)


def test_no_report_without_a_model():
    with pytest.raises(ValueError, match="base model"):
        Report("Title", "adequate", (), 0.005, ())


@settings(max_examples=10, deadline=None)
@given(st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs")), max_size=40))
def test_any_name_is_shown_as_it_is(name):
    step = ReportStep(name, "", (), (), 0.0051, 0.0052)
    parsed = read(render(Report("Title", "adequate", (), 0.005, (step,))))
    assert name in "".join(parsed.text)


def test_a_value_at_its_limit_is_marked_and_what_that_means_is_said():
    report = example()
    value = replace(report.steps[0].parameters[0], at_limit=True)
    steps = (replace(report.steps[0], parameters=(value,)), report.steps[1])
    marked = read(render(replace(report, steps=steps, exhaustion="The tolerance is used up.")))
    assert marked.words.count("at its limit") == 1
    assert "The tolerance is used up." in marked.words
    assert "at its limit" not in read(render(report)).words


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_no_column_of_a_table_is_cut_in_a_window_of_usual_width(tmp_path):
    report = example()
    long = ReportParameter(
        "yield", r"\text{yield displacement}", -1.168e-4, -1.233e-4, -1.102e-4, "m"
    )
    ranking = tuple(replace(each, parameters=(long,) * 3) for each in report.ranking)
    count = (
        "<script>document.body.dataset.cut = [...document.querySelectorAll('.wide')].filter("
        "box => box.querySelector('table') && box.scrollWidth > box.clientWidth).length</script>"
    )
    file = tmp_path / "report.html"
    file.write_text(render(replace(report, ranking=ranking)) + count, encoding="utf-8")
    command = [CHROMIUM, "--headless=new", "--no-sandbox", "--disable-gpu", "--dump-dom"]
    command += ["--window-size=1100,800", f"--user-data-dir={tmp_path / 'profile'}"]
    command += ["--host-resolver-rules=MAP * ~NOTFOUND"]
    run = subprocess.run(
        [*command, file.as_uri()], capture_output=True, text=True, timeout=120, check=True
    )
    assert 'data-cut="0"' in run.stdout


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_a_browser_draws_all_plots_without_a_network(page, tmp_path):
    file = tmp_path / "report.html"
    file.write_text(page, encoding="utf-8")
    command = [CHROMIUM, "--headless=new", "--no-sandbox", "--disable-gpu", "--dump-dom"]
    command += ["--enable-logging=stderr", f"--user-data-dir={tmp_path / 'profile'}"]
    command += ["--host-resolver-rules=MAP * ~NOTFOUND", "--virtual-time-budget=10000"]
    run = subprocess.run(
        [*command, file.as_uri()], capture_output=True, text=True, timeout=120, check=True
    )
    profiles = len(example().signals[0].base_localisation.profiles)
    assert run.stdout.count("<canvas") == 2 + profiles
    complaints = [line for line in run.stderr.splitlines() if "CONSOLE" in line]
    assert not complaints
