"""An arm of six joints in MuJoCo with a hidden tool on its force sensor, and a cable to the tool.

Contents: the model, its motion in free air and in contact, pose and wrench as measured.

The joints follow a given motion exactly: MuJoCo's inverse dynamics at each instant gives the load
on the sensor (`force` and `torque` at a site), so no step of time and no controller has an error.
The cable is a spring between a point of the forearm and one of the tool; its force is applied to
the tool's body (`xfrc_applied`), as MuJoCo's force sensors leave tendons out, and so is that of a
tissue under the tip. Where it sags its end
at the forearm is lower by that.

Shares no code with the package.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RATE = 250.0  # Hz
FORCE_NOISE, TORQUE_NOISE = 0.1, 3e-3  # N, N m
PLACE_NOISE, TURN_NOISE = 1e-5, 5e-5  # m, rad
JOINT_NOISE = 2e-5  # rad
FORCE_BIAS, TORQUE_BIAS = 5.0, 0.2  # N, N m
FORCE_DRIFT, TORQUE_DRIFT = 1.0 / 60.0, 0.02 / 60.0  # N/s, N m/s
DELAY = 4e-3  # s: a whole number of samples
MASS = 0.8  # kg
#: How far joints swing [rad], rms: the wrist widely, the arm little, as a flange is turned.
SWINGS = np.array([0.12, 0.12, 0.12, 0.6, 0.6, 0.6])
#: Frequencies of the swings [Hz]: with these the flange turns with 1.8 rad/s rms, .5 m/s2.
SLOWEST, FASTEST = 0.05, 0.45
#: Pressing: half its way, and the middle of it [m]; frequencies, and how often they sweep [Hz].
TRAVEL, PRELOAD = 1e-3, 2e-3
SLOW, FAST, SWEEP = 1.0, 4.0, 0.5
HOME = np.array([0.0, -1.0, 1.6, -0.6, 0.4, 0.0])

XML = """
<mujoco>
  <option gravity="0 0 -9.80665"/>
  <worldbody>
    <body pos="0 0 .15">
      <joint axis="0 0 1"/><geom type="sphere" size=".05" mass="4"/>
      <body>
        <joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 .4" size=".05" mass="8"/>
        <body pos="0 0 .4">
          <joint axis="0 1 0"/>
          <geom type="capsule" fromto="0 0 0 0 0 .35" size=".04" mass="3"/>
          <site name="anchor" pos=".06 .03 .3"/>
          <body pos="0 0 .35">
            <joint axis="0 1 0"/><geom type="sphere" size=".04" mass="1.2"/>
            <body pos="0 .1 0">
              <joint axis="0 0 1"/><geom type="sphere" size=".04" mass="1.2"/>
              <body pos="0 0 .09">
                <joint axis="0 1 0"/><geom type="sphere" size=".03" mass=".3"/>
                <body name="tool" pos="0 .07 0" quat=".70710678 -.70710678 0 0">
                  <site name="sensor"/><site name="end" pos=".05 .02 .08"/>
                  <site name="tip" pos="0 0 .12"/>
                  <inertial pos="{com}" mass="{mass}" fullinertia="{inertia}"/>
                </body>
              </body>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <sensor><force site="sensor"/><torque site="sensor"/></sensor>
