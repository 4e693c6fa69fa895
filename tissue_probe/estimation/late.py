"""Two channels of which one is late, brought together sample by sample as they come.

What belongs here: reading the other channel as it was earlier. What does not: how late one is
(``identification.delay``, the effect ``channel_delay``).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Late:
    """Reads a stream of samples a constant time earlier, by the cubic through four of them.

    None of the four comes after the sample at hand. The same to the last bit, however the stream is
    cut into blocks. What lies before the first sample stands still.

    Parameters
    ----------
    samples : float
        How much earlier, in samples; 0 or more.
    """

    def __init__(self, samples: float) -> None:
        before = max(int(np.ceil(samples)) + 1, 3)
        places = np.arange(4.0) - before
        others = [np.delete(places, each) for each in range(4)]
        pairs = zip(places, others, strict=True)
        self._weights = [float(np.prod((-samples - rest) / (own - rest))) for own, rest in pairs]
        self._past = np.empty(0)
        self._before = before

    def read(self, values: FloatArray) -> FloatArray:
        """Return the next samples, shape (n,), as they were earlier; NaN near what is NaN."""
        if not self._past.size:
            self._past = np.full(self._before, values[0])
        whole = np.concatenate([self._past, values])
        self._past = whole[-self._before :]
        w, n = self._weights, values.size
        return (
            w[0] * whole[:n]
            + w[1] * whole[1 : n + 1]
            + w[2] * whole[2 : n + 2]
            + (w[3] * whole[3 : n + 3])
        )

    def restart(self) -> None:
        """Forget what came before."""
        self._past = np.empty(0)
