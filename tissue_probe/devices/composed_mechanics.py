"""The simulated probe's mechanics with a composed model (``model.yaml``) behind the coil.

Contents: coil and stage around a model's generated equations, and their integration: the classical
Runge-Kutta scheme in short steps, each divided where a switch turns.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import sympy as sp
from numba import njit, types

from tissue_probe.alignment import Alignment
from tissue_probe.devices.device import DeviceError
from tissue_probe.physics import code_cache
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import Effect, Parameter
from tissue_probe.physics.effects.effect import POSITION, TIME, TISSUE_FORCE
from tissue_probe.physics.model_file import load
from tissue_probe.physics.plant_code import source
from tissue_probe.physics.rigs import OWN
from tissue_probe.signals import FloatArray

#: Longest Runge-Kutta step as a part of the time constant of the fastest motion.
STEP_OF_TIME_CONSTANT = 0.2
#: Most Runge-Kutta steps in a second: a fifth of a core.
COMPOSED_STEPS = 5e5
#: Switches within one step beyond this many are left to the next one.
EVENTS_IN_STEP = 6
# The state is i, u, u', d, then the model's.
CURRENT, COIL, SPEED, DEPTH, FIRST = range(5)

_DEPTH, _DEPTH_RATE, _HELD = sp.symbols("stage_depth stage_speed held", real=True)
# The stage moves the probe's base, seen from which the tissue's surface moves; a suction tip that
# has let go feels no tissue.
STAGE_EFFECT = Effect(
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
    effect_files : sequence of path
        Python files with the effects of the user's own that the model file needs.

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
        effect_files: Sequence[str] = (),
    ) -> None:
        fitted = load(path, effect_files)
        composition = fitted.composition
        if composition.rig is not OWN:
            raise DeviceError(
                f"{path}: the rig is {composition.rig}, but the simulated probe is a {OWN}"
            )
        with_stage = Composition(OWN, composition.tissue, (*composition.effects, STAGE_EFFECT))
        model = with_stage.model
        digest = hashlib.sha256(repr(model).encode()).hexdigest()[:16]
        self._kernel = code_cache.module(f"plant_{digest}", lambda: source(model))
        values = {**fitted.values, "stage_depth": 0.0, "stage_speed": 0.0, "held": 1.0}
        self._values = np.array([values[name] for name in self._kernel.VALUES])
        self._tissue = [self._kernel.VALUES.index(name) for name in ("stiffness", "damping")]
        self._own = self._values[self._tissue]
        self._coil = np.array([*coil, stage_time, reach])
        self._period = sample_period
        known = {symbol: values[str(symbol)] for symbol in model.values}
        self.rounding = float(model.rounded.subs(known))
        self._true = None
        if model.position != POSITION:
            self._true = sp.lambdify((POSITION, TIME), model.position.subs(known), "numpy")
        self._late = float(sp.sympify(model.delay).subs(known)) / sample_period
        self.start(0.0)
        self._substeps = self._needed_substeps(stiffest)

    def start(self, depth: float) -> None:
        """Put the probe at rest, its base ``depth`` [m] below the tissue's surface."""
        self._mode = np.array(self._kernel.FIRST, dtype=np.float64)
        self._state = np.zeros(FIRST + len(self._kernel.STATES))
        self._state[DEPTH] = depth
        self._values[-1] = float(depth >= 0.0)
        self._kernel.begin(self._values, 0.0, 0.0, self._state[FIRST:])
        self._count = 0
        # The channel that is late is delayed, where a measurement would delay the other.
        self._delaying = Alignment(-self._late)

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
            The encoder's reading before it is rounded [m], and the load cell's without noise [N].
        """
        position, force = np.empty(command.size), np.empty(command.size)
        self._values[self._tissue] = self._own * relative
        kernel = self._kernel
        _simulate(
            kernel.rate, kernel.switch, kernel.output, kernel.reaction, kernel.begin, self._state,
            self._mode, self._values, self._coil, np.ascontiguousarray(command), depth,
            self._count, self._period, self._substeps, position, force,
        )  # fmt: skip
        if not np.isfinite(self._state).all():
            raise DeviceError("the simulated model diverges: check the values in the model file")
        times = (self._count + np.arange(command.size, dtype=float)) * self._period
        self._count += command.size
        return self._delaying.apply(self._measure_position(position, times), force)

    def _measure_position(self, true: FloatArray, times: FloatArray) -> FloatArray:
        """Return the reading of a true position; the model gives the true one of a reading."""
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
        if not 1.0 / step <= COMPOSED_STEPS:
            least = 1.0 / (STEP_OF_TIME_CONSTANT * COMPOSED_STEPS)
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
        kernel, values, mode = self._kernel, self._values, self._mode
        _derivative(
            kernel.rate, kernel.reaction, 0.0, at, mode, values, self._coil, 0.0, 0.0, filled
        )
        return filled


_F8 = types.float64
_V = types.Array(_F8, 1, "C")
_FILL = types.FunctionType(types.void(_F8, _V, _V, _F8, _F8, _V, _V))
_FORCE = types.FunctionType(types.float64(_F8, _V, _V, _F8, _F8, _V))
_BEGIN_TYPE = types.FunctionType(types.void(_V, _F8, _F8, _V))


@njit(
    types.void(_FILL, _FORCE, _F8, _V, _V, _V, _V, _F8, _F8, _V),
    cache=True, nogil=True, error_model="numpy",
)  # fmt: skip
def _derivative(
    rate: Callable[..., None],
    reaction: Callable[..., float],
    t: float,
    y: FloatArray,
    mode: FloatArray,
    p: FloatArray,
    coil: FloatArray,
    voltage: float,
    target: float,
    filled: FloatArray,
) -> None:
    """Fill the rates of i, u, u', d and of the model's states."""
    inductance, resistance, force_constant, mass, c, s, stage_time, _ = coil
    i, u, v, d = y[CURRENT], y[COIL], y[SPEED], y[DEPTH]
    p[-3] = d
    p[-2] = (target - d) / stage_time
    filled[CURRENT] = (voltage - resistance * i - force_constant * v) / inductance
    filled[COIL] = v
    cell = reaction(t, y[FIRST:], p, u, v, mode)
    filled[SPEED] = (force_constant * i - c * v - s * u - cell) / mass
    filled[DEPTH] = p[-2]
    rate(t, y[FIRST:], p, u, v, mode, filled[FIRST:])


@njit(
    types.void(_FILL, _FORCE, _F8, _V, _V, _V, _V, _F8, _F8, _F8, _V),
    cache=True, nogil=True, error_model="numpy",
)  # fmt: skip
def _step(
    rate: Callable[..., None],
    reaction: Callable[..., float],
    t: float,
    y: FloatArray,
    mode: FloatArray,
    p: FloatArray,
    coil: FloatArray,
    voltage: float,
    target: float,
    h: float,
    after: FloatArray,
) -> None:
    """One classical Runge-Kutta step of length h."""
    slopes = np.empty((4, y.size))
    for stage in range(4):
        part = 0.0 if stage == 0 else (0.5 * h if stage < 3 else h)
        after[:] = y
        if stage > 0:
            after += part * slopes[stage - 1]
        _derivative(rate, reaction, t + part, after, mode, p, coil, voltage, target, slopes[stage])
    after[:] = y + h / 6.0 * (slopes[0] + 2.0 * slopes[1] + 2.0 * slopes[2] + slopes[3])


@njit(
    types.void(_FILL, _FILL, _FORCE, _F8, _V, _V, _V, _V, _F8, _F8, _F8),
    cache=True, nogil=True, error_model="numpy",
)  # fmt: skip
def _advance(
    rate: Callable[..., None],
    switch: Callable[..., None],
    reaction: Callable[..., float],
    t: float,
    y: FloatArray,
    mode: FloatArray,
    p: FloatArray,
    coil: FloatArray,
    voltage: float,
    target: float,
    h: float,
) -> None:
    """Move the state on by h, turning switches at the times at which they turn (by secants)."""
    after = np.empty(y.size)
    before, now = np.empty(mode.size), np.empty(mode.size)
    for events in range(EVENTS_IN_STEP + 1):
        _step(rate, reaction, t, y, mode, p, coil, voltage, target, h, after)
        if mode.size == 0 or events == EVENTS_IN_STEP:
            break
        p[-3] = y[DEPTH]
        switch(t, y[FIRST:], p, y[COIL], y[SPEED], mode, before)
        first, share = -1, 1.0
        p[-3] = after[DEPTH]
        switch(t + h, after[FIRST:], p, after[COIL], after[SPEED], mode, now)
        for k in range(mode.size):
            if now[k] < 0.0:
                here = max(before[k], 0.0) / max(max(before[k], 0.0) - now[k], 1e-300)
                if first < 0 or here < share:
                    first, share = k, here
        if first < 0:
            break
        _step(rate, reaction, t, y, mode, p, coil, voltage, target, share * h, after)
        y[:] = after
        mode[first] = 1.0 - mode[first]
        t += share * h
        h -= share * h
    y[:] = after


@njit(
    types.void(
        _FILL, _FILL, _FORCE, _FORCE, _BEGIN_TYPE, _V, _V, _V, _V, _V, _F8, types.int64, _F8,
        types.int64, _V, _V,
    ),
    cache=True, nogil=True, error_model="numpy",
)  # fmt: skip
def _simulate(
    rate: Callable[..., None],
    switch: Callable[..., None],
    output: Callable[..., float],
    reaction: Callable[..., float],
    begin: Callable[..., None],
    y: FloatArray,
    mode: FloatArray,
    p: FloatArray,
    coil: FloatArray,
    command: FloatArray,
    target: float,
    count: int,
    period: float,
    substeps: int,
    position: FloatArray,
    force: FloatArray,
) -> None:
    """Sample coil displacement and force, then move on by one period, for each command."""
    reach = coil[7]
    rest = np.empty(y.size - FIRST)
    h = period / substeps
    for n in range(command.size):
        t = (count + n) * period
        p[-3] = y[DEPTH]
        p[-2] = (target - y[DEPTH]) / coil[6]
        position[n] = y[COIL]
        force[n] = output(t, y[FIRST:], p, y[COIL], y[SPEED], mode)
        if y[DEPTH] >= -1e-6:
            if p[-1] == 0.0:
                # Tissue that is touched again has forgotten: its memory is as after long rest.
                begin(p, y[COIL], force[n], rest)
                y[FIRST + 2 :] = rest[2:]
            p[-1] = 1.0
        elif y[DEPTH] < -reach:
            p[-1] = 0.0
        for part in range(substeps):
            _advance(rate, switch, reaction, t + part * h, y, mode, p, coil, command[n], target, h)
