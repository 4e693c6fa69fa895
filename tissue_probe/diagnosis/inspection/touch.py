"""Where the tip touches, in a record that begins in the air.

What belongs here: finding the first touch. What does not: what is done with it (``cleaning``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.signals import FloatArray

#: A force is felt from so many standard deviations of its noise on, in so many samples in a row.
FELT, IN_A_ROW = 4.0, 4
#: Of the slope that follows, the force in the air has this share at the most, doubt included: the
#: softest law of contact, a cone's square, has a third of it in as long a way.
FLAT = 0.1
#: Samples that tell a slope.
FEWEST = 16


@dataclass(frozen=True)
class Touch:
    """The first touch: number of the last sample in the air, and the position there [m]."""

    sample: int
    position: float


def first_touch(position: FloatArray, force: FloatArray, noise: float) -> Touch | None:
    """Find where a record that begins in the air first feels the tissue; None where it does not.

    In the air the force is the same wherever the tip is; in contact it grows with the way.

    Parameters
    ----------
    position, force : array, shape (n,)
        [m], positive into the tissue; [N].
    noise : float
        Standard deviation of the force's noise [N].
    """
    usual = np.median(force[:IN_A_ROW])
    felt = np.abs(force - usual) > FELT * noise
    rows = np.convolve(felt, np.ones(IN_A_ROW), mode="valid") == IN_A_ROW
    if not rows.any():
        return None
    last = int(np.argmax(rows)) - 1
    way = position[last] - position[0] if last > 0 else 0.0
    beyond = np.flatnonzero(position[last:] > position[last] + way)
    after = last + (int(beyond[0]) if beyond.size else position.size - last)
    if last < FEWEST or after - last < FEWEST or way <= 0.0:
        return None
    if np.ptp(position[last:after]) == 0.0:  # a tip at rest comes from nowhere
        return None
    slope, doubt = _slope(position[: last + 1], force[: last + 1])
    following, _ = _slope(position[last:after], force[last:after])
    if not abs(slope) + 2.0 * doubt < FLAT * following:
        return None
    return Touch(last, float(position[last]))


def _slope(position: FloatArray, force: FloatArray) -> tuple[float, float]:
    """Return the slope of a force over a position, and its standard deviation [N/m]."""
    at = position - position.mean()
    size = float(at @ at)
    slope = float(at @ force) / size
    left = force - force.mean() - slope * at
    return slope, float(np.sqrt(left @ left / ((at.size - 2) * size)))
