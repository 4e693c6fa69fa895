"""A simulated phantom: the stiffness and damping that the tip feels at each place.

What belongs here: the tissue as a function of place. What does not: how the probe moves in it.

This is an *effective-stiffness* phantom, not a finite-element one. Each nodule adds a smooth bump
to what the tip feels of the background, weaker and broader the deeper it lies:

    k(x, y) = k_background * (1 + sum_i e_i exp(-r_i^2 / (R_i^2 + d_i^2)))
    e_i     = (stiffness_ratio_i - 1) / (1 + (d_i / D)^2)

where r is the distance from the nodule's centre, R its radius, d the depth of its top, and D =
``DEPTH_OF_FEELING`` how deep a tip of 3 mm radius feels. The formula has the trend of an
indenter over a hard inclusion, and no more. Damping follows stiffness: all of the phantom has one
time constant beta / k.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import yaml
from numpy.typing import ArrayLike
from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError

from tissue_probe.signals import FloatArray

DEPTH_OF_FEELING = 0.008  # m; stress under a flat punch has faded at two to three radii


def _number(low: float, high: float, unit: str) -> BeforeValidator:
    """Accept a number from low to high; an error names the value, the range and the unit."""

    def check(value: Any) -> float:
        try:
            # float() also reads 1e-3, which YAML takes for text.
            number = float("nan") if isinstance(value, bool) else float(value)
        except (TypeError, ValueError):
            number = float("nan")
        if not low <= number <= high:
            raise ValueError(f"is {value!r}; it must be a number from {low} to {high} {unit}")
        return number

    return BeforeValidator(check)


class _Checked(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Nodule(_Checked):
    """A stiff inclusion.

    Attributes
    ----------
    x, y : float
        Centre in the stage's frame [m].
    depth : float
        From the tissue's surface to the nodule's top [m].
    radius : float
        [m]
    stiffness_ratio : float
        Stiffness felt over its centre if it lay at the surface, over the background's [-].
    """

    x: Annotated[float, _number(-1.0, 1.0, "m")]
    y: Annotated[float, _number(-1.0, 1.0, "m")]
    depth: Annotated[float, _number(0.0, 0.1, "m")]
    radius: Annotated[float, _number(1e-4, 0.1, "m")]
    stiffness_ratio: Annotated[float, _number(1.0, 100.0, "times the background's stiffness")]

    def excess(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Return what the nodule adds to the stiffness at (x, y) [m], over the background's [-]."""
        distance_squared = (np.asarray(x) - self.x) ** 2 + (np.asarray(y) - self.y) ** 2
        centre = (self.stiffness_ratio - 1.0) / (1.0 + (self.depth / DEPTH_OF_FEELING) ** 2)
        return centre * np.exp(-distance_squared / (self.radius**2 + self.depth**2))


class Phantom(_Checked):
    """Tissue with nodules in it.

    Attributes
    ----------
    background_stiffness : float
        [N/m]
    background_damping : float
        [N s/m]
    nodules : tuple of Nodule
        May be empty.
    """

    background_stiffness: Annotated[float, _number(1.0, 1e5, "N/m")]
    background_damping: Annotated[float, _number(0.0, 1e3, "N s/m")]
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
            return Phantom.model_validate(yaml.safe_load(path.read_text(encoding="utf-8")))
        except ValidationError as error:
            raise ValueError(f"{path}: {_first_complaint(error)}") from None
        except (yaml.YAMLError, UnicodeDecodeError) as error:
            raise ValueError(f"{path} is not YAML: {' '.join(str(error).split())}") from None

    def stiffness(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Return the stiffness k felt at (x, y) [m], in N/m and of their common shape."""
        return self.background_stiffness * self._relative(x, y)

    def damping(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Return the damping beta felt at (x, y) [m], in N s/m and of their common shape."""
        return self.background_damping * self._relative(x, y)

    def _relative(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        shape = np.broadcast_shapes(np.shape(x), np.shape(y))
        return np.ones(shape) + sum(nodule.excess(x, y) for nodule in self.nodules)


def _first_complaint(error: ValidationError) -> str:
    """Say in one clause which field is wrong and why."""
    complaint = error.errors()[0]
    field = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in complaint["loc"])
    reasons: dict[str, Callable[[], str]] = {
        "missing": lambda: "is missing",
        "extra_forbidden": lambda: "is not a field of a phantom; remove it or mend its spelling",
        "value_error": lambda: str(complaint["ctx"]["error"]),
    }
    reason = reasons.get(complaint["type"], lambda: f"is wrong: {complaint['msg']}")()
    return f"{field.removeprefix('.') or 'the file'} {reason}"
