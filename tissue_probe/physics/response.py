"""The response of a composed model to a measured motion or force of the coil, and its derivatives.

Contents: the input's course, machine code of the model and its integration, delays.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissue_probe.call_cache import for_a_call
from tissue_probe.jumps import jumps
from tissue_probe.physics import machine_code, numba_code
from tissue_probe.physics.interpolation import (
    between_jumps,
    cubics,
    later,
    lines,
    steps,
    with_acceleration,
)
from tissue_probe.physics.machine_code import MachineCode, Text, Written
from tissue_probe.physics.rounding import smooth_rounding
from tissue_probe.physics.scale import Scale
from tissue_probe.physics.smooth_course import splines
from tissue_probe.signals import IntArray

FloatArray = NDArray[np.float64]

_RUN = ctypes.CFUNCTYPE(None, *2 * [ctypes.c_void_p], *2 * [ctypes.c_double])
# A call of a microsecond keeps the interpreter's lock: to get it back from another thread takes
# longer.
_PREPARE = ctypes.PYFUNCTYPE(None, ctypes.c_void_p)
_BEGIN = ctypes.PYFUNCTYPE(None, ctypes.c_void_p, *3 * [ctypes.c_double], ctypes.c_void_p)
_POSITION = ctypes.CFUNCTYPE(None, ctypes.c_int64, *5 * [ctypes.c_void_p])
#: Ranges of the tip's speed, each of which has its own length of steps.
RANGES = 18
#: Degree of the usual course.
COURSE_DEGREE = 3
#: Bytes of a line of the processor's cache.
CACHE_LINE = 64


@dataclass(frozen=True)
class Turned:
    """Units in which a kernel's numbers are, where they are not SI: how large each is.

    ``values`` and ``states`` have one for each; they follow from ``scale``.
    """

    values: FloatArray
    states: FloatArray
    input: float
    output: float
    scale: Scale


@dataclass(frozen=True)
class ResponseKernel:
    """Machine code of a model, and its facts.

    Attributes
    ----------
    code : MachineCode
        Has the entries ``run``, ``prepare``, ``begin`` and, where ``moves_position``, ``position``.
    states, values : list of str
        Names, in the order of all arrays.
    first : list of float
        The switches' values at the first sample.
    spreads : list of str
        For each state, the scale of its prior.
    linear : bool
        Whether the model is steady and linear.
    course_columns : list of int
        Numbers of start and values by which the coil's course changes.
    moves_position : bool
        Whether the true course differs from the measured one.
    delays, shifts : bool
        Whether the output is read later, or earlier; whether the model answers to an input of
        earlier, or of later.
    delay, rounded : int
        Numbers of the values that say by how much [s], and how coarse the encoder is [m]; or -1.
    late : float
        1 where it is the output that is late, -1 the input.
    prepared : int
        How many numbers are computed from the values beforehand.
    width : int
        How many columns derivatives have, those beyond start and values being zero.
    hears_input2 : bool
        Whether the model follows a second input.
    turned : Turned, optional
        Units of the machine code's own numbers, where the record is not of the usual size. All
        that ``begin``, ``relaxation_rates``, ``course`` and ``respond`` are given and return is SI;
        a ``Course`` is in the code's units.
    """

    code: MachineCode
    states: list[str]
    values: list[str]
    first: list[float]
    spreads: list[str]
    linear: bool
    course_columns: list[int]
    moves_position: bool
    delays: bool
    shifts: bool
    delay: int
    late: float
    rounded: int
    prepared: int
    width: int
    hears_input2: bool
    turned: Turned | None = None

    @classmethod
    def load(cls, name: str, write: Callable[[], Text], sources: tuple[str, ...]) -> ResponseKernel:
        """Return the kernel of a text of ``response_code``, as ``machine_code.load`` does."""
        code = machine_code.load(name, write, sources, _integration)
        return cls(code, **code.facts)

    @property
    def corrects(self) -> bool:
        """Whether the position is corrected sample by sample: between fewer its course is other."""
        return self.moves_position or self.rounded >= 0

    def begin(
        self, values: FloatArray, position: float, force: float, input2: float = 0.0
    ) -> FloatArray:
        """Return where the states start, by the measured values of the first sample."""
        if self.turned is None:
            return self._begin(values, position, force, input2)[0]
        own, scale = self.turned, self.turned.scale
        at = position / scale.length, force / scale.force, input2 / scale.input2
        return self._begin(values / own.values, *at)[0] * own.states

    def relaxation_rates(self, values: FloatArray) -> FloatArray:
        """Return how fast each state forgets [1/s]: those of branches; 0 for all others."""
        if self.turned is None:
            return self._begin(values, 0.0, 0.0)[1]
        return self._begin(values / self.turned.values, 0.0, 0.0)[1] / self.turned.scale.time

    def _begin(
        self, values: FloatArray, position: float, force: float, input2: float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        z, p = np.zeros((2, len(self.states))), np.ascontiguousarray(values, dtype=np.float64)
        _BEGIN(self.code.addresses["begin"])(p.ctypes.data, position, force, input2, z.ctypes.data)
        return z[0], z[1]

    def position(
        self, times: FloatArray, true: FloatArray, values: FloatArray, changes: FloatArray
    ) -> None:
        """Turn measured positions into true ones; fill their changes, a row for each column."""
        measured, p = true.copy(), np.ascontiguousarray(values, dtype=np.float64)
        arrays = (times, measured, p, true, changes)
        entry = _POSITION(self.code.addresses["position"])
        entry(times.size, *(array.ctypes.data for array in arrays))

    def run(
        self, arrays: Sequence[FloatArray], sizes: NDArray[np.int64], period: float, begins: float
    ) -> None:
        """Prepare ``arrays[0]``, the values, and integrate as ``runge_kutta`` or ``transition``."""
        addresses = np.array([array.ctypes.data for array in arrays])
        _PREPARE(self.code.addresses["prepare"])(int(addresses[0]))
        _RUN(self.code.addresses["run"])(addresses.ctypes.data, sizes.ctypes.data, period, begins)


def _integration(facts: Mapping[str, Any]) -> Written:
    """Return the integrator of a model with these facts."""
    name = "transition" if facts["linear"] else "runge_kutta"
    return name, lambda: numba_code.text(import_module(f"tissue_probe.physics.{name}"))


class Between(Enum):
    """How a course goes on between samples.

    Smoothly; along straight lines; held as each sample has it until the next, as a converter puts
    out a command; or smoothly up to the sample after a jump, as a simulation computes one.
    """

    smooth, straight, held, jumping = range(4)


@dataclass(frozen=True)
class Fineness:
    """How finely a response is computed.

    Attributes
    ----------
    degree : int
        Of the polynomials through the input's samples where these are smooth, and at least twice as
        many: 3, or more.
    parts : int
        How many times more parts a step is divided into than the model's fastest eigenvalue asks.
    """

    degree: int = COURSE_DEGREE
    parts: int = 1


#: As coarse as ever.
USUAL_FINENESS = Fineness()


@dataclass(frozen=True)
class Course:
    """The input's course: pieces of polynomials between the samples, and how values change it.

    ``pieces`` are coefficients, shape (m, n - 1), highest power first; ``changes`` those of the
    derivatives, shape (r, m, n - 1), by start or value number ``columns``, shape (r,). The first
    sample is at the time ``begins`` [s]. The response is computed in so many times more ``parts``
    (``Fineness``). ``input2`` are the pieces of the second input, straight ones, shape (2, n - 1).
    """

    pieces: FloatArray
    sample_period: float
    changes: FloatArray
    columns: NDArray[np.int64]
    begins: float = 0.0
    parts: int = 1
    input2: FloatArray | None = None


@dataclass(frozen=True)
class Response:
    """The rig's output, and its derivatives by start and values.

    ``output`` is force [N] or position [m], shape (n,); ``sensitivity`` has shape (n, states + q).
    """

    output: FloatArray
    sensitivity: FloatArray


def course(
    kernel: ResponseKernel,
    measured: FloatArray,
    period: float,
    values: FloatArray,
    begins: float = 0.0,
    at_rest: bool = True,
    between: Between = Between.smooth,
    fineness: Fineness = USUAL_FINENESS,
    input2: FloatArray | None = None,
) -> Course:
    """Interpolate the true course of the input through its measured samples.

    Parameters
    ----------
    kernel : Kernel
        The model's machine code.
    measured : array, shape (n,)
        Measured displacement of the coil [m], or force [N] where that drives.
    period : float
        Time between two samples [s].
    values : array
        The model's constants and parameters.
    begins : float
        Time of the first sample after the run's first [s].
    at_rest : bool
        Whether the input stood still before the first sample; else it went on as fast as there.
    between : Between
        How the input goes on from sample to sample.
    fineness : Fineness
        How finely the response is computed.
    input2 : array, shape (n,), optional
        Samples of the second input, in its unit; 0 throughout by default.
    """
    coil = _of_driver(kernel, measured, period, values, begins, at_rest, between, fineness)
    if not kernel.hears_input2:
        return coil
    second = np.zeros(measured.size) if input2 is None else input2
    unit = 1.0 if kernel.turned is None else kernel.turned.scale.input2
    return replace(coil, input2=lines(second / unit, coil.sample_period)[-2:])


def _of_driver(
    kernel: ResponseKernel,
    measured: FloatArray,
    period: float,
    values: FloatArray,
    begins: float,
    at_rest: bool,
    between: Between,
    fineness: Fineness,
) -> Course:
    """Return the course of what drives."""
    felt = not kernel.states  # at the samples only
    if kernel.turned is not None:
        own, time = kernel.turned, kernel.turned.scale.time
        measured, values = measured / own.input, values / own.values
        period, begins = period / time, begins / time
    true = np.array(measured, dtype=np.float64)
    rounded = kernel.rounded >= 0 and values[kernel.rounded] > 0
    if not (rounded or kernel.moves_position or len(kernel.course_columns)):
        return _as_measured(true.tobytes(), period, begins, between, felt, fineness)
    if rounded:
        true = smooth_rounding(true, values[kernel.rounded]).course.copy()
    changed = np.zeros((len(kernel.course_columns), measured.size))
    if kernel.moves_position:
        times = begins + np.arange(true.size, dtype=float) * period
        kernel.position(times, true, values, changed)
    if kernel.shifts:
        true, changed = _shifted(true, changed, period, kernel.late * values[kernel.delay], at_rest)
        changed[-1] *= kernel.late
    jumping = jumps(np.diff(true)) if between is Between.jumping else None
    through = partial(
        _pieces,
        period=period,
        between=between,
        felt=felt,
        degree=fineness.degree,
        after=jumping,
    )
    pieces = through(true)
    changes = np.zeros((changed.shape[0], *pieces.shape))
    for row, change in enumerate(changed):
        changes[row] = through(change)
    columns = np.array(kernel.course_columns, dtype=np.int64)
    return Course(pieces, period, changes, columns, begins, fineness.parts)


def _shifted(
    true: FloatArray, changed: FloatArray, period: float, delay: float, at_rest: bool
) -> tuple[FloatArray, FloatArray]:
    """Return a course and its changes as they were earlier; the last change is that by the delay.

    Beyond either end the course goes on as fast as there, but stood still before if at rest.
    """
    read, rate = later(np.column_stack([true, *changed[:-1]]), period, delay)
    pieces = cubics(true, period)
    last = np.polynomial.polynomial.polyval(
        period, [pieces[2, -1], 2 * pieces[1, -1], 3 * pieces[0, -1]]
    )
    off = np.arange(true.size) * period - delay
    for beyond, over, at, slope in (
        (off < 0.0, off, true[0], 0.0 if at_rest else pieces[2, 0]),
        (off > (true.size - 1) * period, off - (true.size - 1) * period, true[-1], last),
    ):
        read[beyond, 0], rate[beyond] = at + slope * over[beyond], slope
    return read[:, 0].copy(), np.stack([*read[:, 1:].T, -rate])


@for_a_call(16)
def _as_measured(
    position: bytes,
    period: float,
    begins: float,
    between: Between,
    felt: bool,
    fineness: Fineness,
) -> Course:
    """Return the course of samples that a model takes as they are: in a fit always the same."""
    values = np.frombuffer(position)
    pieces = _pieces(values, period, between, felt, fineness.degree)
    unchanged = np.zeros((0, *pieces.shape)), np.zeros(0, dtype=np.int64)
    return Course(pieces, period, *unchanged, begins, fineness.parts)


def _pieces(
    values: FloatArray,
    period: float,
    between: Between,
    felt: bool,
    degree: int = 3,
    after: IntArray | None = None,
) -> FloatArray:
    """Return the course through samples; a smooth one may be felt at the samples only.

    One that jumps does so before the samples ``after``, those of the values by default.
    """
    if between is Between.jumping:
        return between_jumps(values, period, jumps(np.diff(values)) if after is None else after)
    if between is Between.held:
        return steps(values)
    if between is Between.straight:
        return lines(values, period)
    if degree > COURSE_DEGREE and values.size >= 2 * degree:
        return splines(values, period, degree)
    pieces = cubics(values, period)
    return with_acceleration(pieces, period) if felt else pieces


def respond(
    kernel: ResponseKernel, values: FloatArray, start: FloatArray, coil: Course
) -> Response:
    """Simulate a model under a course of the coil, from given states at the first sample.

    Parameters
    ----------
    kernel : Kernel
        The model's machine code.
    values, start : array
        The model's constants and parameters, and its states at the first sample (SI units).
    coil : Course
        Of ``course``, for the same values.

    Raises
    ------
    ValueError
        If there are more values or states than the model has, or fewer.
    """
    if kernel.turned is None:
        return _response(kernel, values, start, coil)
    own = kernel.turned
    found = _response(kernel, values / own.values, start / own.states, coil)
    by = own.output / np.concatenate([own.states, own.values])
    return Response(found.output * own.output, found.sensitivity * by)


def _response(
    kernel: ResponseKernel, values: FloatArray, start: FloatArray, coil: Course
) -> Response:
    """Simulate in the units of the machine code."""
    n, count, columns = len(kernel.states), len(kernel.values), kernel.width
    if start.shape != (n,) or values.shape != (count,):
        raise ValueError(
            f"the model has {n} states and {count} values: {start.shape} and {values.shape} "
            "were given"
        )
    samples = coil.pieces.shape[1] + 1
    answer, sensitivity = np.empty(samples), np.empty((samples, columns))
    p = np.concatenate([values, np.zeros(kernel.prepared)])
    switches, moved = len(kernel.first), coil.columns.size
    tip = kernel.spreads.index("speed") if "speed" in kernel.spreads else -1
    order = len(coil.pieces)
    counts = n, columns, p.size, switches, moved, samples
    heard = coil.pieces[:0] if coil.input2 is None else coil.input2
    pieces, second = np.concatenate([coil.pieces, heard]), len(heard)
    sizes = np.array([*counts, tip, RANGES, order, coil.parts, second, *coil.columns])
    arrays = [
        *(p, start.astype(np.float64), np.array(kernel.first, dtype=np.float64)),
        *map(np.ascontiguousarray, (pieces, coil.changes)),
        np.zeros(4 + 3 * columns),
        *(_exactly(n, columns, order) if kernel.linear else _in_steps(n, columns, switches)),
        *(answer, sensitivity),
    ]
    kernel.run(arrays, sizes, coil.sample_period, coil.begins)
    sensitivity = sensitivity[:, : n + count]
    if kernel.delays:
        return _late(kernel, answer, sensitivity, values, coil)
    return Response(answer, sensitivity)


def _late(
    kernel: ResponseKernel,
    answer: FloatArray,
    sensitivity: FloatArray,
    values: FloatArray,
    coil: Course,
) -> Response:
    """Read the output later by the delay; beyond either end it stands still.

    ``late`` is -1 where it is the input that is late.
    """
    signals = np.column_stack([answer, sensitivity])
    read, rate = later(signals, coil.sample_period, kernel.late * values[kernel.delay])
    read[:, 1 + len(kernel.states) + kernel.delay] = -kernel.late * rate
    return Response(read[:, 0], read[:, 1:])


def _in_steps(n: int, columns: int, switches: int) -> tuple[FloatArray, ...]:
    """Return the work space of ``runge_kutta``."""
    speeds = np.stack([np.zeros(RANGES), np.ones(RANGES), np.ones(RANGES)])
    conditions = np.zeros(4 * switches), np.zeros((switches + 1) * columns)
    return np.zeros(5 * n), _aligned(4 * n * columns), *conditions, speeds


def _aligned(count: int) -> FloatArray:
    """Return zeros that begin where a line of the cache does: read by fours, none crosses one."""
    zeros = np.zeros(count + CACHE_LINE // 8)
    return zeros[-zeros.ctypes.data % CACHE_LINE // 8 :][:count]


def _exactly(n: int, columns: int, order: int) -> tuple[FloatArray, ...]:
    """Return the work space of ``transition``."""
    size, values = n + order + 1, columns - n
    signals = np.zeros(n), np.zeros(2 * n * columns), np.zeros(size)
    rows = n * ((values + 3) // 4 * 4)  # a product of matrices takes four columns at once
    by_value = np.zeros((3, values, size, size)), _aligned(size * rows)
    now = _aligned(2 * rows), np.zeros(2 * n), np.zeros(values)
    return *signals, np.zeros((4, size, size)), *by_value, *now
