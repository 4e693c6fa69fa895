"""Fitting a composed model by output error to what was measured of what it predicts.

What belongs here: the least-squares problem (unknowns, priors, scales) and its solution by
Levenberg and Marquardt's method with exact sensitivities.
What does not: which models to fit (``candidates``), what the result means (``ranking``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from scipy.fft import dct, idct
from scipy.linalg import eigh
from scipy.linalg.lapack import dposv

from tissue_probe.diagnosis.flicker import evened, flicker_weights
from tissue_probe.diagnosis.measurement import BoolArray, Instrument, Measurement
from tissue_probe.diagnosis.whiteness import colour, unevenness
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.response import course, respond
from tissue_probe.physics.rounding import COARSE, smoothed
from tissue_probe.quantities import POSITION, Quantity
from tissue_probe.signals import FloatArray

MOST_STEPS = 40
#: The cost counts as settled where a step lowers it by less than this share, or this much.
SETTLED_SHARE, SETTLED = 1e-5, 0.02
#: A search is given up where ten more steps like the last leave more than this times the best.
HOPELESS = 1.5
#: And this share of the noise, where only what exceeds it is compared.
LEAST_EXCESS = 0.04
#: And none in so many first steps that are damped by more than this: as it falls they gain more.
FIRST, DAMPED = 10, 0.3
#: Share of its promise that a step is expected to gain, where the last gained less: at a bend.
KEPT = 0.4
#: Share to which damping falls after a step; and after one that follows a refused one: it falls
#: faster with each, since in a valley what was refused will be again.
EASE, CAREFUL = 0.1, 0.7
BLOCKS = 8
#: A rig's constant stays within this many standard deviations of its tolerance, and the start of a
#: motion that goes on of its prior. Where the model lacks an effect, its residual would else
#: outweigh any prior, and rig or start make up for the effect.
FARTHEST = 4.0
#: A branch of tissue at rest has been pressed in, and is compressed by as much as the tissue at the
#: most; or it was drawn back a little. In shares of that.
DRAWN, PRESSED = 0.25, 1.1
#: Parameters whose bounds span more than this factor are searched by their logarithm.
LOGARITHMIC = 50.0


@dataclass(frozen=True, eq=False)
class Fit:
    """A model fitted to measurements; errors are in the unit of ``output``.

    Attributes
    ----------
    composition : Composition
        The model.
    measurements : tuple of Measurement
        What it was fitted to.
    values : array, shape (q,)
        Constants and parameters, in the order of ``composition.values``.
    starts : tuple of array
        The states at the first sample of each measurement.
    covariance : array, shape (q, q)
        Of the values' errors; rows of what was held are 0.
    residuals : tuple of array
        Measured minus simulated output.
    evened : tuple of array
        The same with flicker noise, and what a force's noise shakes, made white: noise alone would
        leave white noise of each measurement's ``noise``.
    misfits : tuple of float
        Sum of squared residuals of each measurement over its noise, flicker noise weighed as such.
    cost : float
        Sum of the misfits, and of squared departures from the priors.
    unknowns : int
        How many parameters were free (the rig's tolerances and the starts not counted).
    start_penalty : float
        What the freedom of the effects' states at the start costs (Laplace's evidence): the log of
        how many times narrower the data make their prior, of each state up to a parameter's cost.
    heldout : tuple of array
        Residuals of each eighth of the record when the values are fitted to the other seven
        (to first order in what that changes).
    converged : bool
        Whether the search settled.
    rounding : float
        What an encoder's rounding leaves in the simulated force, rms [N], where the model smooths
        or corrects the position; 0 where it does not.
    colour, unevenness : float
        How slow what is left is, and how far from even over the frequencies (``whiteness``).
    strain : float
        Sum of squared departures from the priors, those of the rig's tolerances and of the starts.
    exhausted : tuple of str
        Constants of the rig that ended where the search of them ends, `FARTHEST` standard
        deviations off.
    """

    composition: Composition
    measurements: tuple[Measurement, ...]
    values: FloatArray
    starts: tuple[FloatArray, ...]
    covariance: FloatArray
    residuals: tuple[FloatArray, ...]
    evened: tuple[FloatArray, ...]
    heldout: tuple[FloatArray, ...]
    misfits: tuple[float, ...]
    cost: float
    unknowns: int
    start_penalty: float
    converged: bool
    rounding: float
    colour: float
    unevenness: float
    strain: float
    exhausted: tuple[str, ...] = ()

    @property
    def samples(self) -> int:
        """How many samples were fitted."""
        return sum(int(np.sum(measurement.used)) for measurement in self.measurements)

    @cached_property
    def rmse(self) -> float:
        """Root mean square of the residual."""
        return self._rms(self.residuals)

    @cached_property
    def heldout_rmse(self) -> float:
        """Root mean square of the residual of what was left out of the fit."""
        return self._rms(self.heldout)

    def error(self, index: int) -> float:
        """Root mean square of the residual of one measurement."""
        used = self.residuals[index][self.measurements[index].used]
        return float(np.sqrt(np.mean(used**2)))

    @property
    def worst(self) -> int:
        """Which measurement holds most of the squared residual over the noise."""
        return int(np.argmax(self.misfits))

    @property
    def output(self) -> Quantity:
        """What the model predicts, and its unit."""
        return self.composition.output

    def _rms(self, parts: Sequence[FloatArray]) -> float:
        used = [part[m.used] for part, m in zip(parts, self.measurements, strict=True)]
        return float(np.sqrt(np.mean(np.concatenate(used) ** 2)))

    @cached_property
    def ratio(self) -> float:
        """Residual over noise, root mean square: 1 where nothing is left to explain."""
        squares = [
            misfit / (1.0 + (self.rounding / measurement.noise) ** 2)
            for misfit, measurement in zip(self.misfits, self.measurements, strict=True)
        ]
        return float(np.sqrt(sum(squares) / self.samples))

    @property
    def floor(self) -> float:
        """Cost that noise alone would leave, an encoder's rounding counted as such."""
        parts = [np.sum(m.used) * (1.0 + (self.rounding / m.noise) ** 2) for m in self.measurements]
        return float(sum(parts))

    @property
    def noise(self) -> float:
        """Standard deviation of the output's white noise over all measurements."""
        squares = [m.noise**2 * np.sum(m.used) for m in self.measurements]
        return float(np.sqrt(sum(squares) / self.samples))

    @property
    def excess(self) -> float:
        """Root mean square of what a residual holds beyond the output's white noise."""
        return float(np.sqrt(max(self.rmse**2 - self.noise**2, 0.0)))

    @property
    def bic(self) -> float:
        """Bayesian information criterion, the noise's level being unknown.

        What an encoder's rounding is known to leave is not held against a model that says so; for
        saying so it pays as for noise that is larger by as much.
        """
        counted = self.unknowns * np.log(self.samples) + self.start_penalty
        cost = max(self.cost, np.finfo(float).tiny)  # zeros are fitted without a rest
        if self.rounding > 0.0:
            share = (self.rounding / self.noise) ** 2
            left = max(cost - self.samples * share, self.samples)
            cost = left + self.samples * np.log1p(share)
        return float(self.samples * np.log(cost) + counted)

    @property
    def predicted(self) -> tuple[FloatArray, ...]:
        """Simulated output of each measurement."""
        return tuple(
            measurement.output_values - residual
            for measurement, residual in zip(self.measurements, self.residuals, strict=True)
        )

    @property
    def tip(self) -> tuple[FloatArray, ...]:
        """Displacement of the tip in each measurement, as far as the model says [m]."""
        if self.output is POSITION:
            return self.predicted
        stiffness = self.named().get("load_cell_stiffness", np.inf)
        return tuple(
            measurement.position - force / stiffness
            for measurement, force in zip(self.measurements, self.predicted, strict=True)
        )

    def named(self) -> dict[str, float]:
        """Return values by name."""
        return dict(zip(self.composition.kernel.values, map(float, self.values), strict=True))

    def deviations(self) -> dict[str, float]:
        """Return standard deviations of the values by name."""
        deviations = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        return dict(zip(self.composition.kernel.values, map(float, deviations), strict=True))


