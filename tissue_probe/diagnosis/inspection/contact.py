"""Whether the tip is in contact throughout a record.

What belongs here: telling it from the samples. What does not: where a record that begins in the air
touches (``touch``).
"""

from __future__ import annotations

import numpy as np

from tissue_probe.diagnosis.transforms import without_line
from tissue_probe.signals import FloatArray

#: Share of the travel, at its lower end, in which the tip is in the air if it is anywhere.
LOWEST = 0.1
#: Samples there at least that tell how much the force varies.
FEWEST = 16
#: Times the noise by which the force varies there at least in contact: noise alone does so by one.
FELT = 2.0


def in_contact(position: FloatArray, force: FloatArray, noise: float) -> bool:
    """Return whether the force follows the motion where the tip is least deep.

    In the air it is its zero, which may drift, and the noise. Where few samples tell that, any of
    them may be the touch whose force is zero.

    Parameters
    ----------
    position, force : array, shape (n,)
        [m], positive into the tissue; [N].
    noise : float
        Standard deviation of the force's noise [N].
    """
    lowest = np.min(position) + LOWEST * np.ptp(position)
    there = force[position <= lowest]
    if there.size < FEWEST:
        return bool(np.min(np.abs(there)) > FELT * noise)
    return float(np.std(without_line(there))) > FELT * noise
