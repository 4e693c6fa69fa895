"""Whether a record tells the place of touch: the tip is in the air, or just touches at its zero.

What belongs here: telling it from the samples. What does not: where a record that begins in the air
touches (``touch``).
"""

from __future__ import annotations

import numpy as np

from tissue_probe.diagnosis.inspection.touch import FELT, FEWEST
from tissue_probe.diagnosis.transforms import without_line
from tissue_probe.signals import FloatArray

#: Share of the travel, at its lower end, in which the tip is in the air if it is anywhere.
LOWEST = 0.1
#: Times the noise by which the force varies there at least in contact: of the fewest samples that
#: are asked, noise alone does so in less than one of ten million.
VARIES = 2.0


def is_pressed(position: FloatArray, force: FloatArray, noise: float) -> bool:
    """Return whether the tip is in the tissue throughout, and how deep nothing in the record tells.

    In the air the force is its zero, which may drift, and the noise. Where the force comes to zero
    at the position's zero, the tip touches there.

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
        return False
    if np.count_nonzero(there) < FEWEST:
        return True
    return float(np.std(without_line(force[there]))) > VARIES * noise
