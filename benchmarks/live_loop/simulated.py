"""Whether a contact written for MuJoCo has the stiffness, damping and force that were measured.

Contents: a slider and the arm of `arm`, each with a tip on tissue, driven by servos; the force that
MuJoCo makes against the depth that it has.

The tip presses 2 mm deep, and to and fro by 1 mm. Stiffness and damping are regressed on depth and
speed of MuJoCo's own contact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from benchmarks.live_loop.arm import HOME, XML, Array, straight

PRELOAD, TRAVEL, FREQUENCY = 2e-3, 1e-3, 3.0  # m, Hz
SETTLING, SECONDS = 1.0, 3.0  # s
RADIUS, REACH = 0.005, 0.12  # m: the tip, and how far it is from the sensor
SLIDER = """
<mujoco>
  <option timestep="{step}" integrator="{integrator}" cone="{cone}"/>
  <worldbody>
    <geom name="tissue" type="plane" size="1 1 .1"/>
    <body pos="0 0 {radius}">
      <joint name="way" axis="0 0 -1" type="slide"/>
      <geom name="tip" type="sphere" size="{radius}" mass=".8" {tip}/>
    </body>
  </worldbody>
  <actuator><position joint="way" kp="5000" kv="100"/></actuator>
  {include}
</mujoco>
"""


@dataclass(frozen=True)
class Felt:
    """What MuJoCo's contact did.

    Attributes
    ----------
    stiffness, damping : float
        Regressed [N/m], [N s/m].
    error : float
        Of the force against that of the contact that was written, rms over rms.
    """

    stiffness: float
    damping: float
    error: float


def slider(
    include: str = "",
    step: float = 1e-3,
    integrator: str = "implicitfast",
    cone: str = "pyramidal",
    tip: str = "",
) -> str:
    """Return a mass of 0.8 kg on a slide, above tissue."""
    return SLIDER.format(
        step=step, integrator=integrator, cone=cone, tip=tip, include=include, radius=RADIUS
    )


def arm(include: str = "", step: float = 1e-3) -> str:
    """Return the arm at home, a servo at each joint, its tip just above tissue."""
    text = XML.format(mass=0.8, com=".03 .02 .04", inertia=".002 .002 .001 0 0 0")
    tip = f'<geom name="tip" type="sphere" size="{RADIUS}" pos="0 0 {REACH}" mass="0"/>'
    text = text.replace('<site name="sensor"/>', f'<site name="sensor"/>{tip}')
    for joint in range(6):
        text = text.replace("<joint axis", f'<joint name="j{joint}" armature=".1" axis', 1)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = HOME
    mujoco.mj_kinematics(model, data)
    site = model.site("sensor").id
    turn = data.site_xmat[site].reshape(3, 3)
    # A box whose face lies before the tip.
    middle = data.site_xpos[site] + (REACH + RADIUS + 0.05) * turn[:, 2]
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, data.site_xmat[site])
    box = (
        f'<geom name="tissue" type="box" size=".1 .1 .05" pos="{_row(middle)}" '
        f'quat="{_row(quaternion)}"/>'
    )
    servos = "".join(f'<position joint="j{n}" kp="40000" kv="800"/>' for n in range(6))
    text = text.replace("<worldbody>", f"<worldbody>{box}", 1)
    text = text.replace("<option ", f'<option timestep="{step}" integrator="implicitfast" ', 1)
    return text.replace("</mujoco>", f"<actuator>{servos}</actuator>{include}</mujoco>")


def _row(values: Array) -> str:
    return " ".join(f"{each:.12g}" for each in values)


def feel(path: Path, stiffness: float, damping: float) -> Felt:
    """Let a model press, and return what its contact does beside what it should do."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    way = _command(model)
    data.qpos[:] = way(0.0)
    depth, force = [], []
    wrench = np.empty(6)
    for _ in range(round((SETTLING + SECONDS) / model.opt.timestep)):
        deep = min(data.time / (0.5 * SETTLING), 1.0) * PRELOAD
        data.ctrl[:] = way(deep + TRAVEL * np.sin(2.0 * np.pi * FREQUENCY * data.time))
        mujoco.mj_step1(model, data)  # depth and force are those of one instant
        mujoco.mj_step2(model, data)
        pressed = -data.contact.dist.sum() if data.ncon else 0.0
        made = 0.0
        for each in range(data.ncon):
            mujoco.mj_contactForce(model, data, each, wrench)
            made += wrench[0]
        depth.append(pressed)
        force.append(made)
    steady = round(SETTLING / model.opt.timestep)
    u, f = np.array(depth)[steady:], np.array(force)[steady:]
    v = np.gradient(u, model.opt.timestep)
    k, beta = np.linalg.lstsq(np.stack([u, v], axis=1), f, rcond=None)[0]
    wanted = stiffness * u + damping * v
    error = np.sqrt(np.mean((f - wanted) ** 2) / np.mean(wanted**2))
    return Felt(float(k), float(beta), float(error))


def _command(model: mujoco.MjModel) -> Callable[[float], Array]:
    """Return the joints at a depth of the tip that no tissue would hold back."""
    if model.nq == 1:
        return lambda depth: np.array([depth])
    ways = np.linspace(-2e-3, 4e-3, 13)
    joints = straight(model, ways)[1]
    return lambda depth: np.array([np.interp(depth, ways, each) for each in joints.T])
