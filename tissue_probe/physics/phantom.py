"""A simulated phantom: the stiffness and damping that the tip feels at each place.

Contents: the tissue as a function of place.

This is an *effective-stiffness* phantom, not a finite-element one. Each nodule adds a smooth bump
to the background's stiffness, weaker and broader the deeper it lies:

    k(x, y) = k_background * (1 + sum_i e_i exp(-r_i^2 / (R_i^2 + d_i^2)))
    e_i     = (stiffness_ratio_i - 1) / (1 + (d_i / D)^2)

where r is the distance from the nodule's centre, R its radius, d the depth of its top, and D =
``DEPTH_OF_FEELING`` how deep a tip of 3 mm radius feels. The formula has the trend of an
indenter over a hard inclusion, and no more. Damping follows stiffness: all of the phantom has one
time constant beta / k.
"""

from __future__ import annotations

import reprlib
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel, ConfigDict, ValidationError

from tissue_probe import bounded_yaml
from tissue_probe.physics.felt_table import FeltTable
from tissue_probe.settings import rule, setting
from tissue_probe.signals import FloatArray

DEPTH_OF_FEELING = 0.008  # m; stress under a flat punch has faded at two to three radii


class Nodule(BaseModel):
    """A stiff inclusion."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    x: float = setting(..., "m", "x of the centre in the stage's frame", ge=-1.0, le=1.0)
    y: float = setting(..., "m", "y of the centre in the stage's frame", ge=-1.0, le=1.0)
    depth: float = setting(..., "m", "from the tissue's surface to the top", ge=0.0, le=0.1)
    radius: float = setting(..., "m", "radius", ge=1e-4, le=0.1)
    stiffness_ratio: float = setting(
        ...,
        "",
        "stiffness felt over the centre if the nodule lay at the surface, over the background's",
        ge=1.0,
        le=100.0,
    )

    def excess(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Return the nodule's added stiffness at (x, y) [m], over the background's [-]."""
        distance_squared = (np.asarray(x) - self.x) ** 2 + (np.asarray(y) - self.y) ** 2
        centre = (self.stiffness_ratio - 1.0) / (1.0 + (self.depth / DEPTH_OF_FEELING) ** 2)
        return centre * np.exp(-distance_squared / (self.radius**2 + self.depth**2))


class Phantom(BaseModel):
    """Tissue with nodules in it, or with none."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    background_stiffness: float = setting(
        ..., "N/m", "stiffness k far from every nodule", ge=1.0, le=1e5
    )
    background_damping: float = setting(
        ..., "N s/m", "damping beta far from every nodule", ge=0.0, le=1e3
    )
    nodules: tuple[Nodule, ...] = ()

    @staticmethod
    def load(path: Path) -> Phantom:
        """Read a phantom from a YAML file.

        Raises
        ------
        OSError
            If the file cannot be read.
        ValueError
            If it is no phantom; says file, field and, for a number, range and unit.
        """
        try:
            return Phantom.model_validate(bounded_yaml.read(path))
        except ValidationError as error:
            raise ValueError(f"{path}: {_first_complaint(error)}") from None
        except bounded_yaml.YamlError as error:
            raise ValueError(f"{path} {error}") from None

    def stiffness(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Return the stiffness k felt at (x, y) [m], in N/m and of their common shape."""
        return self.background_stiffness * self._relative(x, y)

    def damping(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Return the damping beta felt at (x, y) [m], in N s/m and of their common shape."""
        return self.background_damping * self._relative(x, y)

    def height(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Return the surface's z at (x, y) [m], in m and of their common shape: it is flat."""
        return np.zeros(np.broadcast_shapes(np.shape(x), np.shape(y)))

    @property
    def stiffest(self) -> float:
        """No less than the largest stiffness anywhere, over the background's [-]."""
        return 1.0 + sum(float(nodule.excess(nodule.x, nodule.y)) for nodule in self.nodules)

    def _relative(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        shape = np.broadcast_shapes(np.shape(x), np.shape(y))
        return np.ones(shape) + sum(nodule.excess(x, y) for nodule in self.nodules)


def load_phantom(path: Path) -> Phantom | FeltTable:
    """Read a phantom: of nodules from YAML, of felt stiffness from a table (.csv).

    Raises
    ------
    OSError, ValueError
        As ``Phantom.load`` and ``FeltTable.load``.
    """
    return FeltTable.load(path) if path.suffix.lower() == ".csv" else Phantom.load(path)


def _first_complaint(error: ValidationError) -> str:
    """Say in one clause which field is wrong, and the allowed values."""
    complaint = error.errors()[0]
    place = complaint["loc"]
    name = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in place)
    name = name.removeprefix(".") or "the file"
    fields = (Nodule if len(place) > 1 else Phantom).model_fields
    if complaint["type"] == "extra_forbidden":
        return f"there is no {name}; there are {', '.join(fields)}"
    found = "missing" if complaint["type"] == "missing" else reprlib.repr(complaint["input"])
    if place == ("nodules",):
        wanted = "a list of nodules"
    elif place and place[-1] in fields:
        wanted = rule(fields[place[-1]])
    else:
        wanted = f"the fields {', '.join(fields)}"
    return f"{name} is {found}: give {wanted}"
