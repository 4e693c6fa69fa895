"""Coloured noise made white: exactly from the first sample of every stretch on.

What belongs here: the rows that whiten, told from errors that were drawn, and their use on samples.
What does not: which errors are drawn (``coloured``), noise that a chain describes (``shaken``).

Let C be the covariance of n consecutive errors and L its Cholesky factor, C = L L^T. The rows of
the inverse of L take from each sample the part that those before it tell, and divide the rest by
its deviation: the result is white and of variance 1 (B. Anderson, J. Moore, Optimal Filtering
(1979), section 5.3). The first row divides by the deviation of the whole noise; the last is a
filter, which serves all later samples, too: that of an autoregression by least squares (L. Ljung,
System Identification, 2nd ed. (1999), section 10.1). A filter alone, begun at zero, says nothing of
the first samples. A wrong state at the start is then free of charge, since noise that a model
colours has the model's free motion as its root.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tissue_probe.signals import BoolArray, FloatArray, spans_of


@dataclass(frozen=True)
class Whitening:
    """Rows that make noise white and of variance 1.

    Attributes
    ----------
    rows : array, shape (p + 1, p + 1)
        Lower triangular [1 / unit of the noise]. Row k serves the sample that follows k others of
        its stretch; the last row serves all after p others.
    """

    rows: FloatArray

    @classmethod
    def of(cls, errors: Sequence[FloatArray], order: int) -> Whitening:
        """Return what whitens noise of which some was drawn, each sample by ``order`` before it."""
        windows = [np.lib.stride_tricks.sliding_window_view(each, order + 1) for each in errors]
        every = np.concatenate(windows)
        # The covariance itself would have the square of the errors' condition.
        upper = np.linalg.qr(every / np.sqrt(len(every)), mode="r")
        lower = (upper * np.sign(np.diag(upper))[:, np.newaxis]).T
        return cls(np.tril(np.linalg.inv(lower)))

    @classmethod
    def of_white(cls, deviation: float) -> Whitening:
        """Return the same for noise that is white already."""
        return cls(np.array([[1.0 / deviation]]))

    @property
    def deviation(self) -> float:
        """Standard deviation of the noise as it is [its unit]."""
        return float(1.0 / self.rows[0, 0])

    @property
    def news(self) -> float:
        """Standard deviation of the part of a sample that those before it do not tell."""
        return float(1.0 / self.rows[-1, -1])

    def times(self, factor: float) -> Whitening:
        """Return the same for noise that is so many times larger."""
        return replace(self, rows=self.rows / factor)

    def white(self, values: FloatArray, used: BoolArray) -> FloatArray:
        """Return values, shape (n, ...), white in each stretch of samples that count; others 0."""
        from scipy.signal import lfilter  # only where the noise is not white

        columns = (values.T * used).T
        white = lfilter(self.rows[-1, ::-1], [1.0], columns, axis=0)
        for first, stop in spans_of(used):
            few = min(len(self.rows) - 1, stop - first)
            own = columns[first : first + few].reshape(few, -1)
            white[first : first + few] = (self.rows[:few, :few] @ own).reshape(
                few, *columns.shape[1:]
            )
        return (white.T * used).T
