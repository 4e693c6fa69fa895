"""Where the tip is in each measurement, and how fast, as far as a model and a shape say.

Contents: from a fit to the signals that a free function may be one of.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.rigs.constants import CONTACT_POSITION
from tissue_probe.quantities import FORCE
from tissue_probe.signals import FloatArray


@dataclass(frozen=True, eq=False)
class Path:
    """Signals of one measurement, each of shape (n,).

    Attributes
    ----------
    measurement : Measurement
        The samples that they belong to.
    indentation, velocity : array
        Of the tip [m, m/s], positive into the tissue.
    force : array
        In the force channel [N]: as the model predicts it, or as it drives.
    time : array
        After the first sample of the run [s].
    """

    measurement: Measurement
    indentation: FloatArray
    velocity: FloatArray
    force: FloatArray
    time: FloatArray


def paths(fit: Fit, added: Sequence[FloatArray] | None = None) -> list[Path]:
    """Return the path of each measurement of a fit.

    Parameters
    ----------
    fit : Fit
        The model.
    added : sequence of array, optional
        The shape's part of the output of each measurement, to be added to the prediction.
    """
    named = fit.named()
    touch = named.get(CONTACT_POSITION.name, 0.0)
    yielding = 1.0 / named.get("load_cell_stiffness", np.inf)
    found = []
    for index, measurement in enumerate(fit.measurements):
        more = np.zeros(measurement.force.size) if added is None else added[index]
        of_force = fit.output is FORCE
        moved = -yielding * more if of_force else more
        depth = fit.tip[index] + moved - touch
        times = measurement.times
        force = fit.predicted[index] + more if of_force else measurement.force
        speed = CubicSpline(times, depth)(times, 1)
        found.append(Path(measurement, depth, speed, force, measurement.begins + times))
    return found
