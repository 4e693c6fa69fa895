"""``modulus`` on the command line: sizes with their units, and the answer for programs."""

import json

import pytest

from tissue_probe.physics.composition import Composition
from tissue_probe.physics.model_file import save


@pytest.fixture
def model(tmp_path):
    values = {"stiffness": 300.0, "damping": 4.0, "tip_mass": 0.0, "contact_position": 0.0}
    path = tmp_path / "model.yaml"
    save(path, Composition("rigid_probe"), values, {"stiffness": 3.0, "damping": 0.08})
    return str(path)


@pytest.mark.parametrize(
    ("length", "area"),
    [("20mm", "30mm2"), ("2cm", "0.3cm2"), ("0.02", "3e-5"), ("20mm+-0.4mm", "30mm2+-0.9mm2")],
)
def test_length_and_area_are_written_with_their_units_or_in_si(run, model, tmp_path, length, area):
    answer = tmp_path / "modulus.json"
    outcome = run(
        *("modulus", model, "--gauge-length", length, "--area", area),
        *("--frequency", "0.5", "--frequency", "5", "--json", str(answer)),
    )
    assert outcome.status == 0
    assert "Modulus: 200 +-" in outcome.out
    told = json.loads(answer.read_text())
    assert told["value"] == pytest.approx(200e3)
    assert told["viscosity"] == pytest.approx(4.0 * 0.02 / 30e-6)
    assert [each["frequency"] for each in told["spectrum"]] == [0.5, 5.0]
    relative = told["deviation"] / told["value"]
    assert relative == pytest.approx(0.01 if "+-" not in length else 0.037417, rel=1e-4)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--gauge-length", "20 metres", "--area", "3e-5"), "--gauge-length 20 metres: give 20mm"),
        (("--gauge-length", "20mm", "--area", "30mm"), "--area 30mm: give 30mm2"),
        (("--gauge-length", "20mm"), "--area"),
        ((), "--indenter"),
    ],
)
def test_a_size_that_cannot_be_read_is_told_with_its_option(run, model, arguments, sentence):
    outcome = run("modulus", model, *arguments)
    assert outcome.status == 1
    assert sentence in outcome.err
    assert outcome.err.count("\n") == 1
