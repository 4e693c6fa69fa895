"""The learnt function on a grid, with its band.

Contents: curves of one variable and surfaces of two, beyond a straight line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tissue_probe.diagnosis.shape.free_functions import VARIABLES, Group
from tissue_probe.diagnosis.shape.learnt_curve import Curve
from tissue_probe.diagnosis.shape.paths import Path
from tissue_probe.diagnosis.shape.shape import Shape
from tissue_probe.signals import FloatArray

#: Points of a curve, and of either side of a surface.
POINTS, POINTS_OF_TWO = 41, 15


def curve(found: Shape) -> Curve | None:
    """Return the curve or surface of the chosen variables; None where it would take more axes."""
    chosen = tuple(name for name in VARIABLES if name in found.choice.chosen)
    if chosen in (("indentation",), ("velocity",), ("force",)):
        return _of_signal(found, chosen[0])
    if chosen == ("indentation", "velocity"):
        return _surface(found)
    if chosen == ("past",):
        times = np.geomspace(0.1 / found.functions.rates[-1], 1.0 / found.functions.rates[0], 41)
        left = np.exp(-np.multiply.outer(times, found.functions.rates))
        return _told(found, ["relaxation"], left, chosen, (times,), "N/m")
    if chosen == ("path",):
        ways = found.functions.ways
        way = np.linspace(0.0, ways[-1], POINTS)
        held = np.minimum(way[:, None], ways) / ways
        return _told(found, ["slides"], held, chosen, (way,), "N")
    return None


def _told(
    found: Shape,
    names: Sequence[str],
    columns: FloatArray,
    variables: tuple[str, ...],
    grid: tuple[FloatArray, ...],
    unit: str,
) -> Curve:
    value, sd = _values(found, names, columns)
    return Curve(variables, grid, value, sd, np.ones(value.shape, dtype=bool), unit)


def _values(
    found: Shape, names: Sequence[str], columns: FloatArray
) -> tuple[FloatArray, FloatArray]:
    best = found.choice.best
    places = np.concatenate([found.gram.places[name] for name in names])
    own = [int(np.flatnonzero(best.columns == place)[0]) for place in places]
    value = columns @ best.weights[own]
    spread = np.sum((columns @ best.covariance[np.ix_(own, own)]) * columns, axis=1)
    return value, np.sqrt(np.maximum(spread, 0.0))


def _of_signal(found: Shape, name: str) -> Curve:
    groups = _groups(found, frozenset([name]))
    signals = [getattr(path, name) for path in found.paths]
    low, high = (float(f(np.concatenate(signals))) for f in (np.min, np.max))
    grid = np.linspace(low, high, POINTS)
    at = _at(found, {name: grid})
    columns = np.concatenate([each.columns(at) for each in groups], axis=1)
    columns = _beyond_a_line(found, groups, columns, at, [name])
    return _told(found, [each.name for each in groups], columns, (name,), (grid,), "N")


def _surface(found: Shape) -> Curve:
    names = ("indentation", "velocity")
    groups = _groups(found, frozenset(names))
    signals = [np.concatenate([getattr(path, n) for path in found.paths]) for n in names]
    grid = tuple(np.linspace(each.min(), each.max(), POINTS_OF_TWO) for each in signals)
    x, v = (each.ravel() for each in np.meshgrid(*grid, indexing="ij"))
    at = _at(found, {"indentation": x, "velocity": v})
    columns = np.concatenate([each.columns(at) for each in groups], axis=1)
    columns = _beyond_a_line(found, groups, columns, at, list(names))
    value, sd = _values(found, [each.name for each in groups], columns)
    edges = [np.concatenate([g - 0.5 * (g[1] - g[0]), [g[-1] + 0.5 * (g[1] - g[0])]]) for g in grid]
    visited = np.histogram2d(signals[0], signals[1], bins=edges)[0] > 0
    shape = visited.shape
    return Curve(names, grid, value.reshape(shape), sd.reshape(shape), visited)


def _groups(found: Shape, variables: frozenset[str]) -> list[Group]:
    return [g for g in found.groups if g.variables and g.variables <= variables]


def _at(found: Shape, signals: Mapping[str, FloatArray]) -> Path:
    """Return a path that holds points of a grid, at zero of all else."""
    none = np.zeros(next(iter(signals.values())).size)
    every = [signals.get(name, none) for name in ("indentation", "velocity", "force", "time")]
    return Path(found.paths[0].measurement, *every)


def _beyond_a_line(
    found: Shape, groups: Sequence[Group], columns: FloatArray, at: Path, names: Sequence[str]
) -> FloatArray:
    """Take from columns at a grid the straight lines that fit them best at the samples."""
    some = [_thinned(path) for path in found.paths]
    told = [np.concatenate([g.columns(path) for g in groups], axis=1) for path in some]
    lines = [_lines(path, names) for path in some]
    slopes = np.linalg.lstsq(np.concatenate(lines), np.concatenate(told), rcond=None)[0]
    return np.asarray(columns - _lines(at, names) @ slopes)


def _lines(path: Path, names: Sequence[str]) -> FloatArray:
    """Return a constant and each signal; a velocity alone has no constant."""
    signals = [getattr(path, name) for name in names]
    level = [] if list(names) == ["velocity"] else [np.ones(path.time.size)]
    return np.stack([*level, *signals], axis=1)


def _thinned(path: Path) -> Path:
    step = max(1, path.time.size // 2000)
    signals = (path.indentation, path.velocity, path.force, path.time)
    return Path(path.measurement, *(each[::step] for each in signals))
