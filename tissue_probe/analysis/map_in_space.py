"""A map's results in space: in the sites' own frame, or in that of a robot, a camera, an image.

Contents: the results moved, with the error of a registration.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tissue_probe.likeness import Alike
from tissue_probe.mapping.height import height_at
from tissue_probe.mapping.lift import Lift, covariance_in_space
from tissue_probe.mapping.posterior.results import Inclusion, PosteriorMap, Raster
from tissue_probe.mapping.registration import Registration, register
from tissue_probe.mapping.sites import Sites
from tissue_probe.signals import FloatArray


@dataclass(frozen=True, eq=False)
class PlacedMap(Alike):
    """Where the results of a map lie in space.

    Attributes
    ----------
    lift : callable
        Gives the place in space of a place of the map, in the sites' frame.
    map : PosteriorMap
        In its own frame, which is flat.
    """

    lift: Lift
    map: PosteriorMap

    def places(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return places of the surface [m], shape (n,) each, in space, shape (n, 3)."""
        return self.lift(x, y)

    def to_dict(self) -> dict[str, Any]:
        """Return inclusions, surface, sizes that could hide, places to palpate again, in space."""
        found = self.map
        return {
            "inclusions": [self._inclusion(one) for one in found.inclusions],
            "surface": self._raster(found.surface),
            "could_hide": self._raster(found.could_hide),
            "again": [self._place(one.x, one.y) for one in found.again],
        }

    def _place(self, x: float, y: float) -> list[float]:
        """Return one place in space."""
        place: list[float] = self.places(np.array([x]), np.array([y]))[0].tolist()
        return place

    def _inclusion(self, one: Inclusion) -> dict[str, Any]:
        x, y, z = self._place(one.x, one.y)
        lines = ("boundary_50", "boundary_90", "boundary_95")
        return {
            "x": x,
            "y": y,
            "z": z,
            "covariance": covariance_in_space(self.places, one.x, one.y, one.covariance).tolist(),
            **{name: self.places(*getattr(one, name).T).tolist() for name in lines},
        }

    def _raster(self, raster: Raster) -> dict[str, Any]:
        x, y = np.meshgrid(raster.x, raster.y)
        places = self.places(x.ravel(), y.ravel()).reshape(*x.shape, 3)
        return {name: places[..., i].tolist() for i, name in enumerate("xyz")}


@dataclass(frozen=True, eq=False)
class RegisteredMap(PlacedMap):
    """Where the results of a map lie in another frame.

    Attributes
    ----------
    registration : Registration
        The motion from the sites' frame to the other.
    """

    registration: Registration

    def places(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return places of the surface [m], shape (n,) each, in the other frame, shape (n, 3)."""
        return self.registration.move_places(self.lift(x, y))

    def errors(self) -> FloatArray:
        """Return by how much the middle of each inclusion is wrong by the registration, TRE [m]."""
        found = self.map.inclusions
        x, y = (np.array([getattr(one, name) for one in found]) for name in "xy")
        return self.registration.target_error(self.lift(x, y)) if found else np.zeros(0)

    @property
    def text(self) -> str:
        """How well the pairs fit, and the error of an inclusion's place."""
        registration = self.registration
        told = (
            f"registered by {registration.residuals.size} pairs, which stay "
            f"{1e3 * registration.fiducial_error:.2g} mm apart (rms)"
        )
        errors = self.errors()
        if errors.size:
            told += f"; middles of inclusions are off by {1e3 * errors.max():.2g} mm at most (rms)"
        return told

    def to_dict(self) -> dict[str, Any]:
        """Return motion, errors, inclusions, surface, sizes that could hide, in the other frame."""
        registration, placed = self.registration, super().to_dict()
        for one, error in zip(placed["inclusions"], self.errors().tolist(), strict=True):
            one["target_error"] = error
        return {
            "rotation": registration.rotation.tolist(),
            "translation": registration.translation.tolist(),
            "residuals": registration.residuals.tolist(),
            "fiducial_error": registration.fiducial_error,
            **placed,
        }


def registration_of(pairs: dict[str, FloatArray], sites: Sites) -> Registration:
    """Return the motion that point pairs tell; see ``recording.point_pairs`` for their columns.

    Without Z both are taken in the plane; with Z alone the pairs lie on the surface of the sites.

    Raises
    ------
    ParameterError
        If they tell none.
    """
    x, y, other_x, other_y = (pairs[name] for name in ("x", "y", "X", "Y"))
    if "Z" not in pairs:
        return register(np.column_stack([x, y]), np.column_stack([other_x, other_y]))
    z = pairs.get("z")
    if z is None:
        z = height_at(sites, x, y)
    return register(np.column_stack([x, y, z]), np.column_stack([other_x, other_y, pairs["Z"]]))
