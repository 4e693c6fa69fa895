"""What may be asked of measurements is declared once: Python, command line and page have it all."""

import inspect

import pytest
from typer.testing import CliRunner

import tissue_probe as tp
from tissue_probe.analysis.question import Asked, question
from tissue_probe.analysis.question_items import ITEMS, ITEMS_BY_NAME
from tissue_probe.cli import app
from tissue_probe.cli.question_options import Asked as Options
from tissue_probe.errors import ParameterError
from tissue_probe.workbench.question import StatedQuestion as OfPage
from tissue_probe.workbench.refusal import RequestRefused


def test_python_takes_and_explains_all_that_is_declared():
    assert set(Asked.__annotations__) == set(ITEMS_BY_NAME)
    for function in (tp.compare, tp.diagnose, tp.improve, tp.promises):
        shown = inspect.signature(function).parameters
        said = " ".join(inspect.getdoc(function).split())
        for item in ITEMS:
            assert shown[item.name].default == item.default
            assert item.about in said


def test_the_command_line_has_an_option_for_each(monkeypatch):
    monkeypatch.setenv("COLUMNS", "300")
    for command in ("compare", "diagnose", "improve"):
        told = " ".join(CliRunner().invoke(app, [command, "--help"]).stdout.split())
        for item in ITEMS:
            assert f"--{(item.option or item.name).replace('_', '-')}" in told
            assert " ".join(item.about.split()) in told


def test_nothing_said_on_the_command_line_is_nothing_said_in_python():
    said = Options().keywords()
    assert question(**said) == question()


def test_the_page_states_all_but_files():
    assert set(OfPage().parameters()) == {e.name for e in ITEMS if e.kind not in ("file", "files")}
    stated = OfPage().changed({"prior": {"relaxation": ["10", "0"]}, "course": "held"}).items
    assert (stated["prior"], stated["course"]) == ({"relaxation": 10.0}, "held")
    assert OfPage().changed({"prior": stated["prior"]}).items["prior"] == stated["prior"]
    with pytest.raises(RequestRefused, match="`course` is 'bent'"):
        OfPage().changed({"course": "bent"})


def test_a_keyword_that_is_none_is_refused():
    with pytest.raises(TypeError, match="unexpected keyword argument 'rigg'"):
        tp.compare({}, rigg="rigid_probe")
    with pytest.raises(TypeError, match=r"'force_polarity'; it belongs to `tissue_probe\.read`"):
        tp.compare({}, force_polarity="tension")


@pytest.mark.parametrize(
    ("prior", "said"),
    [
        ({"relaxing": 2.0}, "`prior` relaxing: there is no such effect or family; families are"),
        ({"relaxation": 0.0}, "`prior` relaxation is 0.0; give a number above 0"),
        ({"relaxation": float("nan")}, "give a number above 0"),
    ],
)
def test_odds_of_nothing_known_are_refused(prior, said):
    with pytest.raises(ParameterError, match=said):
        question(prior=prior)


def test_odds_are_of_an_effect_or_of_all_of_its_family_in_each_form():
    asked = question(prior={"relaxation": 10.0, "hertz_contact": 0.5})
    for effect in asked.library.values():
        wanted = {"relaxation": 10.0}.get(effect.family, 1.0)
        wanted = 0.5 if effect.name == "hertz_contact" else wanted
        assert {form.odds for form in effect.every_form} == {wanted}
    assert any("relaxation counts as 10 times as likely" in note for note in asked.notes)


def test_rig_and_all_that_was_said_stand_at_the_head():
    said = {"rig": "rigid_probe", "constants": {"tip_mass": (0.0, 0.0)}, "lowpass": 20.0}
    told = question(**said, starts="auto", prior={"relaxation": 10.0}).head
    assert told == (
        "Asked: rig rigid_probe, tissue kelvin_voigt, constants tip_mass=0+-0, lowpass 20.0, "
        "prior relaxation=10."
    )
    assert question().head == "Asked: rig compliant_probe, tissue kelvin_voigt."


def test_an_effect_that_is_left_out_is_not_tried():
    assert "springpot" in question().library
    left = question(without=["springpot"])
    assert "springpot" not in left.library
    assert "without springpot" in left.head
    with pytest.raises(ParameterError, match="`without` springpod: there is no such effect"):
        question(without="springpod")