class Begin(NamedTuple):
    """What is known beforehand of the states at a first sample: where they are, and how well.

    ``precision``, shape (n, n), is the inverse of their covariance.
    """

    mean: FloatArray
    deviation: FloatArray
    precision: FloatArray


@lru_cache(maxsize=64)
def history(rates: bytes) -> FloatArray:
    """Return the inverse correlation of states that forget one history at these rates [1/s].

    A branch that forgets at the rate r holds the integral of exp(-r s) x'(-s) over the time s
    before the first sample. Of a tip's velocity x' that may have been any, as white noise, two
    branches hold what correlates as 2 sqrt(r q) / (r + q): nearly the same where rates are near.
    States that do not forget, of rate 0, have each its own start, and so has what forgets at once.

    Parameters
    ----------
    rates : bytes
        Those of an array of float64, shape (n,).

    Returns
    -------
    array, shape (n, n)
    """
    r = np.frombuffer(rates)
    branches = np.flatnonzero((r > 0.0) & np.isfinite(r))
    inverse = np.eye(r.size)
    if branches.size > 1:
        r = r[branches]
        alike = 2.0 * np.sqrt(np.multiply.outer(r, r)) / np.add.outer(r, r)
        # Two of one rate are one: what tells them apart is nothing but rounding.
        alike.flat[:: r.size + 1] += 1e-6
        inverse[np.ix_(branches, branches)] = np.linalg.inv(alike)
    return inverse


