"""Contact of a tip that vibrates, felt by the load cell.

Contents: the test, fed with the samples of one descent.

The steady force is that part of the force, over a period of the motion, which follows neither the
position nor the velocity: by least squares the constant of F = constant + a u + b u'. In free air
it is the load cell's zero, as the tip's inertia follows the position. Tissue changes it at once,
since it is in a part of the period only, and then by its stiffness times the depth. So contact is a
change of it, up or down (a suction tip pulls, too), against the air above the site.
"""

from __future__ import annotations

import math

import numpy as np

from tissue_probe.mapping.leaving import period
from tissue_probe.signals import SampleBlock


class Touch:
    """What the load cell felt of one descent.

    Parameters
    ----------
    force : float
        Change of the steady force that is contact [N].

    Attributes
    ----------
    period : float
        Of the motion [s]; NaN until it has gone through one.
    change : float
        Of the steady force over the latest period, against that in free air [N].
    most : float
        Largest force of any sample since then, less the steady one in free air [N].
    reached : int
        Time that the samples have reached [ns since the epoch].
    """

    def __init__(self, force: float) -> None:
        self._threshold = force
        self._position, self._force = np.zeros(0), np.zeros(0)
        self._count: int | None = None
        self._free = math.nan
        self.period = math.nan
        self.change = 0.0
        self.most = 0.0
        self.reached = 0

    @property
    def knows_free_air(self) -> bool:
        """Whether a period in free air was seen: the tip may go down."""
        return self._count is not None

    @property
    def is_felt(self) -> bool:
        """Whether the tip is in contact."""
        return abs(self.change) > self._threshold

    def add_samples(self, block: SampleBlock) -> None:
        """Take the next samples; those whose force is no number are left out."""
        self.reached = block.end
        known = np.isfinite(block.force) & np.isfinite(block.position)
        position, force = block.position[known], block.force[known]
        self._position = np.concatenate([self._position, position])
        self._force = np.concatenate([self._force, force])
        if self._count is None:
            self._count = period(self._position)
            if self._count is not None:
                self._free = self._steady(self._count)
                self.period = self._count * block.sample_period
            return
        self.change = self._steady(self._count) - self._free
        self.most = max(self.most, float(np.abs(force - self._free).max(initial=0.0)))

    def _steady(self, count: int) -> float:
        """Return the steady force of the latest samples [N], and forget those before them."""
        self._position, self._force = self._position[-count:], self._force[-count:]
        u = self._position  # from its own zero: the mean of a period that is not whole wanders
        parts = np.column_stack([np.ones(count), u, np.gradient(u)])
        parts /= np.linalg.norm(parts, axis=0)  # metres and newtons lie far apart
        return float(np.linalg.lstsq(parts, self._force)[0][0] / np.sqrt(count))
