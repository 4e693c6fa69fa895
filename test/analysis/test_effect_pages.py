"""The page of an effect: its equations, values, experiments, and that a new effect gets one."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from tissue_probe.analysis.effect_pages import write_pages
from tissue_probe.analysis.effect_pages.equations import equations
from tissue_probe.analysis.effect_pages.experiments import best, outcomes
from tissue_probe.analysis.symbols import letter
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.library import load_effects

ROOT = Path(__file__).parents[2]
(MINE,) = load_effects(ROOT / "docs" / "my_effect.py")
SOME = {name: EFFECTS[name] for name in ("cubic_stiffening", "added_mass")} | {MINE.name: MINE}


@pytest.fixture(scope="module")
def pages(tmp_path_factory) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("pages")
    write_pages(folder, SOME)
    assert {path.stem for path in folder.glob("*.png")} == set(SOME)
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in folder.glob("*.png"))
    return {path.stem: path.read_text(encoding="utf-8") for path in folder.glob("*.md")}


def test_every_effect_that_is_given_has_a_page_a_new_one_too(pages):
    assert set(pages) == {*SOME, "index"}
    for name in SOME:
        assert f"[{name}]({name}.md)" in pages["index"]


@pytest.mark.parametrize("name", SOME)
def test_a_page_has_what_its_effect_declares(pages, name):
    effect, text = SOME[name], pages[name]
    for said in (effect.physics, effect.family, effect.assumptions, effect.reference):
        assert said in text
    for each in effect.parameters:
        row = re.search(rf"^\| `{each.name}` \|.*$", text, re.M)[0]
        assert f"| {each.unit} | {each.default:g} | {each.lower:g} | {each.upper:g} |" in row


def test_a_mass_that_the_plain_model_takes_up_shows_by_a_calibration_only(pages):
    assert "None of the experiments" in pages["added_mass"]
    assert "A calibration tells it: weigh" in pages["added_mass"]


def test_an_effect_that_shows_has_an_experiment_and_a_residual_in_numbers(pages):
    text = pages["cubic_stiffening"]
    left, times = re.search(r"leaves ([\d.]+) mN, ([\d.]+) times the noise", text).groups()
    assert float(left) > 10.0
    assert float(times) > 5.0
    rows = re.findall(r"^\| (?:sine|multisine|chirp),.*$", text, re.M)
    assert len(rows) == 6
    assert all("[quadratic_drag]" in row for row in rows)


@pytest.mark.parametrize(
    ("name", "value"),
    [("cubic_stiffening", "cubic_stiffness"), (MINE.name, "drag_coefficient")],
)
def test_the_lines_of_python_of_a_page_run(name, value, pages, tmp_path, monkeypatch, capsys):
    (tmp_path / "examples").mkdir()
    shutil.copy(ROOT / "examples" / "sweep.csv", tmp_path / "examples")
    shutil.copy(ROOT / "docs" / "my_effect.py", tmp_path)
    monkeypatch.chdir(tmp_path)
    snippet = re.search(r"^```python\n(.*?)^```", pages[name], re.M | re.S)[1]
    exec(compile(snippet, "page", "exec"), {})
    assert value in capsys.readouterr().out


def test_a_lag_and_a_delay_take_each_others_place_and_a_spring_does_not():
    names = "force_lag", "channel_delay", "cubic_stiffening"
    told = outcomes({name: EFFECTS[name] for name in names})
    assert best(told["force_lag"]).passing == ("channel_delay",)
    assert best(told["channel_delay"]).passing == ("force_lag",)
    assert best(told["cubic_stiffening"]).passing == ()


def test_an_effect_that_contains_another_is_no_rival_of_it():
    told = outcomes({name: EFFECTS[name] for name in ("contact_loss", "hertz_contact")})
    assert not best(told["contact_loss"]).rivals
    assert set(best(told["hertz_contact"]).rivals) == {"contact_loss"}


@pytest.mark.parametrize("name", EFFECTS)
def test_the_equations_of_every_effect_hold_its_parameters(name):
    effect = EFFECTS[name]
    lines = " ".join(equations(effect))
    if name in ("springpot", "encoder_interpolation"):  # sums over branches and periods
        assert not lines
        return
    assert all(letter(each.name) in lines for each in effect.parameters)
    assert lines


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("force_bias", "\\text{measured force} = F + F_0"),
        ("channel_delay", "\\text{delay of the force} = T"),
        ("added_mass", "\\text{mass of the tip} = m + m_a"),
    ],
)
def test_an_equation_says_where_an_effect_acts(name, line):
    assert line in equations(EFFECTS[name])
