"""A map's results in another frame: of a robot, a camera, an image of the organ.

What belongs here: the results moved, with the error of the registration. What does not: the motion
between the frames (``mapping.registration``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tissue_probe.mapping.height import height_at
from tissue_probe.mapping.posterior.results import Inclusion, PosteriorMap, Raster
from tissue_probe.mapping.registration import Registration, register
from tissue_probe.mapping.sites import Sites
from tissue_probe.signals import FloatArray


@dataclass(frozen=True)
class RegisteredMap:
    """Where the results of a map lie in another frame.

    Attributes
    ----------
    registration : Registration
        The motion from the map's frame to the other.
    sites : Sites
        Those of the map, which tell how high its surface lies.
    map : PosteriorMap
        In its own frame.
    """

    registration: Registration
    sites: Sites
    map: PosteriorMap

    def places(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return places of the surface [m], shape (n,) each, in the other frame, shape (n, 3)."""
        return self.registration.moved(self._surface(x, y))

    def errors(self) -> FloatArray:
        """Return by how much the middle of each inclusion is wrong by the registration, TRE [m]."""
        found = self.map.inclusions
        x, y = (np.array([getattr(one, name) for one in found]) for name in "xy")
        return self.registration.target_error(self._surface(x, y)) if found else np.zeros(0)

    @property
    def text(self) -> str:
        """How well the pairs fit, and what that means where inclusions are."""
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
        """Return motion, errors, and inclusions, surface, what could hide in the other frame."""
        registration, found = self.registration, self.map
        return {
            "rotation": registration.rotation.tolist(),
            "translation": registration.translation.tolist(),
            "residuals": registration.residuals.tolist(),
            "fiducial_error": registration.fiducial_error,
            "inclusions": [
                self._inclusion(one, float(error))
                for one, error in zip(found.inclusions, self.errors(), strict=True)
            ],
            "surface": self._raster(found.surface),
            "could_hide": self._raster(found.could_hide),
        }

    def _inclusion(self, one: Inclusion, error: float) -> dict[str, Any]:
        x, y, z = self.places(np.array([one.x]), np.array([one.y]))[0].tolist()
        across = self.registration.rotation[:, :2]
        lines = ("boundary_50", "boundary_90", "boundary_95")
        return {
            "x": x,
            "y": y,
            "z": z,
            "covariance": (across @ one.covariance @ across.T).tolist(),
            "target_error": error,
            **{name: self.places(*getattr(one, name).T).tolist() for name in lines},
        }

    def _raster(self, raster: Raster) -> dict[str, Any]:
        x, y = np.meshgrid(raster.x, raster.y)
        places = self.places(x.ravel(), y.ravel()).reshape(*x.shape, 3)
        return {name: places[..., i].tolist() for i, name in enumerate("xyz")}

    def _surface(self, x: FloatArray, y: FloatArray) -> FloatArray:
        return np.column_stack([x, y, height_at(self.sites, x, y)])


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
