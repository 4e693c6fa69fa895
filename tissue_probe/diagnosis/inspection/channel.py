"""One channel of a measurement: its values, their resolution and white noise.

Contents: properties of a channel that the checks of ``inspection`` need.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tissue_probe.diagnosis.inspection.levels import decimal_grain, step_size
from tissue_probe.diagnosis.residuals.noise_floor import (
    EXACT,
    NOISY,
    noise_beside_steps,
    noise_floor,
)
from tissue_probe.signals import FloatArray


@dataclass(frozen=True)
class InspectedChannel:
    """Values of one channel, shape (n,), at least 12, finite; in any unit."""

    name: str
    values: FloatArray

    @cached_property
    def span(self) -> float:
        """Largest minus smallest value."""
        return float(np.ptp(self.values))

    @cached_property
    def step(self) -> float:
        """The step in which the values come; 0 where they come in none."""
        return step_size(self.values) or 0.0

    @cached_property
    def grain(self) -> float:
        """How far apart values are that rounding does not make equal; 0 where it makes none."""
        return self.step or decimal_grain(self.values)

    @cached_property
    def noise(self) -> float:
        """Standard deviation of the white noise, that of rounding included."""
        return noise_floor(self.values)

    @cached_property
    def noisy(self) -> bool:
        """Whether noise, not the step, decides if two samples are equal.

        A channel whose noise is 0.3 steps has none but rounding; from 0.6 steps on it changes from
        sample to sample also at rest. Without steps, simulations without noise have a millionth of
        the span by their arithmetic. A channel that rests for most of the time has none.
        """
        noise = noise_beside_steps(self.values)
        return noise > NOISY * self.grain and noise > EXACT * self.span
