"""Marks: what counts as right, and how it adds up."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tissue_probe.challenge.grading import GradedDiagnosis, HiddenKind, grade, kind_of


def hidden(*effects, absorbed=()):
    return {"effects": list(effects), "absorbed": list(absorbed)}


def told(verdict, ranking=(), indistinguishable=(), effects=(), unseen=()):
    return GradedDiagnosis.parse(
        {
            "verdict": verdict,
            "ranking": [{"effect": name, "family": "any"} for name in ranking],
            "indistinguishable": list(indistinguishable),
            "effects": list(effects),
            "unseen": list(unseen),
        }
    )


def pair(count):
    return count.right, count.total


def test_first_declared_first_three_and_family_of_one_effect():
    answers = {name: hidden("cubic_stiffening") for name in "abcdefg"}
    diagnoses = {
        "a": told("missing", ["cubic_stiffening", "hertz_contact"]),
        "b": told("ambiguous", ["hertz_contact", "x"], ["hertz_contact", "cubic_stiffening"]),
        "c": told("missing", ["hertz_contact", "x", "cubic_stiffening"]),
        "d": told("missing", ["mains_hum", "x", "y", "cubic_stiffening"]),
        "e": told("adequate", ["cubic_stiffening"]),
        "f": told("unexplained", ["cubic_stiffening"]),
    }
    marks = grade(answers, diagnoses)
    assert pair(marks.first) == (1, 7)
    assert pair(marks.declared) == (2, 7)
    assert pair(marks.first_three) == pair(marks.first_three_named) == (2, 7)
    assert pair(marks.family) == (3, 7)
    assert pair(marks.covered) == (2, 4)
    assert marks.claimed == [1, 2, 1, 1]
    assert marks.mean_claimed == pytest.approx(1.25)
    assert marks.undiagnosed == ["g"]
    assert marks.confusion == {
        "cubic_stiffening": {
            "cubic_stiffening": 1,
            "hertz_contact": 2,
            "mains_hum": 1,
            "adequate": 1,
            "unexplained": 1,
            "no diagnosis": 1,
        }
    }
    assert marks.first.share == pytest.approx(1 / 7)


def test_an_effect_that_could_not_be_seen_is_declared_by_an_adequate_model_that_lists_it():
    answers = {name: hidden("force_gain") for name in "abc"}
    diagnoses = {
        "a": told("adequate", ["x", "y", "force_gain"], unseen=["force_gain"]),
        "b": told("adequate", ["force_gain"], unseen=["force_bias"]),
        "c": told("missing", ["force_bias"], unseen=["force_gain"]),
    }
    marks = grade(answers, diagnoses)
    assert pair(marks.declared) == (1, 3)
    assert pair(marks.first) == (0, 3)
    assert pair(marks.first_three) == (1, 3)
    assert pair(marks.first_three_named) == (0, 3)


def test_false_alarms_are_verdicts_other_than_adequate():
    answers = {name: hidden() for name in "abcd"}
    diagnoses = {
        "a": told("adequate", ["mains_hum"]),
        "b": told("missing", ["mains_hum"]),
        "c": told("unexplained"),
    }
    marks = grade(answers, diagnoses)
    assert pair(marks.false_alarms) == (3, 4)
    assert marks.confusion["none"] == {
        "adequate": 1,
        "mains_hum": 1,
        "unexplained": 1,
        "no diagnosis": 1,
    }


def test_two_effects_are_found_in_any_order_but_not_behind_others():
    answers = {name: hidden("backlash", "mains_hum") for name in "abcd"}
    diagnoses = {
        "a": told("missing", ["mains_hum"], effects=["mains_hum", "backlash"]),
        "b": told("missing", ["mains_hum"], effects=["mains_hum", "x", "backlash"]),
        "c": told("missing", ["x"], effects=["x", "y"]),
        "d": told("missing", ["mains_hum"], effects=["mains_hum"]),
    }
    marks = grade(answers, diagnoses)
    assert pair(marks.two) == (1, 4)
    assert pair(marks.two_declared) == (1, 4)
    assert pair(marks.one_of_two) == (3, 4)
    assert marks.confusion["backlash + mains_hum"] == {"mains_hum": 3, "x": 1}


def test_of_two_effects_one_may_be_declared_unseen_but_not_both():
    answers = {name: hidden("backlash", "mains_hum") for name in "ab"}
    diagnoses = {
        "a": replace(told("missing", ["mains_hum"], effects=["mains_hum"]), unseen={"backlash"}),
        "b": replace(told("adequate"), unseen={"backlash", "mains_hum"}),
    }
    marks = grade(answers, diagnoses)
    assert pair(marks.two) == (0, 2)
    assert pair(marks.two_declared) == (1, 2)


def test_what_the_library_lacks_must_be_called_unexplained():
    answers = {name: hidden("prandtl_tomlinson") for name in "ab"}
    diagnoses = {
        "a": told("unexplained", ["coulomb_friction"]),
        "b": told("missing", ["coulomb_friction"]),
    }
    assert pair(grade(answers, diagnoses).unexplained) == (1, 2)


def test_a_fault_of_the_converter_must_be_told_by_name():
    answers = {name: hidden("adc_saturation") for name in "abc"}
    diagnoses = {
        "a": told("unexplained", ["adc_saturation"]),
        "b": told("adc_saturation"),
        "c": told("missing", ["stiffness_step"]),
    }
    assert pair(grade(answers, diagnoses).spoilt) == (2, 3)


def test_of_what_kelvin_voigt_absorbs_adequate_is_right():
    answers = {name: hidden("force_gain", absorbed=["force_gain"]) for name in "abcd"}
    diagnoses = {
        "a": told("adequate"),
        "b": told("missing", ["force_gain"]),
        "c": told("ambiguous", ["force_lag"], ["force_lag", "force_gain"]),
        "d": told("missing", ["force_lag"]),
    }
    marks = grade(answers, diagnoses)
    assert pair(marks.absorbed) == (3, 4)
    assert pair(marks.first) == (0, 0)
    assert marks.first.share is None


@pytest.mark.parametrize(
    ("answer", "kind"),
    [
        (hidden(), HiddenKind.none),
        (hidden("mains_hum"), HiddenKind.one),
        (hidden("force_gain", absorbed=["force_gain"]), HiddenKind.absorbed),
        (hidden("force_gain", "mains_hum"), HiddenKind.two),
        (hidden("rate_stiffening"), HiddenKind.outside),
        (hidden("stuck_samples"), HiddenKind.spoilt),
    ],
)
def test_kinds(answer, kind):
    assert kind_of(answer) is kind


@pytest.mark.parametrize(
    "wrong",
    [
        {},
        {"verdict": "missing", "ranking": ["x"], "indistinguishable": [], "effects": []},
        {"verdict": "missing", "ranking": None, "indistinguishable": [], "effects": []},
    ],
)
def test_a_diagnosis_of_another_shape_is_refused(wrong):
    with pytest.raises(ValueError, match="verdict, ranking, indistinguishable, effects, unseen"):
        GradedDiagnosis.parse(wrong)
