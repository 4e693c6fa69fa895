"""The simulated probe's mechanics with a composed model (``model.yaml``) behind the coil.

What belongs here: coil and stage around a model's generated equations, and what machine code of
their integration needs. What does not: the integration itself (``composed_motion``); clock, noise,
encoder (``simulated``); the models' equations (``physics``).
"""

from __future__ import annotations

import ctypes
import hashlib
import math
from pathlib import Path

import numpy as np
import sympy as sp

from tissue_probe.devices.device import DeviceError
from tissue_probe.physics import machine_code
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import Effect, Parameter
from tissue_probe.physics.effects.effect import POSITION, TIME, TISSUE_FORCE
from tissue_probe.physics.model_file import load
from tissue_probe.physics.plant_code import FACTS, source
from tissue_probe.signals import FloatArray

#: Longest Runge-Kutta step as a part of the time constant of the fastest motion.
STEP_OF_TIME_CONSTANT = 0.2
#: Most Runge-Kutta steps in a second: a fifth of a core.
MOST_STEPS = 5e5
# The state is i, u, u', d, then the model's.
CURRENT, COIL, SPEED, DEPTH, FIRST = range(5)

_BEGIN = ctypes.CFUNCTYPE(None, ctypes.c_void_p, *2 * [ctypes.c_double], ctypes.c_void_p)
_DERIVATIVE = ctypes.CFUNCTYPE(None, *4 * [ctypes.c_void_p])
_SIMULATE = ctypes.CFUNCTYPE(
    None, *3 * [ctypes.c_void_p], *3 * [ctypes.c_int64], *2 * [ctypes.c_double]
)
_MOTION = "tissue_probe.devices.composed_motion"
_SOURCES = (
    "devices/composed.py",
    "devices/composed_motion.py",
    "physics/machine_code.py",
    "physics/plant_code.py",
    "physics/program.py",
)

_DEPTH, _DEPTH_RATE, _HELD = sp.symbols("stage_depth stage_speed held", real=True)
# The stage moves the probe's base, seen from which the tissue's surface moves; a suction tip that
# has let go feels no tissue.
STAGE = Effect(
    name="stage",
    family="device",
    physics="The probe's base stands d below the tissue's surface; its tip holds on, or not",
    parameters=(
        Parameter(_DEPTH, "m", default=0.0, lower=-10.0, upper=10.0),
        Parameter(_DEPTH_RATE, "m/s", default=0.0, lower=-1e3, upper=1e3),
        Parameter(_HELD, "1", default=1.0, lower=0.0, upper=1.0),
    ),
    surface=(-_DEPTH, -_DEPTH_RATE),
    contact=TISSUE_FORCE * _HELD,
)


