"""What is said of a diagnosis, and its ranking in print, of stand-ins for fits."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from rich.console import Console

from tissue_probe.analysis import tables
from tissue_probe.analysis.verdict_in_words import verdict
from tissue_probe.cli.diagnose import tabulate_ranking
from tissue_probe.diagnosis.advice.separation import Suggestion
from tissue_probe.diagnosis.diagnosis import Diagnosis
from tissue_probe.diagnosis.evidence.conclusion import Ladder
from tissue_probe.diagnosis.evidence.posterior import ModelPosterior
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.physics.rigs import RIGID_PROBE
from tissue_probe.quantities import FORCE

NOISE = 5e-3


def fit(*names, error=NOISE, heldout=None):
    effects = [
        SimpleNamespace(name=n, family="friction", told=lambda values, n=n: f"{n} is so")
        for n in names
    ]
    composition = SimpleNamespace(names=names, effects=effects, rig=RIGID_PROBE, tissue="")
    return SimpleNamespace(
        composition=composition,
        rmse=error,
        heldout_rmse=error if heldout is None else heldout,
        noise=NOISE,
        ratio=error / NOISE,
        excess=math.sqrt(max(error**2 - NOISE**2, 0.0)),
        output=FORCE,
        converged=True,
        exhausted=(),
        entries=(),
        measurements=(SimpleNamespace(position=np.zeros(1)),),
        named=dict,
        deviations=dict,
        names=(),
        covariance=np.zeros((0, 0)),
    )


def told(
    kind, steps=(), base=None, ranking=(), rivals=(), spoilt=(), unseen=(), suggestion=None,
    validated=(), family=None, findings=(),
):  # fmt: skip
    found = "adequate" if kind == "missing" and not steps else kind
    asked = base or fit(error=0.03)
    models = rivals or steps[-1:] or (asked,)
    shares = (1.0 / len(models),) * len(models)
    known = ModelPosterior(asked, models, shares, 0.02)
    ladder = Ladder(asked, ranking or steps, steps, models, known, found, family)
    diagnosis = Diagnosis(
        kind, ladder, spoilt, findings, ladder.tied, unseen, suggestion, dict(validated), 1.0
    )
    return verdict(diagnosis)


def test_what_is_missing_lowers_the_error_on_held_out_data():
    said, meaning, errors, following = told("missing", (fit("a", heldout=0.006),))
    # All models have 0.98; if none is right, a is still there in two of five.
    assert said == "Missing: a (probability 0.99)."
    assert meaning == "a: a is so."
    assert errors == "Errors, rms: fitted 30 mN -> 5 mN, held-out parts 30 mN -> 6 mN; noise 5 mN."
    assert following.startswith("Next recording: the same specimen, moved otherwise")


def test_a_second_recording_has_its_error_and_asks_for_no_other():
    tried = {(): 0.04, ("a",): 0.005}
    *_, errors = told("missing", (fit("a"),), validated=tried.items())
    assert "second recording 40 mN -> 5 mN; noise 5 mN (second recording " in errors


def test_of_a_converter_alone_no_fall_is_told():
    said, errors, unseen, _ = told(
        "missing", base=fit(), spoilt=("adc_saturation",), unseen=("force_lag",)
    )
    assert said == (
        "Missing: adc_saturation. The samples concerned were left out. On the others the model is "
        "adequate: its error is 1.00 times the noise."
    )
    assert errors == "Errors, rms: fitted 5 mN, held-out parts 5 mN; noise 5 mN."
    assert unseen == "This excitation could not have shown: force_lag."


MODELS = (fit("a"), fit("b"))
CHIRP = {"kind": "chirp", "start": 1.0, "stop": 60.0, "amplitude": 1e-3, "duration": 4.0}


@pytest.mark.parametrize(
    ("apart", "words"),
    [(3.456, "In it the wrong one would leave 3.46 times the noise."), (math.nan, None)],
)
def test_of_several_it_is_told_what_could_not_be_seen_and_how_far_an_experiment_separates(
    apart, words
):
    suggestion = Suggestion(CHIRP, 0.0, 4.0, apart)
    first, *meanings, _, unseen, experiment = (
        each
        for each in told(
            "ambiguous", MODELS[:1], rivals=MODELS, unseen=("mains_hum",), suggestion=suggestion
        )
        if each != words
    )
    assert first == "One of a (0.50), b (0.49): this recording cannot tell which."
    assert sorted(meanings) == ["a: a is so.", "b: b is so."]
    assert unseen == "This excitation could not have shown: mains_hum."
    assert experiment == (
        "Next experiment: a sweep from 1 to 60 Hz within 4 s, 1 mm to either side of the place of "
        "first touch at the tip, for 4 s from rest."
    )


def test_a_family_is_told_where_none_of_its_forms_is_sure():
    near = fit("a", error=1.15 * NOISE)
    said, *_ = told("ambiguous", (near,), family="friction")
    assert said.startswith(
        "Missing: friction (probability 1.00); its form is not settled. Nearest: a, which leaves "
        "1.15 times the noise."
    )


def test_the_nearest_is_named_where_it_lowers_the_error():
    said, _, errors, *_ = told("unexplained", (fit("a", error=0.02),))
    assert "Nearest: a." in said
    assert "held-out parts 30 mN -> 20 mN" in errors


def test_of_a_motion_that_goes_one_way_no_effect_is_named():
    way = (Finding("one_way", "It goes one way."),)
    said = " ".join(told("unexplained", (fit("a", error=0.02),), findings=way))
    assert "None is named" in said
    assert "Unload the tissue" in said
    assert "Nearest" not in said
    assert "a: a is so" not in said
    assert "a: a is so." in told("missing", (fit("a"),), findings=way)


def test_nothing_is_near_that_raises_the_error_on_held_out_data():
    worse = fit("a", error=0.02, heldout=0.04)
    said, *_ = told("unexplained", (worse,))
    assert "Nearest" not in said
    assert "No effect lowers the error on held-out data, a neither, which fits best." in said
    better = fit("b", error=0.025)
    said, *_ = told("unexplained", (worse,), ranking=(worse, better))
    assert "a, which fits best, raises the error on held-out data." in said
    said, *_ = told(
        "unexplained", (worse,), ranking=(worse, better), validated={("a",): 0.05}.items()
    )
    assert "No effect lowers" in said


def test_where_nothing_explains_the_samples_of_the_converter_are_told():
    said, *_ = told("unexplained", spoilt=("stuck_samples",))
    assert said.endswith("In the samples: stuck_samples. The samples concerned were left out.")
    said, *_ = told("unexplained")
    assert said.endswith("brings the error down to the noise.")


def test_no_name_breaks_behind_its_mark_at_80_columns():
    rows = [
        SimpleNamespace(
            effect=name, family=family, probability=0.98765, rmse=0.0123456, heldout_rmse=1.23456,
            gain=-12345.0, converged=False,
        )
        for name, family in (
            ("load_cell_stiffness_error", "time-varying"), ("standard_linear_solid", "relaxation"),
        )
    ]  # fmt: skip
    result = SimpleNamespace(
        ranking=tables.rank_effects(SimpleNamespace(ranking=rows, carries_over=None), FORCE),
        ladder=SimpleNamespace(rows=((0, "Kelvin-Voigt", 0.03, 0.03, 6.0),)),
        converged=True,
        effects=("load_cell_stiffness_error", "standard_linear_solid"),
    )
    console = Console(markup=False, highlight=False, width=80)
    with console.capture() as printed:
        console.print(tabulate_ranking(result))
    lines = printed.get().splitlines()
    assert max(map(len, lines)) <= 80
    for name in ("load_cell_stiffness_error", "standard_linear_solid"):
        assert any(f"│ * {name} " in line for line in lines)
