"""A measured contact in MuJoCo: what MuJoCo reads, and what its contact then does."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="mujoco is not installed: pip install mujoco")
import mujoco

import tissue_probe as tp
from benchmarks.live_loop import simulated
from tissue_probe.contact.contact import Contact, ContactNumber

STIFFNESS, DAMPING = 1000.0, 3.0
CONTACT = Contact(
    "adequate",
    ContactNumber(STIFFNESS, 5.0),
    ContactNumber(DAMPING, 0.3),
    *(ContactNumber(0.8, 1e-4), ContactNumber(4e-3, 1e-4)),
    *(0.1, 1.0, 1e-3, 3e-3, 0.025, 1.0, 4.0),
)
INCLUDE = '<include file="contact.xml"/>'


def written(folder: Path, model: str, whole: str) -> Path:
    """Write a contact for a model, and the model that includes it."""
    (folder / "bare.xml").write_text(model)
    made = tp.mujoco_contact(CONTACT, folder / "bare.xml", tip="tip", tissue="tissue")
    made.save(folder / "contact.xml")
    (folder / "whole.xml").write_text(whole)
    return folder / "whole.xml"


@pytest.mark.parametrize(
    "stated",
    [
        {},
        {"integrator": "Euler", "step": 4e-3},
        {"cone": "elliptic"},
        {"tip": 'condim="1"'},
        {"tip": 'priority="2" solref=".02 1"'},
    ],
    ids=lambda stated: ", ".join(map(str, stated.values())),
)
def test_on_a_slide_it_has_the_measured_stiffness_and_force(tmp_path, stated):
    path = written(tmp_path, simulated.slider(**stated), simulated.slider(INCLUDE, **stated))
    felt = simulated.feel(path, STIFFNESS, DAMPING)
    assert felt.stiffness == pytest.approx(STIFFNESS, rel=0.01)
    assert felt.damping == pytest.approx(DAMPING, rel=0.02)
    assert felt.error < 0.01


def test_on_an_arm_it_has_the_measured_stiffness_and_force(tmp_path):
    path = written(tmp_path, simulated.arm(), simulated.arm(INCLUDE))
    felt = simulated.feel(path, STIFFNESS, DAMPING)
    assert felt.stiffness == pytest.approx(STIFFNESS, rel=0.01)
    assert felt.damping == pytest.approx(DAMPING, rel=0.02)
    assert felt.error < 0.01


def test_mujoco_reads_the_values_back_and_friction_stays(tmp_path):
    tip = 'friction=".3 .01 .002" condim="4"'
    path = written(tmp_path, simulated.slider(tip=tip), simulated.slider(INCLUDE, tip=tip))
    model = mujoco.MjModel.from_xml_path(str(path))
    weight = model.body_invweight0[model.geom_bodyid[model.geom("tip").id], 0]
    scale = (1.0 - 1e-4) * weight
    np.testing.assert_allclose(model.pair_solref[0], [-scale * STIFFNESS, -scale * DAMPING])
    np.testing.assert_allclose(model.pair_solimp[0], [1e-4, 1e-4, 0.001, 0.5, 2.0])
    # Of two geoms of one priority the larger counts; the plane has MuJoCo's own.
    np.testing.assert_allclose(model.pair_friction[0], [1.0, 1.0, 0.01, 0.002, 0.002])
    assert model.pair_dim[0] == 4


def test_the_file_tells_the_error_of_the_model_and_the_range(tmp_path):
    written(tmp_path, simulated.slider(), simulated.slider(INCLUDE))
    text = (tmp_path / "contact.xml").read_text()
    assert "100 mN rms, 1 times the noise" in text
    assert "1 to 4 Hz" in text
    assert "several points" not in text


def test_a_tip_with_corners_is_told_to_touch_in_several_points(tmp_path):
    model = tmp_path / "box.xml"
    model.write_text(
        simulated.slider().replace('type="sphere" size="', 'type="box" size=".01 .01 ')
    )
    made = tp.mujoco_contact(CONTACT, model, tip="tip", tissue="tissue")
    assert "several points" in made.text
    doubtful = replace(CONTACT, verdict="missing")
    assert "do not rely" in tp.mujoco_contact(doubtful, model, tip="tip", tissue="tissue").xml
    assert "do not rely" not in made.xml


BOTH_FIXED = """
<mujoco><worldbody><geom name="tip" size=".1"/><geom name="tissue" size=".1"/></worldbody></mujoco>
"""


@pytest.mark.parametrize(
    ("model", "names", "sentence"),
    [
        ("<mujoco>", {}, r"`model` .*: MuJoCo does not read it"),
        (None, {"tip": "finger"}, r"`tip` finger: the model has no such geom; it has tissue, tip"),
        (None, {"tip": "tissue"}, "`tissue` is the `tip`: name two geoms"),
        (BOTH_FIXED, {}, "neither tip nor tissue can move"),
    ],
)
def test_models_without_such_a_contact_are_refused(tmp_path, model, names, sentence):
    path = tmp_path / "model.xml"
    path.write_text(simulated.slider() if model is None else model)
    with pytest.raises(tp.TissueProbeError, match=sentence):
        tp.mujoco_contact(CONTACT, path, **{"tip": "tip", "tissue": "tissue", **names})


def test_without_mujoco_a_sentence_says_how_to_install_it(tmp_path, monkeypatch):
    (tmp_path / "model.xml").write_text(simulated.slider())
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(tp.TissueProbeError, match="MuJoCo, which is not installed: pip install"):
        tp.mujoco_contact(CONTACT, tmp_path / "model.xml", tip="tip", tissue="tissue")