class Problem:
    """Unknowns of a model under measurements: what is searched, in which scale, with what priors.

    The unknowns are the values (constants of the rig held or drawn to their tolerances), then the
    states at the start of each measurement, drawn to where a probe at rest has them.

    Parameters
    ----------
    composition : Composition
        The model.
    measurements : sequence of Measurement
        All of one specimen.
    instrument : Instrument
        What is known of the rig.
    """

    def __init__(
        self,
        composition: Composition,
        measurements: Sequence[Measurement],
        instrument: Instrument,
        held: Mapping[str, float] | None = None,
    ) -> None:
        self.composition = composition
        self.measurements = tuple(measurements)
        _check_output(composition, self.measurements)
        self.kernel = composition.kernel
        self.held = dict(held or {})
        entries = composition.values
        constants = instrument.constants
        self.nominal = np.array([constants.get(e.name, (e.default, 0.0))[0] for e in entries])
        deviation = [constants.get(e.name, (0.0, np.inf))[1] for e in entries]
        self.deviation = np.array(deviation)
        for index, entry in enumerate(entries):
            if entry.name in self.held:
                self.nominal[index], self.deviation[index] = self.held[entry.name], 0.0
        own = np.isinf(self.deviation)
        self.lower = np.array([e.lower for e in entries])
        self.upper = np.array([e.upper for e in entries])
        tolerated = ~own & (self.deviation > 0)
        reach = np.where(tolerated, FARTHEST * self.deviation, 0.0)
        self.lower = np.where(tolerated, np.maximum(self.lower, self.nominal - reach), self.lower)
        self.upper = np.where(tolerated, np.minimum(self.upper, self.nominal + reach), self.upper)
        self.logarithmic = own & (self.lower > 0)
        self.logarithmic &= self.upper > LOGARITHMIC * np.where(self.lower > 0, self.lower, 1.0)
        self.free = self.deviation > 0
        self.unknowns = int(np.sum(own))
        self.states = len(self.kernel.states)
        self.count = len(entries)
        self.drawn = np.flatnonzero(tolerated)
        begun = self.states * len(self.measurements)
        self.searched = np.concatenate([self.free, np.ones(begun, dtype=bool)])
        self.by_logarithm = np.concatenate([self.logarithmic, np.zeros(begun, dtype=bool)])
        flicker = instrument.flicker_noise
        self.weights = [
            flicker_weights(m.force.size, flicker / m.noise) if flicker else None
            for m in self.measurements
        ]

    def begin(self, values: FloatArray) -> list[Begin]:
        """Return what is known beforehand of the states at the start of each measurement."""
        alike = history(self.kernel.relaxation_rates(values).tobytes())
        begins = []
        for measurement in self.measurements:
            extent = measurement.extent
            z = self.kernel.begin(values, measurement.position[0], measurement.force[0])
            loaded = abs(self._indentation(values, z, measurement.position[0]))
            depth = extent.indentation + loaded
            still = measurement.at_rest
            if not still:  # all that moves goes with the coil
                z[[spread == "speed" for spread in self.kernel.spreads]] = measurement.first_speed
            length = loaded + 1e-8 if still else depth
            spreads = {
                **dict(zip(self.kernel.values, map(float, values), strict=True)),
                "free": depth,
                "length": length,
                "branch": length,
                "speed": 1e-4 if still else 2 * extent.speed,
                "none": 2 * measurement.noise,
            }
            deviation = np.array([spreads[name] for name in self.kernel.spreads])
            begins.append(Begin(z, deviation, alike / np.multiply.outer(deviation, deviation)))
        return begins

    def _indentation(self, values: FloatArray, z: FloatArray, position: float) -> float:
        """Indentation at the start: a state where the load cell yields, else the coil's place."""
        if "free" in self.kernel.spreads:
            return float(z[self.kernel.spreads.index("free")])
        return float(position - values[self.kernel.values.index("contact_position")])

    def simulate(
        self, values: FloatArray, starts: Sequence[FloatArray]
    ) -> list[tuple[FloatArray, FloatArray]]:
        """Residual and sensitivity of the output for each measurement."""
        result = []
        for measurement, start in zip(self.measurements, starts, strict=True):
            coil = course(self.kernel, measurement.input_values, measurement.sample_period, values)
            response = respond(self.kernel, values, start, coil)
            result.append((measurement.output_values - response.output, response.sensitivity))
        return result

    def weighed(self, index: int, columns: FloatArray) -> FloatArray:
        """Return samples of a measurement, shape (N,) or (N, m), over the noise in them."""
        over_noise, weights = self.measurements[index].over_noise(columns), self.weights[index]
        return over_noise if weights is None else evened(over_noise, weights)


