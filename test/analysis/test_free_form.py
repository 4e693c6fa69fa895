"""Where no law explains a record, its shape is told, and becomes an effect of the user's own."""

import numpy as np
import pytest

import tissue_probe as tp
from tissue_probe.analysis.passing import from_bytes, to_bytes
from tissue_probe.errors import ParameterError
from tissue_probe.physics.effects import EFFECTS

pytestmark = pytest.mark.usefixtures("sketched")

RATE = 1000.0
ASKED = {
    "rig": "rigid_probe",
    "constants": {"tip_mass": 0.0},
    "starts": "moving",
    "without": [name for name in EFFECTS if name not in ("cubic_stiffening", "force_drift")],
}

OWN = """
import sympy as sp
from tissue_probe.physics.effects.effect import ELASTIC_DEPTH, Effect, Parameter
GAIN = Parameter(sp.Symbol("third_gain", real=True), "N/m^3", 1e7, -1e12, 1e12)
THIRD = Effect("third", "stiffening", "a cubic of one's own", (GAIN,),
               force=GAIN.symbol * ELASTIC_DEPTH**3)
"""


def record(seed, size=1.0, drag=40.0):
    """Return a record of a spring, a damper and drag that grows with the square of the speed."""
    random = np.random.default_rng(seed)
    t = np.arange(2000) / RATE
    w = 2.0 * np.pi * np.linspace(1.0, 23.0, 12)
    angle = np.multiply.outer(t, w) + random.uniform(0.0, 2.0 * np.pi, w.size)
    x, v = 3e-4 * size * np.sin(angle).sum(axis=1), 3e-4 * size * (w * np.cos(angle)).sum(axis=1)
    force = 400.0 * x + 4.0 * v + drag * v * np.abs(v) + 5e-3 * random.standard_normal(t.size)
    return {"time": t, "position": x, "force": force}


@pytest.fixture(scope="module")
def unexplained():
    return tp.diagnose(record(0), **ASKED)


def test_the_variables_of_an_unexplained_force_are_told(unexplained):
    assert unexplained.verdict == "unexplained"
    assert "% of the missing force is a function of the velocity; " in unexplained.text
    rows = {row["variable"]: row for row in unexplained.shape}
    assert rows["velocity"]["alone"] > 0.98
    assert rows["indentation"]["beyond"] < 0.02
    shape = unexplained.to_dict()["shape"]
    assert shape["variables"] == ["velocity"]
    assert shape["formula"]["formula"] == "c * sign(velocity) * abs(velocity / 0.1)**a"
    assert len(shape["curve"]["grid"]) == len(shape["curve"]["value"]) == len(shape["curve"]["sd"])


@pytest.mark.drawn
def test_report_and_page_draw_the_shape(unexplained, tmp_path):
    assert unexplained.draw_shape().startswith("<svg")
    unexplained.report(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.count("Shape of the missing force") == 1
    shape = unexplained.found.shape
    without, with_it = (1e3 * fit.heldout_rmse for fit in (shape.fit, shape.as_effect.fit))
    assert f"{without:.3g} mN without the shape, {with_it:.3g} mN with it" in page


def test_a_learnt_shape_goes_to_a_process_that_has_not_its_effect(unexplained):
    again = from_bytes(to_bytes(unexplained))
    assert again.found.shape.as_effect.fit.composition.names == ("free_form",)
    one, other = (each.found.shape.curve.value for each in (again, unexplained))
    np.testing.assert_array_equal(one, other)


@pytest.mark.drawn
def test_where_nothing_is_missing_no_shape_is_drawn(tmp_path):
    adequate = tp.diagnose(record(0, drag=0.0), **ASKED)
    assert adequate.draw_shape() is None
    adequate.report(tmp_path / "report.html")
    assert "Shape of the missing force" not in (tmp_path / "report.html").read_text("utf-8")


@pytest.mark.drawn
def test_the_shape_becomes_an_effect_that_explains_a_second_recording(tmp_path):
    again = tp.improve(record(0), validate=record(1, 0.6), output=tmp_path, free_form=True, **ASKED)
    assert again.effects == ("free_form",)
    assert again.found.carries_over
    assert (tmp_path / "shape.png").exists()
    model = tp.compare(
        record(2, 0.6), model=tmp_path / "model.yaml", effects=[tmp_path / "my_effect.py"]
    )
    assert model.fit.rmse < 1.1 * 5e-3
    with pytest.raises(ParameterError, match=r"my_effect.py is there already"):
        tp.improve(record(0), output=tmp_path, free_form=True, **ASKED)


def test_effects_to_add_and_a_learnt_shape_exclude_each_other(tmp_path):
    with pytest.raises(ParameterError, match="leave out `add`"):
        tp.improve(record(0), add=["force_bias"], output=tmp_path, free_form=True, **ASKED)


def test_where_the_second_recording_alone_is_unexplained_there_is_no_shape(tmp_path):
    with pytest.raises(ParameterError, match="explains the fitted recording, and not that of"):
        tp.improve(
            record(0, drag=0.0), validate=record(1), output=tmp_path, free_form=True, **ASKED
        )


def test_the_picture_of_an_earlier_shape_does_not_stay(tmp_path):
    (tmp_path / "shape.png").write_bytes(b"an earlier one")
    tp.improve(record(0, drag=0.0), output=tmp_path, **ASKED)
    assert (tmp_path / "story.png").exists()
    assert not (tmp_path / "shape.png").exists()


def test_one_file_of_own_effects_beside_a_learnt_shape_is_one(tmp_path):
    own = tmp_path / "own.py"
    own.write_text(OWN)
    again = tp.improve(
        record(0), effects=str(own), output=tmp_path / "kept", free_form=True,
        **{**ASKED, "without": [*ASKED["without"], "third"]},
    )  # fmt: skip
    assert again.effects == ("free_form",)


def test_where_nothing_is_missing_there_is_no_free_form(tmp_path):
    with pytest.raises(ParameterError, match="the verdict is adequate: no shape was learnt"):
        tp.improve(record(0, drag=0.0), output=tmp_path, free_form=True, **ASKED)
