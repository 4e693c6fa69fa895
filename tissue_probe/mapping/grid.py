"""The grid of sites that a scan palpates.

Contents: where the sites are, how they are numbered, which cell a position falls into.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tissue_probe.signals import FloatArray

MAXIMUM_SITES = 10_000  # three hours at one second a site


@dataclass(frozen=True, slots=True)
class Grid:
    """Sites on a square grid, palpated row by row in serpentine order.

    The cell in row r and column c lies at ``origin + (c * spacing, r * spacing, 0)`` and has index
    r * columns + c. Sites are numbered along the path of the probe: row 0 by rising column, row 1
    by falling column, and so on.

    Parameters
    ----------
    origin : tuple of float
        Position (x, y, z) of the cell in row 0, column 0, on the tissue's surface [m].
    spacing : float
        Distance between neighbouring cells [m], positive.
    rows, columns : int
        Number of cells along y and along x, each at least 1, together at most ``MAXIMUM_SITES``.

    Raises
    ------
    ValueError
        If a parameter is out of its range or not finite.
    """

    origin: tuple[float, float, float]
    spacing: float
    rows: int
    columns: int

    def __post_init__(self) -> None:
        origin = tuple(float(value) for value in self.origin)
        if len(origin) != 3 or not all(map(math.isfinite, origin)):
            raise ValueError(f"origin is {self.origin}; it must be three finite lengths in m")
        object.__setattr__(self, "origin", origin)
        if not 0.0 < self.spacing < math.inf:
            raise ValueError(f"spacing is {self.spacing} m; it must be positive and finite")
        for name in ("rows", "columns"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} is {getattr(self, name)}; it must be at least 1")
        if len(self) > MAXIMUM_SITES:
            raise ValueError(
                f"{self.rows} rows of {self.columns} columns are {len(self)} sites; "
                f"a grid has at most {MAXIMUM_SITES}"
            )

    @staticmethod
    def through(positions: Sequence[tuple[float, float, float]]) -> Grid:
        """Return the smallest grid that has a cell at each position, its spacing the coarsest.

        A single position gets a spacing of 10 mm, since a grid of one cell tells none.

        Raises
        ------
        ValueError
            If there is no position, or the positions lie on no square grid.
        """
        if not positions:
            raise ValueError("no positions: there is no grid through nothing")
        nanometres = np.round(np.array(positions, dtype=float), 9)
        axes = np.unique(nanometres[:, 0]), np.unique(nanometres[:, 1])
        steps = np.concatenate([np.diff(axis) for axis in axes])
        spacing = float(steps.min()) if steps.size else 0.01
        columns, rows = (round((axis[-1] - axis[0]) / spacing) + 1 for axis in axes)
        grid = Grid((axes[0][0], axes[1][0], positions[0][2]), spacing, rows, columns)
        off = max(np.abs(steps / spacing - np.round(steps / spacing)), default=0.0)
        if off > 0.01:
            raise ValueError(
                f"the sites lie on no square grid: their distances are no multiples of "
                f"{1e3 * spacing:.3f} mm"
            )
        return grid

    def __len__(self) -> int:
        """Return the number of sites."""
        return self.rows * self.columns

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns, the shape of every array over the grid."""
        return self.rows, self.columns

    @property
    def x(self) -> FloatArray:
        """Position x of each column [m], shape (columns,)."""
        return self.origin[0] + self.spacing * np.arange(self.columns, dtype=float)

    @property
    def y(self) -> FloatArray:
        """Position y of each row [m], shape (rows,)."""
        return self.origin[1] + self.spacing * np.arange(self.rows, dtype=float)

    def cell(self, site: int) -> tuple[int, int]:
        """Return (row, column) of a site; IndexError if the grid has no such site."""
        if not 0 <= site < len(self):
            raise IndexError(f"site {site} is not one of the grid's {len(self)} sites")
        row, along = divmod(site, self.columns)
        return row, self._turn_index(row, along)

    def site(self, row: int, column: int) -> int:
        """Return the number of the site in a cell; IndexError if the grid has no such cell."""
        if not (0 <= row < self.rows and 0 <= column < self.columns):
            raise IndexError(f"the grid has no cell in row {row}, column {column}")
        return row * self.columns + self._turn_index(row, column)

    def _turn_index(self, row: int, column: int) -> int:
        return self.columns - 1 - column if row % 2 else column

    def position(self, site: int) -> tuple[float, float, float]:
        """Return (x, y, z) of a site [m]; IndexError if the grid has no such site."""
        row, column = self.cell(site)
        x, y, z = self.origin
        return x + column * self.spacing, y + row * self.spacing, z

    def nearest(self, position: Sequence[float]) -> tuple[int, int]:
        """Return (row, column) of the cell nearest to a position, whatever its height.

        Parameters
        ----------
        position : sequence of float
            x and y [m]; what follows is ignored.

        Raises
        ------
        ValueError
            If the position is not finite, or no cell lies within half a spacing in x and in y.
        """
        x, y = position[0], position[1]
        column = (x - self.origin[0]) / self.spacing
        row = (y - self.origin[1]) / self.spacing
        # The tolerance lets a position on the very edge survive rounding.
        edge = 0.5 + 1e-9
        if not (
            -edge <= row <= self.rows - 1 + edge and -edge <= column <= self.columns - 1 + edge
        ):
            raise ValueError(
                f"position ({x}, {y}) m lies more than half a spacing ({self.spacing / 2} m) "
                "outside the grid"
            )
        return (
            min(max(math.floor(row + 0.5), 0), self.rows - 1),
            min(max(math.floor(column + 0.5), 0), self.columns - 1),
        )
