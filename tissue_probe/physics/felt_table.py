"""A phantom from a table: the stiffness that a tip feels, computed or measured elsewhere.

Contents: the table, its file, and the tissue between its points.

Between the points stiffness, damping and height are linear, over the triangles of a Delaunay
triangulation: a grid and scattered points are read alike. Beyond the outermost points it is the
value of the nearest point, since a table tells nothing there.
"""

from __future__ import annotations

import csv
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from tissue_probe.signals import FARTHEST_PLACE, FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

    from tissue_probe.physics.phantom import Nodule

#: Columns that a table has, and those that it may have.
FELT_NEEDED, FELT_OPTIONAL = ("x", "y", "k"), ("z", "beta")
#: beta / k where the table has no damping [s]: that of the stock phantom, 5 N s/m at 450 N/m.
TIME_CONSTANT = 5.0 / 450.0
#: A recording holds its phantom, in a document no longer than ``bounded_yaml.SIZE``.
MOST_POINTS = 2500
#: The softest and stiffest tissue [N/m], and the most damping [N s/m], as of a phantom of nodules.
SOFTEST, STIFFEST_FELT, MOST_DAMPING = 1.0, 1e5, 1e3
#: Places to the nanometre and values to seven digits: as the recording has them, so the probe.
_DECIMALS, _DIGITS = 9, 7

Column = tuple[float, ...]