def _check_output(composition: Composition, measurements: Sequence[Measurement]) -> None:
    output = composition.output
    for measurement in measurements:
        if measurement.output is not output:
            raise ValueError(
                f"the rig {composition.rig} predicts the {output.name}, and the measurement is for "
                f"one that predicts the {measurement.output.name}; give Measurement(output=...)"
            )


@dataclass
class _Point:
    """Where a search stands: unknowns, cost, and the normal equations there."""

    values: FloatArray
    starts: list[FloatArray]
    begins: list[Begin]
    cost: float
    misfits: list[float]
    gradient: FloatArray
    normal: FloatArray
    simulated: list[tuple[FloatArray, FloatArray]]


def _scale(problem: Problem, values: FloatArray) -> FloatArray:
    """Return d value / d unknown: the value itself where its logarithm is searched."""
    return np.where(problem.logarithmic, values, 1.0)


def _point(
    problem: Problem, values: FloatArray, starts: Sequence[FloatArray], most: float = np.inf
) -> _Point | None:
    """Evaluate cost and normal equations; None where the cost exceeds the most, or is infinite."""
    simulated, begins = problem.simulate(values, starts), problem.begin(values)
    if not all(np.isfinite(residual).all() for residual, _ in simulated):
        return None
    weighed = [problem.weighed(index, residual) for index, (residual, _) in enumerate(simulated)]
    misfits = [float(r @ r) for r in weighed]
    drawn, deviation = problem.drawn, problem.deviation[problem.drawn]
    departure = (problem.nominal - values)[drawn] / deviation
    off = [begun.mean - start for begun, start in zip(begins, starts, strict=True)]
    back = [begun.precision @ each for begun, each in zip(begins, off, strict=True)]
    strain = float(departure @ departure) + sum(
        float(a @ b) for a, b in zip(off, back, strict=True)
    )
    cost = sum(misfits) + strain
    if cost > most:
        return None
    q, n = problem.count, problem.states
    size = q + n * len(simulated)
    normal, gradient = np.zeros((size, size)), np.zeros(size)
    scale = np.ones(size)
    scale[:q] = _scale(problem, values)
    for index, (_, sensitivity) in enumerate(simulated):
        J = problem.weighed(index, sensitivity)
        own = q + index * n + np.arange(n)
        place = np.concatenate([own, np.arange(q)])
        scaled = scale[place]
        normal[place[:, None], place] += (J.T @ J) * (scaled[:, None] * scaled)
        gradient[place] += (J.T @ weighed[index]) * scaled
        normal[own[:, None], own] += begins[index].precision
        gradient[own] += back[index]
    normal[drawn, drawn] += deviation**-2
    gradient[drawn] += departure / deviation
    if not np.isfinite(normal).all():
        return None
    return _Point(values, list(starts), begins, cost, misfits, gradient, normal, simulated)


