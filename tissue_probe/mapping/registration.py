"""A map in another frame: the rigid motion between point pairs, and how wrong it may be.

Contents: the motion and its errors.

The rotation is that of least squares (Kabsch 1976; Umeyama 1991, without scale). Errors after
J. M. Fitzpatrick, J. B. West and C. R. Maurer, "Predicting error in rigid-body point-based
registration", IEEE Trans. Med. Imaging 17 (1998) 694, for N pairs in K dimensions whose points are
wrong by FLE, alike in all directions:

    <FRE^2>    = (1 - (K + 1) / (2 N)) FLE^2                            (1 - 2 / N in space)
    <TRE(r)^2> = FLE^2 (1 / N + 1/K sum_i sum_{j != i} r_i^2 / (L_i^2 + L_j^2))

where r is a place, from the middle of the pairs and along their principal axes, and L_i are the
singular values of the pairs' offsets from their middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.errors import ParameterError
from tissue_probe.signals import FloatArray

LEAST_PAIRS = 3
#: Points whose extent across is less than this part of that along are on a line: errors of the
#: places turn the frame about it a hundred times as far.
ON_A_LINE = 0.01
#: A residual of this part of the pairs' own extent is no error of places: a rigid motion does not
#: make one set of points of the other. At it the frame would be turned by some six degrees.
NOT_RIGID = 0.1


@dataclass(frozen=True)
class Registration:
    """A rigid motion from the map's frame to another one.

    Attributes
    ----------
    rotation : array, shape (3, 3)
        And then
    translation : array, shape (3,)
        take a place p [m] of the map to rotation @ p + translation.
    residuals : array, shape (pairs,)
        How far each pair is apart once moved [m].
    places : array, shape (pairs, K)
        The points in the map's frame [m], in space or (K = 2) in the plane.
    """

    rotation: FloatArray
    translation: FloatArray
    residuals: FloatArray
    places: FloatArray

    @property
    def fiducial_error(self) -> float:
        """Root mean square of the residuals, FRE [m]."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def localisation_error(self) -> float:
        """By how much a point of a pair is wrong, FLE [m], as the residuals tell."""
        count, dimensions = self.places.shape
        error: float = self.fiducial_error / np.sqrt(1.0 - (dimensions + 1) / (2 * count))
        return error

    def move_places(self, places: FloatArray) -> FloatArray:
        """Return places of the map, shape (..., 3) [m], in the other frame."""
        return places @ self.rotation.T + self.translation

    def target_error(self, places: FloatArray) -> FloatArray:
        """Return by how much places of the map, shape (n, 3) [m], will be wrong there, TRE [m]."""
        count, dimensions = self.places.shape
        middle = self.places.mean(axis=0)
        _, extent, axes = np.linalg.svd(self.places - middle, full_matrices=False)
        off = (places[:, :dimensions] - middle) @ axes.T
        pairwise = extent[:, None] ** 2 + extent[None, :] ** 2
        np.fill_diagonal(pairwise, np.inf)
        turned = (off**2 @ (1.0 / pairwise)).sum(axis=1) / dimensions
        error: FloatArray = self.localisation_error * np.sqrt(1.0 / count + turned)
        return error


def register(places: FloatArray, others: FloatArray) -> Registration:
    """Return the rigid motion that brings places nearest to others.

    Parameters
    ----------
    places, others : array, shape (n, 2) or (n, 3)
        The same points in the map's frame and in the other one [m]. In the plane z is kept.

    Raises
    ------
    ParameterError
        If there are fewer than three pairs, they lie on a line, or no rigid motion fits them.
    """
    # Here, since it takes long to import, and nodes import this package.
    from scipy.spatial.transform import Rotation

    count, dimensions = places.shape
    if count < LEAST_PAIRS:
        raise ParameterError(f"{count} pairs tell no rotation: give {LEAST_PAIRS} or more")
    for points, name in ((places, "the map's"), (others, "the other")):
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        if bad.size:
            raise ParameterError(f"pair {bad[0] + 1} has no place in {name} frame: give numbers")
    middle, other_middle = places.mean(axis=0), others.mean(axis=0)
    off, other_off = _in_space(places - middle), _in_space(others - other_middle)
    for offsets, name in ((off, "the map's"), (other_off, "the other")):
        along, across, _ = np.linalg.svd(offsets, compute_uv=False)
        if across <= ON_A_LINE * along:
            raise ParameterError(
                f"the pairs lie on a line in {name} frame, about which the map could turn: give "
                "one beside it"
            )
    rotation = Rotation.align_vectors(other_off, off)[0].as_matrix()
    residuals = np.linalg.norm(other_off - off @ rotation.T, axis=1)
    extent = float(np.sqrt((off**2).sum(axis=1).mean()))
    error = float(np.sqrt((residuals**2).mean()))
    if error > NOT_RIGID * extent:
        raise ParameterError(
            f"no rigid motion fits the pairs: they stay {_mm(error)} mm (rms) apart, pair "
            f"{int(residuals.argmax()) + 1} most, and lie {_mm(extent)} mm about their middle: "
            "look at their order, units (m) and axes"
        )
    if dimensions == 2 and rotation[2, 2] < 0.0:
        raise ParameterError(
            "the pairs are mirror images of each other: look at the order of X and Y, or give z "
            "and Z, too"
        )
    translation = _in_space(other_middle[None])[0] - rotation @ _in_space(middle[None])[0]
    return Registration(rotation, translation, residuals, places)


def _in_space(points: FloatArray) -> FloatArray:
    return np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])


def _mm(length: float) -> str:
    return f"{1e3 * length:.3g}"
