"""The friction of a model in a joint of MuJoCo: which values it reads, and the joint's force."""

from __future__ import annotations

import datetime
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="mujoco is not installed: pip install mujoco")
import mujoco

import tissue_probe as tp
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.model_file import Data, DataFile
from tissue_probe.physics.rigs import FORCE_DRIVEN

MASS, DAMPING, DRY, MORE = 95.0, 203.0, 20.0, 4.0
SCENE = """
<mujoco>
  <option timestep="1e-4" integrator="implicitfast" gravity="0 0 0"/>
  <include file="joint.xml"/>
  <worldbody><body>
    <joint name="axis" class="identified" type="slide" axis="1 0 0"/>
    <geom size=".1" mass="95"/>
  </body></worldbody>
  <actuator><velocity joint="axis" kv="1e6"/></actuator>
</mujoco>
"""


def model(*effects: str, **values: float) -> FittedModel:
    composition = Composition(FORCE_DRIVEN, effects=tuple(EFFECTS[name] for name in effects))
    entries = composition.entries(map(str, composition.model.values))
    known = {entry.name: entry.default for entry in entries}
    known |= {"tip_mass": MASS, "stiffness": 0.0, "damping": DAMPING, **values}
    return FittedModel(composition, known, {"damping": 2.0, "coulomb_force": 0.5})


@pytest.fixture
def joint(tmp_path):
    found = model("coulomb_friction", "added_mass", coulomb_force=DRY, added_mass=MORE)
    tp.mujoco_joint(found).save(tmp_path / "joint.xml")
    (tmp_path / "scene.xml").write_text(SCENE)
    return mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))


def test_mujoco_reads_the_values_back(joint):
    assert joint.dof_damping[0] == pytest.approx(DAMPING)
    assert joint.dof_frictionloss[0] == pytest.approx(DRY)
    assert joint.dof_armature[0] == pytest.approx(MORE)


@pytest.mark.parametrize("speed", [-0.1, -0.02, 0.01, 0.1])
def test_the_joint_holds_a_speed_with_the_force_of_the_model(joint, speed):
    data = mujoco.MjData(joint)
    data.ctrl[0] = speed
    for _ in range(5000):
        mujoco.mj_step(joint, data)
    assert data.qvel[0] == pytest.approx(speed, rel=0.01)
    needed = DRY * np.sign(speed) + DAMPING * data.qvel[0]
    assert data.actuator_force[0] == pytest.approx(needed, rel=0.01)


def test_a_push_accelerates_the_mass_and_what_moves_along(joint):
    data = mujoco.MjData(joint)
    data.qfrc_applied[0] = 100.0
    joint.actuator_gainprm[0], joint.actuator_biasprm[0] = 0.0, 0.0
    mujoco.mj_step(joint, data, 1000)
    expected = (100.0 - DRY) / DAMPING * -np.expm1(-DAMPING * data.time / (MASS + MORE))
    assert data.qvel[0] == pytest.approx(expected, rel=0.01)


def test_the_file_tells_errors_range_and_parts_that_no_joint_has(tmp_path):
    found = model(
        *("stribeck_friction", "force_bias"),
        stribeck_coulomb_force=DRY, breakaway_excess=5.0, stribeck_velocity=0.01, force_bias=1.0,
    )  # fmt: skip
    data = Data(
        files=(DataFile(name="axis--1.csv", sha256="0" * 64),), date=datetime.date(2026, 11, 30),
        noise=1e-6, rmse_training=1e-6, rmse_heldout=1e-6,
        lowest=-0.1, highest=0.2, fastest=0.15,
    )  # fmt: skip
    result = tp.mujoco_joint(replace(found, data=data))
    result.save(tmp_path / "joint.xml")
    text = (tmp_path / "joint.xml").read_text()
    assert "damping 203 +- 3.9 N s/m" in text
    assert "fitted to axis- -1.csv on 2026-11-30: held between -100 mm and 200 mm, up to" in text
    assert "MuJoCo has no Stribeck friction: the 5 N that it takes more to break away" in text
    assert "nothing like force_bias: left out" in text
    assert 'frictionloss="20"' in text
    mujoco.MjModel.from_xml_path(str(tmp_path / "joint.xml"))


def test_damping_of_tissue_is_told_as_such_and_what_may_be_nothing(tmp_path):
    stiff = replace(model(stiffness=400.0), deviations={"stiffness": 1.0, "damping": 300.0})
    text = tp.mujoco_joint(stiff).text
    assert "400 +- 2 N/m is the tissue's and not in the class" in text
    assert "not told, may be 0: damping" in text
    assert "does not say where its numbers held" in text


def test_names_that_no_file_takes_and_files_that_are_no_model_are_refused(tmp_path):
    with pytest.raises(tp.TissueProbeError, match="`class_name` 'a b': give letters"):
        tp.mujoco_joint(model(), class_name="a b")
    with pytest.raises(tp.TissueProbeError, match=r"none\.yaml"):
        tp.mujoco_joint(tmp_path / "none.yaml")
