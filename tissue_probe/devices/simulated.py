"""The simulated probe: voice coil, load cell, tip, and a phantom under the tip.

Physics, all in SI units, u the coil's and x the tip's displacement, positive into the tissue:

    coil circuit   L i' = V - R i - K u'
    coil           M u'' = K i - c u' - s u - F_cell
    load cell      F_cell = k0 (u - x) + beta0 (u' - x')
    tip            m x'' = F_cell - F_tissue                     (the paper's eq. 1)
    tissue         F_tissue = k (x + d) + beta (x' + d')         while the suction tip holds
    stage          d' = (d_target - d) / tau                     how far it stands below the surface

It is integrated by the classical Runge-Kutta scheme, which shares nothing with the discretisation
of the estimators, in steps short for the fastest motion of the probe. The encoder shows u in whole
steps, the load cell k0 (u - x) with white noise and a constant zero. With a model file, load cell,
tip and tissue follow the composed model in it instead (``composed``).
"""

from __future__ import annotations

import math
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, TypeAlias

import numba
import numpy as np
import yaml

from tissue_probe import bounded_yaml
from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration
from tissue_probe.devices.device import DeviceError, Samples
from tissue_probe.devices.simulated_settings import SimulatedProbeSettings
from tissue_probe.excitation import Excitation
from tissue_probe.pacing import Pacer
from tissue_probe.physics.phantom import load_phantom
from tissue_probe.signals import NANOSECONDS, BoolArray, FloatArray

if TYPE_CHECKING:
    from tissue_probe.devices.composed_mechanics import ComposedProbe

#: Longest Runge-Kutta step as a part of the time constant of the fastest motion.
STEP_OF_TIME_CONSTANT = 0.2
#: Most Runge-Kutta steps in a second: a fifth of a core.
SIMULATION_STEPS = 5e6
#: Time constant with which the stage's motion reaches the tissue [s].
STAGE_TIME_CONSTANT = 0.005
#: The suction tip lets go when it is pulled this far above the surface [m].
SUCTION_REACH = 0.0005
#: Samples wait this long to be fetched before they are lost, as in a DAQ's buffer [s].
SIMULATED_BUFFER_TIME = 2.0
#: So many samples are simulated at once and handed out one by one: waking up costs more than they.
SAMPLES_AHEAD = 10
#: The excitation is computed for so many samples at once.
COMMAND_SAMPLES = 200