class FeltTable(BaseModel):
    """Tissue as a table of the values felt at points of its surface, in m, N/m and N s/m.

    Attributes
    ----------
    x, y : tuple of float
        The points in the stage's frame [m], three or more and not on one line.
    k : tuple of float
        Stiffness felt there [N/m].
    z : tuple of float
        Height of the surface there [m]; empty: 0 everywhere.
    beta : tuple of float
        Damping felt there [N s/m]; empty: it follows the stiffness with one time constant.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    x: Column
    y: Column
    k: Column
    z: Column = ()
    beta: Column = ()

    @staticmethod
    def load(path: Path) -> FeltTable:
        """Read a table in CSV with the columns x, y [m], k [N/m], perhaps z [m], beta [N s/m].

        Raises
        ------
        OSError
            If the file cannot be read.
        ValueError
            If it is no such table; says file, line or column.
        """
        try:
            return FeltTable.of(**_columns(path))
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None

    @staticmethod
    def of(
        x: ArrayLike, y: ArrayLike, k: ArrayLike, z: ArrayLike = (), beta: ArrayLike = ()
    ) -> FeltTable:
        """Return the table of these points, of one length each; ValueError as ``load``."""
        columns = {"x": x, "y": y, "k": k, "z": z, "beta": beta}
        try:
            return FeltTable(**{name: _kept(name, each) for name, each in columns.items()})
        except ValidationError as error:  # it names the class and pydantic's web page
            raise ValueError(error.errors()[0]["msg"].removeprefix("Value error, ")) from None

    @model_validator(mode="after")
    def _is_sound(self) -> FeltTable:
        count = len(self.x)
        for name in (*FELT_NEEDED[1:], *(each for each in FELT_OPTIONAL if getattr(self, each))):
            if len(getattr(self, name)) != count:
                raise ValueError(f"{name} has {len(getattr(self, name))} values, x {count}")
        if count > MOST_POINTS:
            raise ValueError(
                f"{count} points; a phantom takes at most {MOST_POINTS}: thin the table, a tip "
                "feels nothing finer than its radius"
            )
        for name, low, high, unit in (
            ("x", -FARTHEST_PLACE, FARTHEST_PLACE, "m"),
            ("y", -FARTHEST_PLACE, FARTHEST_PLACE, "m"),
            ("z", -FARTHEST_PLACE, FARTHEST_PLACE, "m"),
            ("k", SOFTEST, STIFFEST_FELT, "N/m"),
            ("beta", 0.0, MOST_DAMPING, "N s/m"),
        ):
            values = np.array(getattr(self, name))
            if bad := np.flatnonzero(~((values >= low) & (values <= high))).tolist():
                told = f"{name} of point {bad[0] + 1} is {values[bad[0]]:g}"
                raise ValueError(f"{told}: give a number from {low:g} to {high:g} [{unit}]")
        places = np.column_stack([self.x, self.y])
        _, first, times = np.unique(places, axis=0, return_index=True, return_counts=True)
        if (times > 1).any():
            twice = places[first[times > 1][0]]
            raise ValueError(f"the point ({twice[0]:g}, {twice[1]:g}) m stands there twice")
        if count < 3 or _is_line(places):
            raise ValueError("the points lie on one line: give three or more that do not")
        return self

    @property
    def nodules(self) -> tuple[Nodule, ...]:
        """None: a table does not tell why it is stiff."""
        return ()

    @cached_property
    def background_stiffness(self) -> float:
        """The median over the points [N/m]."""
        return float(np.median(self.k))

    @cached_property
    def background_damping(self) -> float:
        """The median over the points [N s/m]."""
        return float(np.median(self._values[:, 1]))

    @cached_property
    def stiffest(self) -> float:
        """The largest stiffness or damping anywhere, over the background's [-]."""
        background = self.background_stiffness, self.background_damping or 1.0
        return float((self._values[:, :2] / background).max())

    def stiffness(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Return the stiffness k felt at (x, y) [m], in N/m and of their common shape."""
        return self._at(x, y)[..., 0]

    def damping(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Return the damping beta felt at (x, y) [m], in N s/m and of their common shape."""
        return self._at(x, y)[..., 1]

    def height(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        """Return the surface's z at (x, y) [m], in m and of their common shape."""
        return self._at(x, y)[..., 2]

    @cached_property
    def _values(self) -> FloatArray:
        """k, beta and z of each point, shape (n, 3)."""
        k = np.array(self.k)
        beta = np.array(self.beta) if self.beta else TIME_CONSTANT * k
        return np.column_stack([k, beta, np.array(self.z) if self.z else np.zeros_like(k)])

    @cached_property
    def _interpolators(self) -> tuple[LinearNDInterpolator, NearestNDInterpolator]:
        # Here, since it takes a second to import, and the phantom of nodules needs none of it.
        from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

        places = np.column_stack([self.x, self.y])
        return (
            LinearNDInterpolator(places, self._values),
            NearestNDInterpolator(places, self._values),
        )

    def _at(self, x: ArrayLike, y: ArrayLike) -> FloatArray:
        between, nearest = (each(np.asarray(x), np.asarray(y)) for each in self._interpolators)
        found: FloatArray = np.where(np.isfinite(between), between, nearest)
        return found


def _is_line(places: FloatArray) -> bool:
    """Whether points are on one line, but for rounding."""
    long, across = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    return bool(across < 1e-6 * long)


def _kept(name: str, values: ArrayLike) -> Column:
    values = np.asarray(values, dtype=float)
    if name in "xyz":
        return tuple(np.round(values, _DECIMALS).tolist())
    return tuple(float(f"{value:.{_DIGITS}g}") for value in values.tolist())


def _columns(path: Path) -> dict[str, list[float]]:
    """Return the columns of a table that a phantom has; ValueError where it is none."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        try:
            rows = csv.DictReader(file, skipinitialspace=True)
            names = [name.strip() for name in rows.fieldnames or ()]
            if missing := [name for name in FELT_NEEDED if name not in names]:
                raise ValueError(
                    f"there is no column {', '.join(missing)}; a table of a phantom has the "
                    "columns x, y [m], k [N/m], and perhaps z [m] and beta [N s/m], after commas"
                )
            rows.fieldnames = names
            wanted = [name for name in (*FELT_NEEDED, *FELT_OPTIONAL) if name in names]
            found: dict[str, list[float]] = {name: [] for name in wanted}
            for row in rows:
                for name in wanted:
                    found[name].append(_number(row[name], name, rows.line_num))
        except (UnicodeDecodeError, csv.Error):
            raise ValueError("is no text table") from None
    return found


def _number(text: str | None, name: str, line: int) -> float:
    try:
        return float(text or "")
    except ValueError:
        raise ValueError(f"{name} in line {line} is {text or ''!r}: give a number") from None
