"""The highest stiffness that a robot may meet: stated, or that of a map.

Contents: from a number, a map, or the file of a map to a stiffness.
"""

from __future__ import annotations

import json
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tissue_probe import arguments as take
from tissue_probe.errors import MeasurementError
from tissue_probe.quantities import SIDE

if TYPE_CHECKING:
    from tissue_probe.signals import FloatArray

_NUMBER = take.number(above=0.0, unit="N/m")


def find_stiffest(name: str, given: Any) -> float:
    """Return a stiffness: the given one, or the highest of a map's, its 95 % interval counted.

    Parameters
    ----------
    name : str
        Of the parameter, for the sentence that refuses.
    given : float, MapResult, or path
        A stiffness [N/m], a map, or the file that the command ``map`` writes for programs.

    Returns
    -------
    float
        [N/m].

    Raises
    ------
    ParameterError
        If it is none of these.
    MeasurementError
        If the file is no map, or its map has no stiffness.
    OSError
        If the file cannot be read.
    """
    if isinstance(given, (str, Path)):
        return _of_file(take.path(name, given))
    if not isinstance(given, Real):
        from tissue_probe.analysis.mapping import MapResult

        if isinstance(given, MapResult):
            surface = given.map.surface
            return _upper_end(surface.mean, surface.sd, "the map")
    return float(_NUMBER(name, given))


def _of_file(path: Path) -> float:
    try:
        surface = json.loads(path.read_text(encoding="utf-8"))["surface"]
        # A place without a site near it has null.
        mean, sd = (np.array(surface[key], float) for key in ("mean", "sd"))
    except (ValueError, KeyError, TypeError):
        raise MeasurementError(
            f"{path} is no map: give a file that `tissue_probe map` wrote for programs"
        ) from None
    return _upper_end(mean, sd, str(path))


def _upper_end(mean: FloatArray, sd: FloatArray, named: str) -> float:
    ends = mean + SIDE * sd
    known = ends[np.isfinite(ends)]
    if mean.shape != sd.shape or known.size == 0 or known.max() <= 0.0:
        raise MeasurementError(f"{named} has no stiffness above 0: map the tissue again")
    return float(known.max())
