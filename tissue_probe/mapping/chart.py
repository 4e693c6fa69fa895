"""The surface of the sites, laid flat: places of a map, and where these lie in space.

A map is flat, and a probe feels along the surface. On an upright wall, x of the sites is the same
everywhere; on a cap, x and y shorten its rim. So sites that lie on an inclined plane are mapped in
that plane, and those on a bent surface at their distances along it, by classical scaling of these
(W. S. Torgerson, Multidimensional scaling, Psychometrika 17 (1952) 401).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import orthogonal_procrustes
from scipy.spatial import Delaunay, QhullError
from scipy.spatial.distance import pdist, squareform

from tissue_probe.errors import ParameterError
from tissue_probe.likeness import Alike
from tissue_probe.mapping.height import height_over
from tissue_probe.mapping.lift import Lift
from tissue_probe.mapping.posterior.domain import TIP
from tissue_probe.mapping.posterior.posterior_sample import FORM_ERROR
from tissue_probe.mapping.sites import Sites
from tissue_probe.signals import FloatArray

#: Steeper over its own middle plane, a surface rises by more between two sites than they are apart
#: on that plane, twofold: two sheets of a fold look like that, and the sites do not tell them
#: apart. A rise of less than a tip's radius is none.
_STEEPEST_SURFACE = 2.0
#: Straight pieces of a path between two sites.
_PATH_PIECES = 16


@dataclass(frozen=True)
class Chart:
    """The sites in a flat map, and the way back.

    Attributes
    ----------
    sites : Sites
        Their x and y are places in the map; z is 0 where the surface was laid flat.
    places : callable
        Gives the places in space of places in the map.
    note : str
        How the surface was laid flat, in a sentence; empty where x and y are the sites' own.
    """

    sites: Sites
    places: Lift
    note: str

    @staticmethod
    def of(sites: Sites) -> Chart:
        """Return the chart of sites.

        x and y are kept where distances in them are right to 2 %: the map allows as much for the
        form of an inclusion.

        Raises
        ------
        ParameterError
            If the surface folds over: no flat map shows it.
        """
        told = sites.felt if sites.felt.any() else np.ones(sites.x.size, dtype=bool)
        points = np.column_stack([sites.x, sites.y, sites.z])
        plane = _Plane.of(points[told])
        flat = plane.flat(points)
        if _measure_lengthening(flat[told]) > FORM_ERROR:
            return _bent(sites, flat, told, plane)
        upright = plane.axes[2, 2]
        if upright >= 1.0 - FORM_ERROR:
            return Chart(sites, _Over(points), "")
        note = (
            f"the sites lie in a plane tilted by {np.degrees(np.arccos(upright)):.0f} degrees: x "
            "and y of the map run in that plane; X, Y, Z are the sites' own frame"
        )
        return Chart(_move_sites(sites, flat), _Over(flat, plane), note)


@dataclass(frozen=True, eq=False)
class _Plane(Alike):
    """A plane through the middle of points, and its axes, the normal last, shape (3, 3)."""

    middle: FloatArray
    axes: FloatArray

    @staticmethod
    def of(points: FloatArray) -> _Plane:
        """Return the plane from which points are off least.

        Its axes are x, y, z turned the shortest way: of a plane that is hardly tilted they are
        hardly changed. Points on a line tell no plane: the one that is tilted least is taken.
        """
        middle = points.mean(axis=0)
        return _Plane(middle, _turn_to_normal(_normal(points - middle)))

    def flat(self, points: FloatArray) -> FloatArray:
        """Return points in space on the plane, and off it; their middle keeps its x and y."""
        return np.asarray((points - self.middle) @ self.axes.T + self._shift)

    def lift_points(self, flat: FloatArray) -> FloatArray:
        """Return points of the plane in space."""
        return np.asarray(self.middle + (flat - self._shift) @ self.axes)

    @property
    def _shift(self) -> FloatArray:
        return np.array([self.middle[0], self.middle[1], 0.0])


def _normal(points: FloatArray) -> FloatArray:
    """Return the direction across points about their middle, of length 1 and upwards."""
    _, sizes, directions = np.linalg.svd(points, full_matrices=True)
    sizes = np.append(sizes, np.zeros(3 - sizes.size))
    normal = directions[2]
    if sizes[1] <= FORM_ERROR * sizes[0] or len(points) < 3:
        along = directions[0] if sizes[0] > 0.0 else np.array([1.0, 0.0, 0.0])
        normal = np.array([0.0, 0.0, 1.0]) - along[2] * along
        normal = normal / np.linalg.norm(normal) if np.any(normal) else np.array([1.0, 0.0, 0.0])
    # Upwards; of an upright plane, along the axis that it faces most.
    faces = 2 if abs(normal[2]) > 1e-9 else int(np.abs(normal).argmax())
    return np.asarray(normal * np.sign(normal[faces]))


def _turn_to_normal(normal: FloatArray) -> FloatArray:
    """Return x, y, z turned the shortest way to where z is the normal, a row each (Rodrigues)."""
    x, y, z = normal
    cross = np.array([[0.0, 0.0, x], [0.0, 0.0, y], [-x, -y, 0.0]])
    turn = np.eye(3) + cross + cross @ cross / (1.0 + z)
    return np.asarray(turn.T)


def _edges(flat: FloatArray) -> np.ndarray:
    """Return pairs of neighbours on the plane, shape (m, 2); none of places on one line."""
    try:
        corners = Delaunay(flat[:, :2]).simplices
    except QhullError:
        return np.zeros((0, 2), dtype=int)
    pairs = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def _measure_lengthening(flat: FloatArray) -> float:
    """Return by how much ways between neighbours are longer than on the plane, relative."""
    edges = _edges(flat)
    if not len(edges):
        return 0.0
    apart = flat[edges[:, 0]] - flat[edges[:, 1]]
    return float(np.linalg.norm(apart, axis=1).sum() / np.hypot(*apart[:, :2].T).sum() - 1.0)


def _bent(sites: Sites, flat: FloatArray, told: np.ndarray, plane: _Plane) -> Chart:
    """Return the chart of a bent surface, by distances along it."""
    # SciPy's interpolators take a second to import, and nodes import this module.
    from scipy.interpolate import RBFInterpolator

    _refuse_fold(sites, flat, told)
    surface = _pool_visits(flat[told])
    laid = _laid_flat(surface)
    note = (
        "the sites lie on a bent surface: x and y of the map run along it; X, Y, Z are the sites' "
        "own frame"
    )
    places = RBFInterpolator(surface[:, :2], laid)(flat[:, :2])
    return Chart(_move_sites(sites, places), _Unrolled(laid, surface, plane), note)


def _pool_visits(flat: FloatArray) -> FloatArray:
    """Return one point for all visits of a place: to the um, at their mean height."""
    places, of_place, visits = np.unique(
        np.round(flat[:, :2], 6), axis=0, return_inverse=True, return_counts=True
    )
    return np.column_stack([places, np.bincount(of_place.ravel(), flat[:, 2]) / visits])


def _refuse_fold(sites: Sites, flat: FloatArray, told: np.ndarray) -> None:
    """Refuse a surface that does not lie over its own middle plane."""
    places = flat[told]
    edges = _edges(places)
    apart = np.abs(places[edges[:, 0]] - places[edges[:, 1]])
    beside = np.hypot(apart[:, 0], apart[:, 1])
    steep = apart[:, 2] - np.maximum(_STEEPEST_SURFACE * beside, TIP * 1e-3)
    if steep.max() <= 0.0:
        return
    worst = int(steep.argmax())
    first, second = np.flatnonzero(told)[edges[worst]]
    one, other = (
        f"({sites.x[at]:.4g}, {sites.y[at]:.4g}, {sites.z[at]:.4g}) m" for at in (first, second)
    )
    raise ParameterError(
        f"the surface of the sites folds over: those at {one} and {other} are "
        f"{1e3 * apart[worst, 2]:.3g} mm apart across the surface's middle plane and "
        f"{1e3 * beside[worst]:.3g} mm along it; map each side by itself"
    )


def _laid_flat(points: FloatArray) -> FloatArray:
    """Return places on a plane, shape (n, 2), at the distances along the surface of points."""
    squared = squareform(_ways(points)) ** 2
    inner = squared - squared.mean(axis=0)
    inner = -0.5 * (inner - inner.mean(axis=1, keepdims=True))
    sizes, directions = np.linalg.eigh(inner)
    laid = directions[:, -2:] * np.sqrt(np.maximum(sizes[-2:], 0.0))
    turn, _ = orthogonal_procrustes(laid, points[:, :2] - points[:, :2].mean(axis=0))
    return np.asarray(laid @ turn + points[:, :2].mean(axis=0))


def _ways(points: FloatArray) -> FloatArray:
    """Return the length of the way along the surface between each pair, in the order of ``pdist``.

    Each runs straight over the middle plane: on a cap that ends 45 degrees from its pole it is
    longer than the shortest by 2 % at most.
    """
    first, second = np.triu_indices(len(points), 1)
    share = np.linspace(0.0, 1.0, _PATH_PIECES + 1)
    over = (
        points[first, None, :2] * (1.0 - share[:, None])
        + points[second, None, :2] * (share[:, None])
    )
    height = height_over(points, over[..., 0].ravel(), over[..., 1].ravel()).reshape(over.shape[:2])
    rise = np.diff(height, axis=1)
    piece = pdist(points[:, :2])[:, None] / _PATH_PIECES
    return np.asarray(np.hypot(piece, rise).sum(axis=1))


def _move_sites(sites: Sites, flat: FloatArray) -> Sites:
    return Sites(flat[:, 0], flat[:, 1], np.zeros(len(flat)), sites.t, sites.k, sites.k_sd)


@dataclass(frozen=True, eq=False)
class _Over(Alike):
    """The lift of a map of points on and off a plane; without one x and y are space's."""

    flat: FloatArray
    plane: _Plane | None = None

    def __call__(self, x: FloatArray, y: FloatArray) -> FloatArray:
        places = np.column_stack([x, y, height_over(self.flat, x, y)])
        return places if self.plane is None else self.plane.lift_points(places)


@dataclass(frozen=True, eq=False)
class _Unrolled(Alike):
    """The lift of a surface that was laid flat: from its points there to those on its plane."""

    laid: FloatArray
    surface: FloatArray
    plane: _Plane

    def __call__(self, x: FloatArray, y: FloatArray) -> FloatArray:
        from scipy.interpolate import RBFInterpolator

        return self.plane.lift_points(
            RBFInterpolator(self.laid, self.surface)(np.column_stack([x, y]))
        )
