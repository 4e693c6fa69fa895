"""Levenberg and Marquardt's search for the values of a model that fit best.

Contents: steps, damping, bounds, when a search has settled or is given up.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg.lapack import dposv

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.outcome import finish_fit
from tissue_probe.diagnosis.fitting.point import SearchPoint, point_at
from tissue_probe.diagnosis.fitting.problem import FARTHEST, Problem
from tissue_probe.diagnosis.sharing import Numbers
from tissue_probe.signals import BoolArray, FloatArray

SEARCH_STEPS = 40
#: The cost counts as settled where a step lowers it by less than this share, or this much.
SETTLED_SHARE, SETTLED = 1e-5, 0.02
#: A step that is damped by more gains little because it is short, and settles nothing.
SHORT = 1.0
#: Damping that holds no step back: the narrowest valleys are as many times longer than wide.
UNDAMPED = 1e-6
#: A search is given up where ten more steps like the last leave more than this times the best.
HOPELESS = 1.5
#: And this share of the noise, where only the excess over it is compared.
LEAST_EXCESS = 0.04
#: And none in so many first steps that are damped by more than this: as it falls they gain more.
FIRST, DAMPED = 10, 0.3
#: Share of its promise that a step is expected to gain, where the last gained less: at a bend.
PROMISE_KEPT = 0.4
#: Share to which damping falls after a step; and after one that follows a refused one: it falls
#: faster with each, since in a valley a refused step will be refused again.
EASE, CAREFUL = 0.1, 0.7
#: A branch of tissue at rest has been pressed in, and is compressed by as much as the tissue at the
#: most; or it was drawn back a little. In shares of that.
DRAWN, PRESSED = 0.25, 1.1


def _solve(
    problem: Problem, point: SearchPoint, damping: float
) -> tuple[FloatArray, list[FloatArray], float]:
    """Return values and starts after one damped Gauss-Newton step, and the cost it promises.

    A value that a step would carry beyond a bound stops there, and the others step again without
    it.
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
        moved = _move_point(logarithmic, whole, step)
        beyond = free & ((moved < lower) | (moved > upper))
        if not beyond.any():
            break
        held = np.clip(moved, lower, upper)
        step[beyond] = _find_unmoved(logarithmic, whole, held)[beyond]
        free &= ~beyond
    moved = np.clip(_move_point(logarithmic, whole, step), lower, upper)
    promised = point.cost - 2 * point.gradient @ step + step @ point.normal @ step
    return moved[:q], [moved[q + i * n :][:n] for i in range(len(point.starts))], float(promised)


def _solution(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Solve by Cholesky's method; by least squares where the matrix is as good as singular."""
    solution: FloatArray
    _, solution, failed = dposv(matrix, right)
    if failed:
        solution = np.asarray(np.linalg.lstsq(matrix, right, rcond=1e-13)[0], dtype=np.float64)
    return solution


def _bounds(problem: Problem, point: SearchPoint) -> tuple[FloatArray, FloatArray]:
    """Return how far values may go, and starts where the probe is not at rest.

    Where it is, coarse steps of the encoder may hide how far from rest it seems to begin; but a
    relaxing branch has been pressed.
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


def _move_point(logarithmic: BoolArray, at: FloatArray, step: FloatArray) -> FloatArray:
    grown = at * np.exp(np.clip(step, -3.0, 3.0))
    return np.where(logarithmic, grown, at + step)


def _find_unmoved(logarithmic: BoolArray, at: FloatArray, held: FloatArray) -> FloatArray:
    ratio = np.where(logarithmic, held / np.where(at != 0, at, 1.0), 1.0)
    return np.where(logarithmic, np.log(np.maximum(ratio, 1e-300)), held - at)


def promise(problem: Problem, values: FloatArray, starts: Sequence[FloatArray]) -> float:
    """Return the cost that one Gauss-Newton step promises."""
    with np.errstate(all="ignore"):
        point = point_at(problem, values, starts)
    return np.inf if point is None else _solve(problem, point, 1e-9)[2]


class Bar:
    """The lowest cost that any search of a comparison has reached so far, here or in a copy.

    ``noise`` is the part of any cost that is not counted: the cost of noise alone, where only
    searches near the best are asked for. Nothing counts that costs more than ``most``.
    """

    def __init__(self, cost: float = np.inf, noise: float = 0.0, most: float = np.inf) -> None:
        self.noise, self.most = noise, most
        self._lowest = Numbers(cost)

    @property
    def cost(self) -> float:
        """The lowest cost so far."""
        return float(self._lowest.both.min())

    def note_cost(self, cost: float) -> None:
        """Note a cost that a search has reached."""
        self._lowest.own = min(cost, self._lowest.own)

    def out_of_reach(self, cost: float, gain: float) -> bool:
        """Whether a search at a cost, which a step lowers by a gain, will not come near."""
        near = max(HOPELESS * (self.cost - self.noise), LEAST_EXCESS * self.noise)
        return cost - 10.0 * gain > min(self.noise + near, self.most)


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
        The unknowns and their cost.
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
        found = descend(problem, values, starts, bar)
        return None if found is None else finish_fit(problem, *found)


def descend(
    problem: Problem, values: FloatArray, starts: Sequence[FloatArray], bar: Bar | None = None
) -> tuple[SearchPoint, bool] | None:
    """Return where ``search`` ends, and whether it settled there, without the numbers of a fit."""
    with np.errstate(all="ignore"):
        point = point_at(problem, values, starts)
        return None if point is None else _descend(problem, point, bar or Bar())


def _descend(problem: Problem, point: SearchPoint, bar: Bar) -> tuple[SearchPoint, bool]:
    damping, ease, settled, gain = 1e-3, EASE, False, np.inf
    for step in range(SEARCH_STEPS):
        values, starts, promised = _solve(problem, point, damping)
        hoped = max(gain, PROMISE_KEPT * (point.cost - promised))
        judged = damping < DAMPED or step >= FIRST
        if judged and bar.out_of_reach(point.cost, hoped):
            break
        trial = point_at(problem, values, starts, point.cost)
        if trial is None:
            damping, ease = max(damping, 1e-7) * 8.0, CAREFUL
            if damping > 1e6 or (gain < _least(point) and _is_lowest(problem, point)):
                settled = True
                break
            continue
        gain = point.cost - trial.cost
        settled = (
            damping < SHORT
            and gain < _least(trial)
            and (damping < UNDAMPED or _is_lowest(problem, trial))
        )
        point, damping, ease = trial, damping * ease, max(ease**2, EASE)
        if settled:
            break
    bar.note_cost(point.cost)
    return point, settled


def _least(point: SearchPoint) -> float:
    """Return the gain below which a cost counts as settled."""
    return max(SETTLED_SHARE * point.cost, SETTLED)


def _is_lowest(problem: Problem, point: SearchPoint) -> bool:
    """Whether a step that is not damped would gain little.

    Along a valley that only a tolerance of the rig closes a damped step goes hardly anywhere; and
    where a step gained next to nothing, and the next is refused, this tells a bottom from a bend.
    """
    return point.cost - _solve(problem, point, 1e-9)[2] < _least(point)