</mujoco>
"""


@dataclass(frozen=True)
class Tool:
    """The load of the sensor: mass [kg], centre [m], inertia about it [kg m2], shape (3, 3)."""

    mass: float
    centre: Array
    inertia: Array


@dataclass(frozen=True)
class Cable:
    """A spring from the forearm to the tool: N/m, its length at rest [m], how far it sags [m]."""

    stiffness: float
    length: float = 0.05
    sag: float = 0.0


@dataclass(frozen=True)
class Tissue:
    """A spring and a damper under the tip [N/m], [N s/m]."""

    stiffness: float
    damping: float


@dataclass(frozen=True)
class Measured:
    """A stretch of free air: times [s], pose and wrench as measured, and the wrench without noise.

    ``position`` has shape (n, 3), ``orientation`` (n, 4) as x, y, z, w, ``joints`` (n, 3) those of
    the wrist, ``wrench`` and ``true`` (n, 6): the pull of the load at the sensor, in its axes.
    """

    time: Array
    position: Array
    orientation: Array
    joints: Array
    wrench: Array
    true: Array


class World:
    """One arm with its tool, its sensor's bias and drift; all drawn by the seed.

    Parameters
    ----------
    seed : int
        Of tool, bias, and everything measured.
    cable : Cable or None
        The cable to the tool.
    fade : float
        Time constant with which the drift settles [s]; infinite for a linear one.
    """

    def __init__(self, seed: int, cable: Cable | None = None, fade: float = np.inf) -> None:
        self._random = random = np.random.default_rng(seed)
        self.cable, self._fade = cable, fade
        self.tool = _tool(random)
        text = XML.format(
            mass=self.tool.mass,
            com=" ".join(map(str, self.tool.centre)),
            inertia=" ".join(str(self.tool.inertia[i, j]) for i, j in _UPPER),
        )
        self._model = mujoco.MjModel.from_xml_string(text)
        self._data = mujoco.MjData(self._model)
        scale = np.repeat([FORCE_BIAS, TORQUE_BIAS], 3)
        self._bias = scale * _direction(random)
        self._drift = np.repeat([FORCE_DRIFT, TORQUE_DRIFT], 3) * _direction(random)

    def drifted(self, time: Array) -> Array:
        """Return bias and drift at times [s], shape (n, 6)."""
        passed = time if np.isinf(self._fade) else self._fade * -np.expm1(-time / self._fade)
        return self._bias + passed[:, None] * self._drift

    def move(self, begin: float, seconds: float, speed: float = 1.0) -> Measured:
        """Measure a new motion of joints in free air, which begins at a time [s]."""
        swings = _Swings(self._random, speed)
        time = begin + np.arange(round(seconds * RATE)) / RATE
        return self._measured(time, swings)

    def hold(self, begin: float, seconds: float) -> Measured:
        """Measure one new pose, at rest."""
        swings = _Swings(self._random, 0.0)
        return self._measured(begin + np.arange(round(seconds * RATE)) / RATE, swings)

    def press(self, begin: float, seconds: float, tissue: Tissue) -> tuple[Measured, Array]:
        """Press the tip to and fro on tissue, in a frequency that sweeps up and down.

        Returns the stretch, and the direction of pressing in the world, which is that of the
        sensor's z throughout, shape (3,).
        """
        motion = _Pressing(self._model, self._random)
        time = begin + np.arange(round(seconds * RATE)) / RATE
        return self._measured(time, motion, tissue), motion.axis

    def _measured(
        self, time: Array, swings: _Swings | _Pressing, tissue: Tissue | None = None
    ) -> Measured:
        ahead = round(DELAY * RATE)
        earlier = time[0] - np.arange(ahead, 0, -1) / RATE
        place, turn, load = self._felt(np.concatenate([earlier, time]), swings, tissue)
        place, turn, true, late = place[ahead:], turn[ahead:], load[ahead:], load[: time.size]
        drifted = self.drifted(time)
        random = self._random
        noise = np.repeat([FORCE_NOISE, TORQUE_NOISE], 3) * random.normal(size=true.shape)
        place = place + PLACE_NOISE * random.normal(size=place.shape)
        turn = _turned(turn, TURN_NOISE * random.normal(size=place.shape))
        joints = swings.at(time)[0][:, 3:] + JOINT_NOISE * random.normal(size=place.shape)
        return Measured(time, place, turn, joints, late + drifted + noise, true + drifted)

    def _felt(
        self, time: Array, swings: _Swings | _Pressing, tissue: Tissue | None
    ) -> tuple[Array, Array, Array]:
        """Return place and orientation of the sensor, and the load on it."""
        model, data = self._model, self._data
        tool, site = model.body("tool").id, model.site("sensor").id
        place, turn, load = (np.empty((time.size, n)) for n in (3, 4, 6))
        matrix = np.empty(4)
        for row, (q, qd, qdd) in enumerate(zip(*swings.at(time), strict=True)):
            data.qpos[:], data.qvel[:], data.qacc[:] = q, qd, qdd
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            data.xfrc_applied[tool] = self._pulled()
            if tissue is not None:
                data.xfrc_applied[tool] += self._pushed(tissue, *swings.pressed(time[row]))
            mujoco.mj_inverse(model, data)
            place[row] = data.site_xpos[site]
            mujoco.mju_mat2Quat(matrix, data.site_xmat[site])
            turn[row] = matrix[[1, 2, 3, 0]]
            # MuJoCo tells the parent's force on the child; the sensor feels the opposite.
            load[row] = -data.sensordata
        return place, turn, load

    def _pulled(self) -> Array:
        """Return the cable's force and torque at the middle of the tool's mass, in the world."""
        if self.cable is None:
            return np.zeros(6)
        data, model = self._data, self._model
        end = data.site_xpos[model.site("end").id]
        way = data.site_xpos[model.site("anchor").id] - end
        way[2] -= self.cable.sag
        distance = np.linalg.norm(way)
        force = self.cable.stiffness * max(distance - self.cable.length, 0.0) * way / distance
        arm = end - data.xipos[model.body("tool").id]
        return np.concatenate([force, np.cross(arm, force)])

    def _pushed(self, tissue: Tissue, depth: float, speed: float) -> Array:
        """Return the tissue's force and torque at the middle of the tool's mass, in the world."""
        data, model = self._data, self._model
        axis = data.site_xmat[model.site("tip").id].reshape(3, 3)[:, 2]
        force = -(tissue.stiffness * depth + tissue.damping * speed) * axis
        arm = data.site_xpos[model.site("tip").id] - data.xipos[model.body("tool").id]
        return np.concatenate([force, np.cross(arm, force)])


_UPPER = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


class _Swings:
    """Each joint a sum of sines about its home, of random frequencies and phases."""

    def __init__(self, random: np.random.Generator, speed: float) -> None:
        self._speed = speed
        self._frequency = random.uniform(SLOWEST, FASTEST, (6, 6))
        self._phase = random.uniform(0.0, 2.0 * np.pi, (6, 6))
        self._home = HOME

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """Return angles, speeds, accelerations at times, each of shape (n, 6)."""
        omega = 2.0 * np.pi * self._frequency * self._speed
        phase = omega * time[:, None, None] + self._phase
        swing = (SWINGS / np.sqrt(3.0))[:, None]
        angle = (swing * np.sin(phase)).sum(axis=2)
        speed = (swing * omega * np.cos(phase)).sum(axis=2)
        return self._home + angle, speed, (-swing * omega**2 * np.sin(phase)).sum(axis=2)


class _Pressing:
    """The tip goes to and fro along the sensor's z, which keeps its direction.

    By 2 mm, about 2 mm from the touch, in a frequency that sweeps between ``SLOW`` and ``FAST``.
    """

    def __init__(self, model: mujoco.MjModel, random: np.random.Generator) -> None:
        way = np.linspace(-0.5e-3, 4.5e-3, 11)
        self.axis, joints = straight(model, way)
        self._joints = [np.polynomial.Polynomial.fit(way, each, 5) for each in joints.T]
        self._phases = random.uniform(0.0, 2.0 * np.pi, 2)

    def pressed(self, time: Array) -> tuple[Array, Array]:
        """Return depth and speed of the tip at times."""
        return self._way(time)[:2]

    def _way(self, time: Array) -> tuple[Array, Array, Array]:
        middle, swing, sweep = 0.5 * (SLOW + FAST), 0.5 * (FAST - SLOW), 2.0 * np.pi * SWEEP
        turned = sweep * time + self._phases[0]
        phase = 2.0 * np.pi * middle * time + swing / SWEEP * np.sin(turned) + self._phases[1]
        rate = 2.0 * np.pi * (middle + swing * np.cos(turned))
        gain = -2.0 * np.pi * swing * sweep * np.sin(turned)
        speed = TRAVEL * rate * np.cos(phase)
        acceleration = TRAVEL * (gain * np.cos(phase) - rate**2 * np.sin(phase))
        return PRELOAD + TRAVEL * np.sin(phase), speed, acceleration

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """Return angles, speeds, accelerations of the joints at times, each of shape (n, 6)."""
        way, speed, acceleration = self._way(time)
        angle, slope, bend = (
            np.stack([each.deriv(order)(way) for each in self._joints], axis=1)
            for order in range(3)
        )
        rate = slope * speed[:, None]
        return angle, rate, bend * speed[:, None] ** 2 + slope * acceleration[:, None]


def straight(model: mujoco.MjModel, way: Array) -> tuple[Array, Array]:
    """Return the sensor's z at home, and the joints as it goes along this unturned, (n, 6)."""
    data, site = mujoco.MjData(model), model.site("sensor").id
    data.qpos[:] = HOME
    mujoco.mj_kinematics(model, data)
    place, turn = data.site_xpos[site].copy(), data.site_xmat[site].copy()
    axis, joints = turn.reshape(3, 3)[:, 2].copy(), []
    moves, turns, off, wanted, now = (np.zeros(n) for n in (18, 18, 3, 4, 4))
    moves, turns = moves.reshape(3, 6), turns.reshape(3, 6)
    mujoco.mju_mat2Quat(wanted, turn)
    for each in way:
        for _ in range(8):  # Newton's steps: each squares the error
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_jacSite(model, data, moves, turns, site)
            mujoco.mju_mat2Quat(now, data.site_xmat[site])
            mujoco.mju_subQuat(off, wanted, now)
            off[:] = data.site_xmat[site].reshape(3, 3) @ off
            left = np.concatenate([place + each * axis - data.site_xpos[site], off])
            data.qpos += np.linalg.solve(np.concatenate([moves, turns]), left)
        joints.append(data.qpos.copy())
    return axis, np.array(joints)


def _direction(random: np.random.Generator) -> Array:
    """Return two random directions, of force and torque, shape (6,)."""
    drawn = random.normal(size=(2, 3))
    return (drawn / np.linalg.norm(drawn, axis=1)[:, None]).ravel()


def _tool(random: np.random.Generator) -> Tool:
    """Draw a tool of given mass whose middle lies 3 to 6 cm off, as an uneven block."""
    side = random.normal(size=3)
    centre = random.uniform(0.03, 0.06) * side / np.linalg.norm(side)
    edges = random.uniform(0.03, 0.12, 3)
    moments = MASS / 12.0 * (np.sum(edges**2) - edges**2)
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    return Tool(MASS, centre, axes @ np.diag(moments) @ axes.T)


def _turned(quaternions: Array, angles: Array) -> Array:
    """Turn by small angles about the axes of the body."""
    x, y, z, w = quaternions.T
    a, b, c = 0.5 * angles.T
    turned = np.stack(
        [
            x + w * a + y * c - z * b,
            y + w * b + z * a - x * c,
            z + w * c + x * b - y * a,
            w - x * a - y * b - z * c,
        ],
        axis=1,
    )
    return turned / np.linalg.norm(turned, axis=1)[:, None]
