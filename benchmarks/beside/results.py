"""What one tool makes of one set.

Contents: its errors and the seconds that it took.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.beside.data import STARTING
from tissue_probe.signals import FloatArray


@dataclass(frozen=True)
class Result:
    """Errors of one tool on the tests of one set.

    Attributes
    ----------
    set, tool : str
        Their names.
    says : str
        The verdict and the effects, if the tool has such.
    errors : tuple of float
        Of each test, in the unit of the set.
    seconds : float
        Of the processor, to learn; NaN where nobody says.
    """

    set: str
    tool: str
    says: str
    errors: tuple[float, ...]
    seconds: float


def scored(residual: FloatArray, per_unit: float) -> float:
    """Return the root mean square of a residual without the samples that start a model."""
    if not np.all(np.isfinite(residual)):
        return float("inf")
    return float(per_unit * np.sqrt(np.mean(residual[STARTING:] ** 2)))