class ComposedProbe:
    """Coil, stage, and the model in a file; stiffness and damping scaled from place to place.

    Parameters
    ----------
    path : path
        The model file. Its tool (tip, load cell) is the probe's.
    coil : sequence of float
        L [H], R [ohm], K [N/A], M [kg], c [N s/m], s [N/m] of the coil.
    stage_time, reach : float
        Time constant of the stage [s]; height at which the suction tip lets go [m].
    sample_period : float
        Time between two samples [s].
    stiffest : float
        Largest stiffness anywhere, over the file's.

    Raises
    ------
    SettingsError, OSError
        If the file cannot be used.
    DeviceError
        If the model cannot be simulated by the probe, or not at real time.
    """

    def __init__(
        self,
        path: str | Path,
        coil: tuple[float, ...],
        stage_time: float,
        reach: float,
        sample_period: float,
        stiffest: float,
    ) -> None:
        fitted = load(path)
        composition = fitted.composition
        if composition.rig != "compliant_probe":
            raise DeviceError(
                f"{path}: the rig is {composition.rig}, but the simulated probe is a "
                "compliant_probe"
            )
        for effect in composition.all_effects:
            if effect.delay != 0:
                raise DeviceError(
                    f"{path}: {effect.name} cannot be simulated by the probe, whose channels are "
                    "sampled at one time; fit the model without it"
                )
        with_stage = Composition(
            "compliant_probe", composition.tissue, (*composition.effects, STAGE)
        )
        model = with_stage.model
        digest = hashlib.sha256(repr(model).encode()).hexdigest()[:16]
        self._code = machine_code.load(
            f"plant_{digest}", lambda: source(model), FACTS, _SOURCES, lambda _: _MOTION
        )
        names = self._code.facts["VALUES"]
        values = {**fitted.values, "stage_depth": 0.0, "stage_speed": 0.0, "held": 1.0}
        self._values = np.array([values[name] for name in names])
        self._tissue = [names.index(name) for name in ("stiffness", "damping")]
        self._own = self._values[self._tissue]
        self._coil = np.array([*coil, stage_time, reach])
        self._period = sample_period
        known = {symbol: values[str(symbol)] for symbol in model.values}
        self.rounding = float(model.rounded.subs(known))
        self._true = None
        if model.position != POSITION:
            self._true = sp.lambdify((POSITION, TIME), model.position.subs(known), "numpy")
        self._state = np.zeros(FIRST + len(self._code.facts["STATES"]))
        self._mode = np.zeros(len(self._code.facts["FIRST"]))
        n, switches = self._state.size, self._mode.size
        arrays = (
            *(self._state, self._mode, self._values, self._coil),
            *(np.empty((4, n)), np.empty((2, n)), np.empty((2, switches))),
        )
        addresses = np.array([array.ctypes.data for array in arrays])
        sizes = np.array([n, switches, self._values.size])
        self._passed = addresses.ctypes.data, sizes.ctypes.data
        self._kept = *arrays, addresses, sizes  # since their addresses are
        entries = self._code.addresses
        self._begin = _BEGIN(entries["begin"])
        self._derivative = _DERIVATIVE(entries["derivative"])
        self._simulate = _SIMULATE(entries["simulate"])
        self.start(0.0)
        self._substeps = self._needed_substeps(stiffest)

    def start(self, depth: float) -> None:
        """Put the probe at rest, its base ``depth`` [m] below the tissue's surface."""
        self._mode[:] = self._code.facts["FIRST"]
        self._state[:] = 0.0
        self._state[DEPTH] = depth
        self._values[-1] = float(depth >= 0.0)
        self._begin(self._values.ctypes.data, 0.0, 0.0, self._state[FIRST:].ctypes.data)
        self._count = 0

    def advance(
        self, command: FloatArray, relative: tuple[float, float], depth: float
    ) -> tuple[FloatArray, FloatArray]:
        """Take a sample, then move on by one period, for each command.

        Parameters
        ----------
        command : array, shape (n,)
            Voltage of the coil [V].
        relative : (float, float)
            Stiffness and damping here, over the file's.
        depth : float
            How far below the tissue's surface the base is told to be [m].

        Returns
        -------
        position, force : array, shape (n,)
            What the encoder shows before it is rounded [m], and the load cell without noise [N].
        """
        samples = np.empty((3, command.size))
        samples[0] = command
        self._values[self._tissue] = self._own * relative
        self._simulate(
            *self._passed, samples.ctypes.data, command.size, self._count, self._substeps, depth,
            self._period,
        )  # fmt: skip
        if not np.isfinite(self._state).all():
            raise DeviceError("the simulated model diverges: check the values in the model file")
        times = (self._count + np.arange(command.size)) * self._period
        self._count += command.size
        return self._measured(samples[1], times), samples[2]

    def _measured(self, true: FloatArray, times: FloatArray) -> FloatArray:
        """Return what an encoder that errs shows; the model tells the true of the shown."""
        if self._true is None:
            return true
        shown = true.copy()
        for _ in range(50):
            shown += true - self._true(shown, times)
        return shown

    def _needed_substeps(self, stiffest: float) -> int:
        """Return the steps in a sample that resolve the fastest motion near the usual states."""
        self._values[self._tissue] = self._own * stiffest
        fastest = 0.0
        for indentation, speed in ((0.0, 0.0), (1e-3, 0.0), (1e-3, 0.05), (3e-3, -0.05)):
            at = self._state.copy()
            at[[COIL, FIRST]] += indentation
            at[[SPEED, FIRST + 1]] += speed
            fastest = max(fastest, np.abs(np.linalg.eigvals(self._jacobian(at))).max())
        self._values[self._tissue] = self._own
        step = STEP_OF_TIME_CONSTANT / fastest
        if not 1.0 / step <= MOST_STEPS:
            least = 1.0 / (STEP_OF_TIME_CONSTANT * MOST_STEPS)
            raise DeviceError(
                f"the model's fastest time constant is {1.0 / fastest:.1g} s, too short to "
                f"simulate at real time: from {least:.1g} s on "
                "it works"
            )
        return math.ceil(self._period / step * (1.0 - 1e-9))

    def _jacobian(self, at: FloatArray) -> FloatArray:
        columns = []
        for index in range(at.size):
            change = np.zeros(at.size)
            change[index] = 1e-9
            columns.append((self._rates(at + change) - self._rates(at - change)) / 2e-9)
        return np.array(columns).T

    def _rates(self, at: FloatArray) -> FloatArray:
        filled = np.empty(at.size)
        self._derivative(*self._passed, at.ctypes.data, filled.ctypes.data)
        return filled
