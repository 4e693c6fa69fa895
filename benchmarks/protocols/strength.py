"""How strong a hidden part is made: by what the best Kelvin-Voigt fit leaves of it.

Contents: the fit, and the search.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares, lsq_linear
from scipy.signal import lsim

from benchmarks.protocols.course import Array, Course, Held
from benchmarks.protocols.hidden import Change, Hidden
from benchmarks.protocols.motion import DRIVEN, RIGID
from benchmarks.protocols.sensors import Bench

#: Rms that the best Kelvin-Voigt fit leaves, over the noise.
LEAST, MOST = 2.0, 20.0
#: How well a laboratory knows where a probe touches [m]: four standard deviations of 0.03 mm, which
#: is the tolerance that `tissue_probe` documents.
#: Within that a bias of the force is another touch, and hides nothing.
TOUCH = 1.2e-4
#: Times at which it is asked.
POINTS = 3000
#: A strength is near enough when the residual is the target but for this share, or after so many
#: steps: which ratio was reached is told.
NEAR, STEPS = 0.2, 8
#: A tip that a part holds still, or throws out of all bounds, is as far as this from the noise.
FARTHEST = 1e6


@dataclass(frozen=True)
class Run:
    """How one record is taken: the course, when samples are taken, from when the tip was at rest.

    Attributes
    ----------
    course : Course
        Of the position, or of the force that drives.
    times : array
        Of the samples [s].
    begin : float
        From here on the course is followed [s].
    """

    course: Course
    times: Array
    begin: float

    @property
    def period(self) -> float:
        """Mean time between samples [s]."""
        return float(self.times[-1] - self.times[0]) / (self.times.size - 1)


def left(bench: Bench, run: Run, mass_known: bool) -> float:
    """Return the rms that the best Kelvin-Voigt fit leaves of a bench without noise [N or m]."""
    times = np.linspace(run.times[0], run.times[-1], min(POINTS, run.times.size))
    found = bench.without_noise(run.course, times, run.begin)
    if bench.rig.name == RIGID:
        return _left_linear(bench, run.course, times, found.force, mass_known)
    target = found.position if bench.rig.name == DRIVEN else found.force
    if not 0.0 < np.ptp(target) < np.inf:
        return np.inf
    return left_by_output_error(bench, run, times, target, mass_known)


def _left_linear(
    bench: Bench, course: Course, times: Array, force: Array, mass_known: bool
) -> float:
    columns = [course(times), course(times, 1)]
    if mass_known:
        force = force - (bench.specimen.mass * course(times, 2) if bench.specimen.mass else 0.0)
    else:
        columns.append(course(times, 2))
    sizes = [np.sqrt(np.mean(column**2)) or 1.0 for column in columns]
    matrix = np.stack([c / size for c, size in zip(columns, sizes, strict=True)], axis=-1)
    fitted = lsq_linear(matrix, force, bounds=(0.0, np.inf))
    return float(np.sqrt(np.mean((matrix @ fitted.x - force) ** 2)))


def left_by_output_error(
    bench: Bench, run: Run, times: Array, target: Array, mass_known: bool
) -> float:
    """Return the rms that the best Kelvin-Voigt fit leaves of an output, whoever simulated it.

    Fitted by output error, SciPy's linear simulation within; positive values by their logarithms.

    Parameters
    ----------
    bench : Bench
        Of a rig that moves by itself; its specimen's values begin the search.
    run : Run
        How the output was excited.
    times, target : array
        The output without noise [N or m] at some times [s].
    mass_known : bool
        Whether the mass is the bench's, or fitted.
    """
    specimen, rig = bench.specimen, bench.rig
    fine = _fine(run, times)
    held = isinstance(run.course, Held)
    driven = run.course.means(fine) if held else run.course(fine)
    size = float(np.sqrt(np.mean((target - target.mean()) ** 2)))

    def residual(unknown: Array) -> Array:
        *logarithms, off = unknown
        k, beta, *free = np.exp(logarithms)
        m = free[0] if free else specimen.mass
        if rig.name == DRIVEN:
            system, at_rest = ([1.0], [m, beta, k]), 1.0 / k
        else:
            # Load over drive: k0 (u - x) with x = (b0 s + k0) u / (m s^2 + (b + b0) s + k + k0).
            k0, b0 = rig.cell_stiffness, rig.cell_damping
            below = np.array([m, beta + b0, k + k0])
            system, at_rest = (k0 * (below - [0.0, b0, k0]), below), k0 * k / (k + k0)
        _, answer, _ = lsim(system, driven - driven[0], fine - fine[0], interp=not held)
        touch = TOUCH * np.tanh(off) if rig.name != DRIVEN else 0.0
        begin = at_rest * (driven[0] - touch)
        return (begin + np.interp(times, fine, answer) - target) / size

    start = [specimen.stiffness, specimen.damping, *([] if mass_known else [specimen.mass])]
    fitted = least_squares(residual, [*np.log(start), 0.0], max_nfev=40)
    return float(size * np.sqrt(np.mean(fitted.fun**2)))


def _fine(run: Run, times: Array) -> Array:
    """Return even times that begin at rest, close enough for straight lines between them."""
    period = min(run.period, run.course.longest_step / 4.0)
    count = int(np.clip((times[-1] - run.begin) / period, 2000, 40000))
    return np.linspace(run.begin, times[-1], count)


def strengthened(
    bench: Bench, run: Run, hidden: Hidden, change: Change, target: float, mass_known: bool
) -> tuple[Bench, float] | None:
    """Return the bench with a part that leaves about ``target`` times the noise, and how much.

    None if no strength of the part's range leaves from ``LEAST`` to ``MOST`` times the noise.
    """

    def ratio(strength: float) -> float:
        changed = change(bench, strength)
        position = run.course(run.times) if bench.rig.name != DRIVEN else np.zeros(2)
        noise = changed.noise(run.period, position)
        return min(left(changed, run, mass_known) / noise, FARTHEST)

    if not hidden.measured:
        found = ratio(1.0)
        return (change(bench, 1.0), found) if found >= LEAST else None
    strength, found = sought(ratio, target, hidden.weakest, hidden.strongest)
    return (change(bench, strength), found) if LEAST <= found <= MOST else None


def sought(
    ratio: Callable[[float], float], target: float, weakest: float, strongest: float
) -> tuple[float, float]:
    """Return a strength that leaves nearly the target, and what it leaves: secants of logarithms.

    A residual grows with the strength, or with its square, so that few steps are enough.
    """
    strength, slope, before = float(np.sqrt(weakest * strongest)), 1.0, None
    found = ratio(strength)
    for _ in range(STEPS):
        if before and strength != before[0] and found > 0.0:
            risen = np.log(found / before[1]) / np.log(strength / before[0])
            slope = float(np.clip(risen, 0.5, 2.5))
        if abs(np.log(found / target)) < NEAR:
            break
        before = strength, found
        strength = float(np.clip(strength * (target / found) ** (1 / slope), weakest, strongest))
        if strength == before[0]:
            break
        found = ratio(strength)
    return strength, found