def _solve(
    problem: Problem, point: _Point, damping: float
) -> tuple[FloatArray, list[FloatArray], float]:
    """Return values and starts after one damped Gauss-Newton step, and the cost it promises.

    What a step would carry beyond a bound stops there, and the rest steps again without.
    """
    q, n = problem.count, problem.states
    diagonal = np.diag(point.normal)
    free = problem.searched & (diagonal > 0)
    whole = np.concatenate([point.values, *point.starts])
    lower, upper = _bounds(problem, point)
    logarithmic = problem.by_logarithm
    step = np.zeros(free.size)
    for _ in range(4):
        index = np.flatnonzero(free)
        if not index.size:
            break
        root = np.sqrt(diagonal[index])
        scaled = point.normal[index[:, None], index] / (root[:, None] * root)
        scaled.flat[:: index.size + 1] += damping + 1e-12
        rest = (point.gradient - point.normal @ np.where(free, 0.0, step))[index]
        step[index] = _solution(scaled, rest / root) / root
        moved = _moved(logarithmic, whole, step)
        beyond = free & ((moved < lower) | (moved > upper))
        if not beyond.any():
            break
        held = np.clip(moved, lower, upper)
        step[beyond] = _unmoved(logarithmic, whole, held)[beyond]
        free &= ~beyond
    moved = np.clip(_moved(logarithmic, whole, step), lower, upper)
    promised = point.cost - 2 * point.gradient @ step + step @ point.normal @ step
    return moved[:q], [moved[q + i * n :][:n] for i in range(len(point.starts))], float(promised)


