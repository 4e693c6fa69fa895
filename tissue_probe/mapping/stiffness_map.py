"""The map: what is known of the tissue in each cell of a grid.

Contents: the arrays of one map, checked.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from tissue_probe.mapping.grid import Grid
from tissue_probe.signals import FloatArray, IntArray


@dataclass(frozen=True)
class StiffnessMapData:
    """Stiffness and damping over a grid; every array has shape (rows, columns).

    Cells without a value are NaN in the first five; ``verdict`` says why.

    Attributes
    ----------
    grid : Grid
        Where the cells are.
    stamp : int
        Time of the newest sample that the map tells of [ns since the epoch]; 0 if there is none.
    stiffness, damping : array
        k [N/m] and beta [N s/m].
    covariance_trace : array
        Trace of the covariance of the estimators' state, its units mixed as the paper mixes them.
    stiffness_stddev, damping_stddev : array
        Standard deviation of k [N/m] and of beta [N s/m], with the spread between the estimators.
    verdict : array of uint8
        The ``CellVerdict`` of each cell.
    dwell_begin : array of int64
        When the dwell began that the cell tells of [ns since the epoch]; 0 where none is known. An
        earlier scan's value stays where this one found none: its time tells so.

    Raises
    ------
    ValueError
        If an array has another shape than the grid.
    """

    grid: Grid
    stamp: int
    stiffness: FloatArray
    damping: FloatArray
    covariance_trace: FloatArray
    stiffness_stddev: FloatArray
    damping_stddev: FloatArray
    verdict: NDArray[np.uint8]
    dwell_begin: IntArray

    def __post_init__(self) -> None:
        for entry in fields(self)[2:]:
            shape = np.shape(getattr(self, entry.name))
            if shape != self.grid.shape:
                raise ValueError(f"{entry.name} has shape {shape}; the grid has {self.grid.shape}")

    @property
    def measured(self) -> NDArray[np.bool_]:
        """Whether each cell has a value, shape (rows, columns)."""
        return np.isfinite(self.stiffness)