class SimulatedProbe:
    """A probe that exists only in equations, but keeps real time.

    Parameters
    ----------
    settings : SimulatedProbeSettings
        Its constants, and the phantom: the tissue as a function of place.
    calibration : Calibration, optional
        Not needed: the simulated probe measures in SI units.

    Raises
    ------
    DeviceError
        If the constants make a probe that moves too fast to be simulated at real time.
    OSError, ValueError
        If the phantom cannot be read.
    """

    Settings = SimulatedProbeSettings
    samples_per_read = 1
    force_range = (-math.inf, math.inf)

    def __init__(
        self, settings: SimulatedProbeSettings, calibration: Calibration | None = None
    ) -> None:
        # As in a DAQ, a whole number of ticks of a clock, of 1 GHz: then every stamp is exact.
        self.sample_period = round(NANOSECONDS / settings.sample_rate) / NANOSECONDS
        self.commanded_voltage = 0.0
        self._settings = settings
        self._phantom = load_phantom(Path(settings.phantom or stock_configuration("phantom.yaml")))
        self._pacer = Pacer(self.sample_period)
        self._excitation: Excitation | None = None
        self._where: tuple[float, float, float] | None = None
        self._lock = Lock()  # so that no command follows a stop, whichever thread it comes from
        self.place(0.0, 0.0, 1.0)  # no tissue in reach
        self._composed = self._compose() if settings.model else None
        self._substeps = self._needed_substeps() if self._composed is None else 1
        # Compiled, or loaded from the cache, before the clock runs.
        _simulate(
            np.zeros(6), np.zeros(1, bool), np.zeros(1), self._constants(), self.sample_period, 1
        )

    def place(self, x: float, y: float, z: float) -> None:
        """Tell where the stage holds the probe [m]; the tip touches at the phantom's surface."""
        if (x, y, z) == self._where:
            return  # a stage that stands still says so a hundred times a second
        self._where = (x, y, z)
        stiffness, damping = self._phantom.stiffness(x, y), self._phantom.damping(x, y)
        depth = float(self._phantom.height(x, y)) - float(z)
        self._tissue = (float(stiffness), float(damping), depth)

    def start(self, excitation: Excitation) -> None:
        """Begin to sample at rest, with the excitation [V] on the coil."""
        self._excitation = excitation
        self._noise = np.random.default_rng(self._settings.seed)
        self._state = np.zeros(6)
        self._state[5] = self._tissue[2]
        self._attached = np.array([self._tissue[2] >= 0.0])
        if self._composed is not None:
            self._composed.start(self._tissue[2])
        self._taken = 0
        self._simulated = 0
        self._commands = np.empty(0)
        self._ahead = np.empty((3, 0))
        self._pacer.restart()

    def read(self, count: int) -> Samples:
        """Wait for ``count`` samples.

        Raises
        ------
        DeviceError
            If the probe was not started, is stopped meanwhile, or was not read for longer than its
            buffer lasts.
        """
        if self._excitation is None:
            raise DeviceError("the simulated probe is not sampling: start it before you read")
        if self._pacer.wait_for(self._taken + count - 1) > SIMULATED_BUFFER_TIME:
            raise DeviceError(
                f"nothing was read for {SIMULATED_BUFFER_TIME:g} s and samples are lost: the "
                "machine is too busy for 2 kHz, or was suspended"
            )
        with self._lock:
            excitation = self._excitation
            if excitation is None:
                raise DeviceError("the simulated probe was stopped while it was read")
            missing = count - self._ahead.shape[1]
            if missing > 0:
                self._simulate_ahead(max(missing, SAMPLES_AHEAD), excitation)
            samples = Samples(*self._ahead[:, :count])
            self._ahead = self._ahead[:, count:]
            self.commanded_voltage = float(samples.command[-1])
        self._taken += count
        return samples

    def _simulate_ahead(self, count: int, excitation: Excitation) -> None:
        """Add ``count`` samples to those that are ready to be handed out."""
        settings = self._settings
        command = self._next_commands(count, excitation)
        position, force = self._move_on(command)
        step = settings.encoder_resolution
        if self._composed is not None:
            step = max(step, self._composed.rounding)
        if step > 0.0:
            position = np.round(position / step) * step
        force += settings.force_zero
        force += settings.force_noise * self._noise.standard_normal(count)
        self._ahead = np.concatenate([self._ahead, [position, force, command]], axis=1)

    def _move_on(self, command: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return true position and force at each sample, and move on."""
        if self._composed is None:
            return _simulate(
                self._state,
                self._attached,
                command,
                self._constants(),
                self.sample_period,
                self._substeps,
            )
        stiffness, damping, depth = self._tissue
        phantom = self._phantom
        damping /= phantom.background_damping or 1.0
        relative = (stiffness / phantom.background_stiffness, damping)
        return self._composed.advance(command, relative, depth)

    def _compose(self) -> ComposedProbe:
        # Symbols are imported only where there is a model: they take half a second.
        from tissue_probe.devices.composed_mechanics import ComposedProbe

        coil = self._constants()[:6]
        stiffest = self._phantom.stiffest
        return ComposedProbe(
            self._settings.model, coil, STAGE_TIME_CONSTANT, SUCTION_REACH, self.sample_period,
            stiffest, self._settings.effects,
        )  # fmt: skip

    @property
    def description(self) -> str:
        """The phantom, and the model where there is one, in YAML."""
        told: dict[str, object] = {"phantom": self._phantom.model_dump(mode="json")}
        if self._settings.model:
            told["model"] = bounded_yaml.read(self._settings.model)
        # Lists on one line: a table of thousands stays within the limits of a reader of YAML.
        return str(yaml.safe_dump(told, default_flow_style=None, width=math.inf))

    @property
    def worst_lateness(self) -> float:
        """Longest delay of a wake-up since last asked [s]."""
        worst, self._pacer.worst_lateness = self._pacer.worst_lateness, 0.0
        return worst

    @property
    def recent_lateness(self) -> FloatArray:
        """Delays of the latest wake-ups [s], those of a second at 2 kHz."""
        return np.array(self._pacer.recent)

    def stop(self) -> None:
        """Put the coil at zero volts and end sampling."""
        with self._lock:
            self.commanded_voltage = 0.0
            self._excitation = None

    def close(self) -> None:
        """Stop; there is no hardware to let go of."""
        self.stop()

    def _next_commands(self, count: int, excitation: Excitation) -> FloatArray:
        if self._commands.size < count:
            first = self._simulated + self._commands.size
            number = np.arange(first, first + max(count, COMMAND_SAMPLES), dtype=float)
            more = excitation(number * self.sample_period)
            self._commands = np.concatenate([self._commands, more])
        self._simulated += count
        now, self._commands = self._commands[:count], self._commands[count:]
        return now

    def _needed_substeps(self) -> int:
        """Return the Runge-Kutta steps in a sample that resolve the fastest motion anywhere."""
        relative = self._phantom.stiffest
        stiffest = (
            relative * self._phantom.background_stiffness,
            relative * self._phantom.background_damping,
            0.0,
        )
        constants = self._constants(stiffest)
        # The right-hand side is linear: at unit states it gives the columns of its matrix.
        matrix = []
        for i, u, v, x, w, d in np.eye(6).tolist():
            matrix.append(_derivative((i, u, v, x, w, d), True, 0.0, constants))
        rate = float(np.abs(np.linalg.eigvals(matrix)).max())
        step = STEP_OF_TIME_CONSTANT / rate
        if 1.0 / step > SIMULATION_STEPS:
            raise DeviceError(
                f"the simulated probe's fastest time constant is {1.0 / rate:.1g} s, too short to "
                f"simulate at real time: give more mass or inductance, or less stiffness, damping "
                "or resistance, so that it is "
                f"{1.0 / (STEP_OF_TIME_CONSTANT * SIMULATION_STEPS):.1g} s"
            )
        return math.ceil(self.sample_period / step * (1.0 - 1e-9))

    def _constants(self, tissue: tuple[float, float, float] | None = None) -> tuple[float, ...]:
        s = self._settings
        return (
            s.coil_inductance,
            s.coil_resistance,
            s.force_constant,
            s.coil_mass,
            s.bearing_damping,
            s.suspension_stiffness,
            s.load_cell_stiffness,
            s.load_cell_damping,
            s.tip_mass,
            *(tissue or self._tissue),
        )


#: i, u, u', x, x' and d of the module's equations.
_State: TypeAlias = tuple[float, float, float, float, float, float]


@numba.njit(cache=True)
def _derivative(
    state: _State, attached: bool, voltage: float, constants: tuple[float, ...]
) -> _State:
    """Right-hand side of the module's equations; the state is i, u, u', x, x', d."""
    i, u, v, x, w, d = state
    inductance, resistance, force_constant, coil_mass, c, s, k0, beta0, m, k, beta, target = (
        constants
    )
    d_rate = (target - d) / STAGE_TIME_CONSTANT
    cell = k0 * (u - x) + beta0 * (v - w)
    tissue = k * (x + d) + beta * (w + d_rate) if attached else 0.0
    return (
        (voltage - resistance * i - force_constant * v) / inductance,
        v,
        (force_constant * i - c * v - s * u - cell) / coil_mass,
        w,
        (cell - tissue) / m,
        d_rate,
    )


@numba.njit(cache=True)
def _axpy(state: _State, scale: float, slope: _State) -> _State:
    """_State + scale * slope, entry by entry."""
    return (
        state[0] + scale * slope[0],
        state[1] + scale * slope[1],
        state[2] + scale * slope[2],
        state[3] + scale * slope[3],
        state[4] + scale * slope[4],
        state[5] + scale * slope[5],
    )


@numba.njit(cache=True)
def _runge_kutta_step(
    state: _State, attached: bool, voltage: float, constants: tuple[float, ...], h: float
) -> _State:
    """One classical Runge-Kutta step of length h."""
    s1 = _derivative(state, attached, voltage, constants)
    s2 = _derivative(_axpy(state, h / 2, s1), attached, voltage, constants)
    s3 = _derivative(_axpy(state, h / 2, s2), attached, voltage, constants)
    s4 = _derivative(_axpy(state, h, s3), attached, voltage, constants)
    state = _axpy(state, h / 6, s1)
    state = _axpy(state, h / 3, s2)
    state = _axpy(state, h / 3, s3)
    return _axpy(state, h / 6, s4)


@numba.njit(cache=True)
def _simulate(
    state: FloatArray,
    attached: BoolArray,
    command: FloatArray,
    constants: tuple[float, ...],
    sample_period: float,
    substeps: int,
) -> tuple[FloatArray, FloatArray]:
    """Sample coil displacement and load-cell force, then move on by one period, for each command.

    ``state`` (6,) and ``attached`` (1,) are carried from call to call, changed in place.
    """
    position = np.empty(command.size)
    force = np.empty(command.size)
    now = (state[0], state[1], state[2], state[3], state[4], state[5])
    for n in range(command.size):
        position[n] = now[1]
        force[n] = constants[6] * (now[1] - now[3])
        if now[5] >= -1e-6:
            attached[0] = True
        elif now[5] < -SUCTION_REACH:
            attached[0] = False
        for _ in range(substeps):
            now = _runge_kutta_step(
                now, attached[0], command[n], constants, sample_period / substeps
            )
    state[0], state[1], state[2], state[3], state[4], state[5] = now
    return position, force
