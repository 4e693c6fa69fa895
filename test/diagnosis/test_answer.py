"""The answer for programs: its layout, its version, and that it can be read again."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from hidden import EXACT, challenge, library, measurement
from pydantic import ValidationError

from tissue_probe.diagnosis.answer import Answer, answer
from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.physics.composition import Composition

DOCS = Path(__file__).parents[2] / "docs"
FEW = library("cubic_stiffening", "mains_hum")


@pytest.fixture(scope="module", params=["cubic_stiffening", "none", "stuck_samples"])
def told(request):
    """Return a diagnosis, and the answer made of it."""
    hidden = () if request.param == "none" else (request.param,)
    made = challenge(21, *hidden, preload=2e-3)
    second = [measurement(made.second)]
    diagnosis = diagnose(Composition(), [measurement(made.recording)], EXACT, FEW, second)
    return diagnosis, answer(diagnosis)


def test_an_answer_can_be_written_and_read(told):
    _, made = told
    assert Answer.model_validate_json(made.model_dump_json()) == made


def test_an_answer_is_what_its_schema_says(told):
    _, made = told
    schema = json.loads((DOCS / "diagnosis.schema.json").read_text(encoding="utf-8"))
    jsonschema.validate(json.loads(made.model_dump_json()), schema)


def test_an_answer_says_what_the_diagnosis_does(told):
    diagnosis, made = told
    ladder = diagnosis.ladder
    assert made.version == 3
    assert made.verdict == diagnosis.verdict
    assert tuple(made.effects) == diagnosis.effects
    assert made.rmse.training.base == ladder.base.rmse
    assert made.rmse.heldout.final == diagnosis.heldout(ladder.final)
    assert made.noise_floor == ladder.base.noise
    assert [step.effects for step in made.ladder] == [
        list(fit.composition.names) for fit in (ladder.base, *ladder.steps)
    ]
    assert [each.effect for each in made.ranking] == [
        *diagnosis.spoilt,
        *(fit.composition.names[-1] for fit in ladder.ranking),
    ]


def test_an_answer_says_how_probable_effects_models_and_families_are(told):
    diagnosis, made = told
    posterior = diagnosis.ladder.posterior
    for each, fit in zip(
        made.ranking[-len(diagnosis.ladder.ranking) :], diagnosis.ladder.ranking, strict=True
    ):
        assert each.probability == posterior.effect(fit.composition.names[-1])
    assert sum(each.probability for each in made.models[: len(posterior.likely)]) >= 0.95
    assert made.models[0].effects == list(diagnosis.ladder.effects)
    assert made.models[0].adequacy < 1.0
    assert made.models[0].heldout_rmse == made.rmse.heldout.final
    assert made.families == posterior.families
    assert made.family is None


def test_whether_a_model_carries_over_is_told_where_a_second_recording_says_so(told):
    diagnosis, made = told
    # What sticks in the second recording is left out there, too.
    assert made.carries_over is True
    final = diagnosis.ladder.final
    far = {**diagnosis.validated, final.composition.names: 10.0 * final.noise}
    assert answer(replace(diagnosis, validated=far)).carries_over is False
    assert answer(replace(diagnosis, validated={})).carries_over is None


def test_every_parameter_has_its_deviation_and_unit(told):
    _, made = told
    values = made.ladder[-1].parameters
    assert values["stiffness"].unit == "N/m"
    assert values["stiffness"].deviation > 0
    assert values["tip_mass"].deviation == 0  # the rig is known
    for each in made.ranking:
        assert set(each.parameters) - {"stiffness", "damping"} or each.family == "data"


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf")])
def test_what_is_no_number_becomes_null(told, number):
    changed = told[1].model_dump()
    changed["rmse"]["heldout"]["final"] = number
    changed["ranking"][0]["heldout_rmse"] = number
    text = Answer.model_validate(changed).model_dump_json()
    read = json.loads(text, parse_constant=pytest.fail)
    assert read["rmse"]["heldout"]["final"] is None
    assert read["ranking"][0]["heldout_rmse"] is None


def test_another_version_and_unknown_fields_are_refused(told):
    changed = told[1].model_dump()
    for more in ({"version": 4}, {"mood": "good"}, {"verdict": "perhaps"}):
        with pytest.raises(ValidationError):
            Answer.model_validate({**changed, **more})


def test_who_read_version_2_finds_all_that_it_had(told):
    kept = told[1].model_dump()
    for name in ("verdict", "effects", "ladder", "rmse", "alternatives", "compared", "models",
                 "families", "ranking", "suggested_excitation"):  # fmt: skip
        assert name in kept
    assert set(kept["rmse"]["heldout"]) == {"base", "final"}


def test_values_of_the_last_model_have_intervals_and_their_errors_correlations(told):
    diagnosis, made = told
    final = diagnosis.ladder.final
    assert made.values
    for each in made.values:
        assert each.low <= final.named()[each.name] <= each.high
        assert each.lower <= each.value <= each.upper
    together = np.array(made.correlations)
    assert together.shape == (len(made.values),) * 2
    np.testing.assert_allclose(np.diag(together), 1.0, atol=1e-6)
    assert np.all(np.abs(together) <= 1.0 + 1e-6)


def test_the_schema_in_the_documents_is_that_of_the_code():
    schema = json.loads((DOCS / "diagnosis.schema.json").read_text(encoding="utf-8"))
    assert schema == Answer.model_json_schema()
