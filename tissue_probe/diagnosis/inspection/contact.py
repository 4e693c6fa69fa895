"""Whether a record tells the place of touch: the tip is in the air, or just touches at its zero.

Contents: telling it from the samples.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.diagnosis.inspection.touch import FELT, FEWEST_IN_SLOPE, FLAT
from tissue_probe.diagnosis.transforms import without_line
from tissue_probe.signals import FloatArray

#: Share of the travel, at its lower end, in which the tip is in the air if it is anywhere.
LOWEST = 0.1
#: Times the noise by which the force varies there at least in contact: of the fewest samples that
#: are asked, noise alone does so in less than one of ten million.
VARIES = 2.0
#: Slack is seen where nothing is felt for so many times the way in which a tissue of the record's
#: mean slope would be felt: a law that relaxes or begins softly is felt within once or twice.
EVIDENT = 2.0


def touch_within(position: FloatArray, force: FloatArray, noise: float) -> float:
    """Return how far from the position's zero the tip may touch first [m].

    In the air the force is its zero, which may drift, and the noise. Where the force comes to zero
    at the position's zero, the tip touches there, or where the force is told from zero: slack is
    taken up before. It is infinite where the tip is in the tissue throughout.

    Parameters
    ----------
    position, force : array, shape (n,)
        [m], positive into the tissue; [N].
    noise : float
        Standard deviation of the force's noise [N].
    """
    lowest, travel = np.min(position), np.ptp(position)
    there = position <= lowest + LOWEST * travel
    unloaded = position[there & (np.abs(force) <= FELT * noise)]
    if unloaded.size and lowest <= LOWEST * travel and unloaded.max() >= 0.0:
        slack = float(unloaded.max())
        # A tissue of the mean slope is felt there, unless it is not touched yet.
        seen = slack * float(np.ptp(force)) / travel > EVIDENT * FELT * noise
        return slack if seen else 0.0
    if np.count_nonzero(there) < FEWEST_IN_SLOPE or _grows(position, force, there):
        return np.inf
    varies = float(np.std(without_line(force[there])))
    return np.inf if varies > VARIES * noise else 0.0


def _grows(position: FloatArray, force: FloatArray, there: np.ndarray) -> bool:
    """Whether the force grows with the way there, as it does in contact and not in the air.

    By more than a drift may: see ``FLAT``. A ramp is as even in time as a drift is.
    """
    way = position[there] - position[there].mean()
    size = float(way @ way)
    slope = float(way @ force[there]) / size if size > 0.0 else 0.0
    return slope > FLAT * float(np.ptp(force) / np.ptp(position))