def _solution(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Solve by Cholesky's method; by least squares where the matrix is as good as singular."""
    _, solution, failed = dposv(matrix, right)
    return np.linalg.lstsq(matrix, right, rcond=1e-13)[0] if failed else solution


def _bounds(problem: Problem, point: _Point) -> tuple[FloatArray, FloatArray]:
    """Return how far values may go, and starts where the probe is not at rest.

    Where it is, coarse steps of the encoder may hide how far from rest it seems to begin; but what
    relaxes has been pressed.
    """
    relaxing = np.array([spread == "branch" for spread in problem.kernel.spreads], dtype=bool)
    lower, upper = [problem.lower], [problem.upper]
    for measurement, (mean, deviation, _) in zip(problem.measurements, point.begins, strict=True):
        back = ahead = FARTHEST * deviation
        if measurement.at_rest:
            back = np.where(relaxing, DRAWN * deviation, np.inf)
            ahead = np.where(relaxing, PRESSED * deviation, np.inf)
        lower.append(mean - back)
        upper.append(mean + ahead)
    return np.concatenate(lower), np.concatenate(upper)


def _moved(logarithmic: BoolArray, at: FloatArray, step: FloatArray) -> FloatArray:
    grown = at * np.exp(np.clip(step, -3.0, 3.0))
    return np.where(logarithmic, grown, at + step)


def _unmoved(logarithmic: BoolArray, at: FloatArray, held: FloatArray) -> FloatArray:
    ratio = np.where(logarithmic, held / np.where(at != 0, at, 1.0), 1.0)
    return np.where(logarithmic, np.log(np.maximum(ratio, 1e-300)), held - at)


def promise(problem: Problem, values: FloatArray, starts: Sequence[FloatArray]) -> float:
    """Return the cost that one Gauss-Newton step promises."""
    with np.errstate(all="ignore"):
        point = _point(problem, values, starts)
    return np.inf if point is None else _solve(problem, point, 1e-9)[2]


@dataclass
class Bar:
    """The lowest cost that any search of a comparison has reached so far.

    ``noise`` is the part of any cost that is not counted: what is left by noise alone, where only
    what comes near the best is asked for.
    """

    cost: float = np.inf
    noise: float = 0.0

    def out_of_reach(self, cost: float, gain: float) -> bool:
        """Whether a search at a cost, which a step lowers by a gain, will not come near."""
        near = max(HOPELESS * (self.cost - self.noise), LEAST_EXCESS * self.noise)
        return cost - 10.0 * gain - self.noise > near


def search(
    problem: Problem,
    values: FloatArray,
    starts: Sequence[FloatArray],
    bar: Bar | None = None,
) -> Fit | None:
    """Minimise the cost from a starting point (Levenberg 1944, Marquardt 1963).

    Parameters
    ----------
    problem : Problem
        What is searched.
    values : array, shape (q,)
        Where to begin.
    starts : sequence of array
        The states at the first sample of each measurement.
    bar : Bar, optional
        Of a comparison: searches that will not come near the best are given up.

    Returns
    -------
    Fit or None
        None where the model cannot be simulated at the starting point.
    """
    with np.errstate(all="ignore"):
        point = _point(problem, values, starts)
        return None if point is None else _descend(problem, point, bar or Bar())


def _descend(problem: Problem, point: _Point, bar: Bar) -> Fit:
    damping, ease, settled, gain = 1e-3, EASE, False, np.inf
    for step in range(MOST_STEPS):
        values, starts, promised = _solve(problem, point, damping)
        hoped = max(gain, KEPT * (point.cost - promised))
        judged = damping < DAMPED or step >= FIRST
        if judged and bar.out_of_reach(point.cost, hoped):
            break
        trial = _point(problem, values, starts, point.cost)
        if trial is None:
            damping, ease = max(damping, 1e-7) * 8.0, CAREFUL
            if damping > 1e6:
                settled = True
                break
            continue
        gain = point.cost - trial.cost
        settled = gain < max(SETTLED_SHARE * trial.cost, SETTLED)
        point, damping, ease = trial, damping * ease, max(ease**2, EASE)
        if settled:
            break
    bar.cost = min(bar.cost, point.cost)
    return _finish(problem, point, settled)


def _finish(problem: Problem, point: _Point, converged: bool) -> Fit:
    q = problem.count
    free = np.flatnonzero(np.diag(point.normal) > 0)
    free = free[(free >= q) | problem.free[np.minimum(free, q - 1)]]
    covariance = np.zeros((q, q))
    root = np.sqrt(np.diag(point.normal)[free])
    scaled = point.normal[np.ix_(free, free)] / np.outer(root, root)
    inverse = np.linalg.pinv(scaled, rcond=1e-12, hermitian=True) / np.outer(root, root)
    own = free < q
    scale = _scale(problem, point.values)[free[own]]
    covariance[np.ix_(free[own], free[own])] = inverse[np.ix_(own, own)] * np.outer(scale, scale)
    samples = sum(int(np.sum(measurement.used)) for measurement in problem.measurements)
    excess = max(1.0, point.cost / samples)
    cosines = _cosines(problem, point)
    return Fit(
        composition=problem.composition,
        measurements=problem.measurements,
        values=point.values,
        starts=tuple(point.starts),
        covariance=covariance * excess,
        residuals=tuple(residual for residual, _ in point.simulated),
        evened=tuple(
            m.noise * idct(each, norm="ortho")
            for m, each in zip(problem.measurements, cosines, strict=True)
        ),
        heldout=tuple(_left_out(problem, point)),
        misfits=tuple(point.misfits),
        cost=point.cost,
        unknowns=problem.unknowns,
        start_penalty=_start_penalty(problem, point),
        converged=converged,
        rounding=_rounding(problem, point),
        colour=colour(cosines),
        unevenness=unevenness(cosines),
        strain=point.cost - sum(point.misfits),
        exhausted=_exhausted(problem, point.values),
    )


def _exhausted(problem: Problem, values: FloatArray) -> tuple[str, ...]:
    """Name the constants whose tolerances a fit has used up."""
    farthest = FARTHEST * (1.0 - 1e-9) * problem.deviation
    ended = np.abs(values - problem.nominal) >= farthest
    return tuple(problem.kernel.values[index] for index in problem.drawn if ended[index])


def _cosines(problem: Problem, point: _Point) -> list[FloatArray]:
    """Return the cosines of each measurement's residual, white where it is noise."""
    cosines = []
    for index, (residual, _) in enumerate(point.simulated):
        over_noise = problem.weighed(index, residual)
        if problem.weights[index] is None:
            over_noise = dct(over_noise, norm="ortho")
        cosines.append(over_noise)
    return cosines


def _rounding(problem: Problem, point: _Point) -> float:
    """Simulate an error that rounding of the position may have left; rms of the force [N].

    It counts where a model smooths coarse steps, and where it undoes an error of a fine encoder:
    that makes the rounding larger wherever two positions read nearly alike. Coarse steps that a
    model does not smooth are no noise to be counted, but something that it lacks.
    """
    kernel, values = problem.kernel, point.values.copy()
    smooths = kernel.rounded >= 0 and values[kernel.rounded] > 0
    fine = all(measurement.extent.step <= COARSE for measurement in problem.measurements)
    if not smooths and not (kernel.moves_position and fine):
        return 0.0
    step = values[kernel.rounded] if smooths else 0.0
    if smooths:
        values[kernel.rounded] = 0.0  # what follows is smoothed already
    changes = []
    for m, start in zip(problem.measurements, point.starts, strict=True):
        right, wrong = (
            respond(kernel, values, start, course(kernel, u, m.sample_period, values)).output
            for u in _as_read(m, step)
        )
        changes.append((wrong - right)[m.used])
    return float(np.sqrt(np.mean(np.concatenate(changes) ** 2)))


def _as_read(measurement: Measurement, step: float) -> tuple[FloatArray, FloatArray]:
    """Return the position that is taken for the true one, and one as likely; smooth for a step."""
    if step > 0.0:
        found = smoothed(measurement.position, step)
        return found.course, found.course + found.error
    if measurement.misread is not None:
        return measurement.position, measurement.position + measurement.misread
    error = np.random.default_rng(0).uniform(-0.5, 0.5, measurement.position.size)
    return measurement.position, measurement.position + measurement.extent.step * error


def _start_penalty(problem: Problem, point: _Point) -> float:
    """Log of how many times the samples narrow what was known beforehand of the starts.

    Summed over what they tell apart of them, and of each no more than a parameter costs: the BIC
    takes a parameter for known beforehand as well as one sample tells it.
    """
    q, n = problem.count, problem.states
    own = [
        i
        for i, spread in enumerate(problem.kernel.spreads)
        if spread in ("length", "branch") or spread in problem.kernel.values
    ]
    penalty = 0.0
    for index, begun in enumerate(point.begins if own else []):
        place = np.array([q + index * n + i for i in own])
        scale = np.outer(begun.deviation[own], begun.deviation[own])
        after = point.normal[np.ix_(place, place)] * scale
        narrower = eigh(after, begun.precision[np.ix_(own, own)] * scale, eigvals_only=True)
        costs = np.log(np.maximum(narrower, 1.0))
        samples = np.sum(problem.measurements[index].used)
        penalty += float(np.sum(np.minimum(costs, np.log(samples))))
    return penalty


def _left_out(problem: Problem, point: _Point) -> list[FloatArray]:
    """Return each block's residual with the values fitted to the others only.

    With J the sensitivities of block B and A the normal matrix, leaving B out changes its residual
    to r + J (A - J^T J)^-1 J^T r, exactly so for a model linear in its values; J^T J and J^T r over
    the noise, of which flicker noise is left aside.
    """
    q, n = problem.count, problem.states
    own = np.flatnonzero(problem.free & (np.diag(point.normal)[:q] > 0))
    scale = _scale(problem, point.values)[own]
    by_value = [sensitivity[:, n:][:, own] * scale for _, sensitivity in point.simulated]
    pairs = zip(problem.measurements, by_value, strict=True)
    over_noise = [measurement.over_noise(each) for measurement, each in pairs]
    whole = np.diag((scale / problem.deviation[own]) ** 2) + sum(J.T @ J for J in over_noise)
    root = np.sqrt(np.diag(whole))
    left = []
    for index, J in enumerate(over_noise):
        residual = point.simulated[index][0]
        r = problem.measurements[index].over_noise(residual)
        out = residual.copy()
        for block in np.array_split(np.arange(residual.size), BLOCKS):
            rest = (whole - J[block].T @ J[block]) / np.outer(root, root)
            # What only this block tells would be unknown without it; it stays within reason.
            rest[np.diag_indices(own.size)] += 1e-2
            out[block] += by_value[index][block] @ (
                np.linalg.solve(rest, J[block].T @ r[block] / root) / root
            )
        left.append(out)
    return left
