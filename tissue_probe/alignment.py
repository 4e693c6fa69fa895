"""Force and position of one instant, where one channel is later than the other.

Contents: the correction of a delay that is known.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.signals import FloatArray


class Alignment:
    """Delays the earlier channel, block by block, until both are of one instant.

    The value between samples is that of the cubic through four of them (Lagrange), none of which
    is yet to come: nothing is predicted. The first sample counts as having lasted since ever.

    Parameters
    ----------
    delay : float
        By how many samples the force comes after the position; negative where it comes before.
    """

    def __init__(self, delay: float) -> None:
        self._force_is_late = delay > 0.0
        self._weights = _weights(abs(delay))
        self._past: FloatArray | None = None

    def apply(self, position: FloatArray, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the next samples of both channels, each of shape (n,), aligned."""
        if self._force_is_late:
            return self._delay_values(position), force
        return position, self._delay_values(force)

    def _delay_values(self, values: FloatArray) -> FloatArray:
        """Return as many values, late by the delay."""
        reach = self._weights.size - 1
        if reach == 0:
            return values
        if self._past is None:
            self._past = np.full(reach, values[0])
        known = np.concatenate([self._past, values])
        self._past = known[-reach:]
        return np.convolve(known, self._weights, "valid")


def _weights(delay: float) -> FloatArray:
    """Return the weights of the present sample, the one before it, and so on."""
    if delay == 0.0:
        return np.ones(1)
    first = max(0, int(delay) - 1)  # of the four samples, with the instant in their midst
    at, nodes = delay - first, np.arange(4.0)
    four = [np.prod([(at - m) / (n - m) for m in nodes if m != n]) for n in nodes]
    return np.concatenate([np.zeros(first), four])
