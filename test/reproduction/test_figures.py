"""Each figure of the paper: what it shows, and that command and page know it."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tissue_probe.identification.ring_down import ring_down
from tissue_probe.reproduction.experiment import SimulatedTissue, SineExperiment
from tissue_probe.reproduction.filters import EVERY, exact, paper_filters
from tissue_probe.reproduction.finding import describe_settling, error
from tissue_probe.reproduction.table import FIGURES

DOCS = Path(__file__).parents[2] / "docs"
#: Here filters diverge, and another processor's rounding may give other digits.
DIVERGING = ("fig15", "fig16")
PAGE = (DOCS / "reproduction.md").read_text(encoding="utf-8")


@cache
def made(name):
    return FIGURES[name]()


def milliseconds(text):
    """Return the times in a cell, infinite where something is never reached."""
    found = re.findall(r"(\d+) ms|not in", text)
    return [float(each) if each else np.inf for each in found]


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_is_drawn_and_says_something_in_numbers(name):
    figure, findings = made(name).figure, made(name).findings
    for axes in figure.axes:
        assert axes.lines or axes.images or axes.collections
        assert axes.get_ylabel() or axes.get_xlabel() or axes.images
    assert findings
    for row in findings:
        assert re.search(r"\d", row.paper)
        assert "nan" not in row.paper + row.ours
        assert row.stated


@pytest.mark.parametrize("name", ["fig3", "fig4"])
def test_only_fading_follows_a_doubling_and_ours_is_ten_times_faster(name):
    started, changed = made(name).findings
    afekf, ekf = milliseconds(changed.paper)
    (ours,) = milliseconds(changed.ours)
    assert ekf == np.inf
    assert 200.0 < afekf < 600.0
    assert ours < afekf / 10.0
    assert milliseconds(started.ours)[0] < 40.0


def test_contact_is_lost_and_regained_within_a_tenth_of_the_papers_time():
    for row in made("fig11").findings:
        assert milliseconds(row.ours)[0] < milliseconds(row.paper)[0] / 10.0


@pytest.mark.parametrize("name", ["fig9", "fig15"])
def test_stiffness_rises_with_the_tissue_and_euler_adds_to_it(name):
    row = made(name).findings[0]
    true = float(re.search(r"true (\d+)", row.quantity)[1])
    assert float(row.ours.split()[0]) == pytest.approx(true, rel=0.01)
    assert float(re.search(r": (\d+) N/m are Euler's", row.paper)[1]) > 0.05 * true


def test_stiffer_material_takes_the_papers_filter_longer():
    times = milliseconds(made("fig10").findings[0].paper)
    assert times == sorted(times)
    assert len(times) == 4


def test_the_map_finds_the_three_nodules():
    assert made("fig12").findings[0].ours == "3 of 3, 0 false"


def test_the_papers_filters_go_astray_at_high_frequencies_only_and_ours_nowhere():
    failures = made("fig15").findings[1]
    frequencies = re.findall(r"EKF (?:with the exact step )?\d+ from (\d+) Hz", failures.paper)
    assert len(frequencies) == 3  # EKF, AFEKF, EKF with the exact step
    assert min(map(int, frequencies)) >= 15
    assert failures.ours == "0"


@pytest.mark.parametrize("each", EVERY[:3])
def test_the_papers_filters_have_no_bound_that_they_meet(each):
    """What makes them fail must not be ours."""
    widened = each.settings.model_copy(update={"deviation_ceiling": 1e5})
    experiment = SineExperiment(((0.0, SimulatedTissue(500.0, 10.0)),), duration=1.0)
    first, second = (replace(each, settings=s).run(experiment) for s in (each.settings, widened))
    for one, other in zip(first.arrays(), second.arrays(), strict=True):
        np.testing.assert_array_equal(one, other)


def test_the_free_probe_rings_as_its_equation_says():
    time = np.linspace(0.0, 0.2, 20001)
    force = ring_down(time, 9700.0, 0.8, 0.04, 8e-3)
    x, step = force / 9700.0, time[1]
    residual = 0.04 * np.gradient(np.gradient(x, step), step) + 0.8 * np.gradient(x, step) + force
    assert np.abs(residual[5:-5]).max() < 1e-3 * np.abs(force).max()


def test_settling_counts_from_the_last_time_outside_five_per_cent():
    truth = np.full(100, 10.0)
    values = truth.copy()
    assert describe_settling(values, truth) == "0 ms"
    values[40] = 11.0
    assert describe_settling(values, truth) == f"{41 * 0.5:.0f} ms"
    values[-1] = np.nan
    assert describe_settling(values, truth).startswith("not in")
    assert (
        describe_settling(values[:-1] * 0.0, truth[:-1] * [*[1.0] * 10, *[0.0] * 89], 0.005)
        == "0 ms"
    )


def test_the_error_is_that_of_the_last_tenth_of_a_second():
    truth = np.full(1000, 10.0)
    values = np.where(np.arange(1000) < 800, 0.0, 10.1)
    assert error(values, truth) == "+1.00 %"


def test_the_exact_filter_differs_from_the_papers_in_its_step_only():
    for each in paper_filters(EVERY[0].settings):
        changed = exact(each).settings.model_dump()
        kept = each.settings.model_dump()
        assert {name for name in kept if kept[name] != changed[name]} == {"discretisation"}


@pytest.mark.parametrize("name", FIGURES)
def test_the_page_shows_every_figure_and_the_table_that_is_printed(name):
    number = name.removeprefix("fig")
    assert re.search(rf"!\[Figure {number}\b[^]]*\]\(images/reproduction/{name}\.png\)", PAGE)
    assert (DOCS / "images" / "reproduction" / f"{name}.png").stat().st_size > 10_000
    for row in made(name).findings:
        numbers = "" if name in DIVERGING else f" {row.paper} | {row.ours} |"
        assert f"| {number} | {row.quantity} | {row.stated} |{numbers}" in PAGE


def test_the_command_leaves_png_and_svg_and_prints_the_table(run, tmp_path):
    said = run("reproduce", "fig6", "--folder", "made")
    assert {path.name for path in (tmp_path / "made").iterdir()} == {"fig6.png", "fig6.svg"}
    assert "9700 N/m" in said


def test_an_unknown_figure_is_told_in_one_sentence(run):
    said = run("reproduce", "fig5")
    assert said.startswith("tissue_probe: there is no fig5; there are fig3, fig4, fig6")
    assert "\n" not in said


def test_the_help_names_every_figure(run):
    said = run("reproduce", "--help")
    assert "fig3, fig4, fig6 to fig12, fig14 to fig16, or all" in " ".join(said.split())
    assert list(FIGURES) == [f"fig{n}" for n in (3, 4, *range(6, 13), *range(14, 17))]
