"""Noise of a driving force in the output, made white from the first sample of every stretch on.

Contents: the covariance of such noise, the rows that whiten it, how large it is in a residual.

Let C be the covariance of n consecutive errors and L its Cholesky factor, C = L L^T. The rows of
the inverse of L take from each sample the part that those before it tell, and divide the rest by
its deviation: the result is white and of variance 1 (B. Anderson, J. Moore, Optimal Filtering
(1979), section 5.3). The last row is a filter, which serves all later samples, too: that of an
autoregression (L. Ljung, System Identification, 2nd ed. (1999), section 10.1). A filter alone,
begun at zero, says nothing of the first samples. A wrong state at the start is then free of charge,
since noise that a model colours has the model's free motion as its root.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from tissue_probe.diagnosis.observation.noise import Noise
from tissue_probe.signals import BoolArray, FloatArray, spans_of

#: White noise of the output over that of the force in it, as ratios that are tried: half of a step
#: is 15 %, and so well the smaller of both deviations is told.
RATIOS = np.geomspace(1e-4, 10.0, 41)
#: Share of the covariance's mean that rounding may be: so much is added to the matrix that is
#: inverted.
COVARIANCE_ROUNDING = 1e-13


@dataclass(frozen=True)
class Coloured(Noise):
    """White noise, and the noise that white noise of the driving force makes in the output.

    Attributes
    ----------
    own : float
        See ``Noise``.
    driven : array, shape (p + 1, p + 1)
        Covariance of consecutive samples of the output under white noise of the force of 1 N.
    force : float
        Standard deviation of the white noise of the force [N].
    """

    driven: FloatArray
    force: float

    is_white: ClassVar[bool] = False
    counted_too: ClassVar[str] = "the motion that noise of the force makes"

    @classmethod
    def of(cls, errors: Sequence[FloatArray], order: int, force: float, own: float) -> Coloured:
        """Return the noise of which some was drawn, each sample following ``order`` before it.

        ``errors`` are changes of the output under noise ``force`` of the force.
        """
        windows = [np.lib.stride_tricks.sliding_window_view(each, order + 1) for each in errors]
        every = np.concatenate(windows) / force
        return cls(own, every.T @ every / len(every), force)

    @property
    def by_input(self) -> float:
        """Standard deviation of the noise that errors of the input make [unit of the output]."""
        return self.force * float(np.sqrt(self.driven[0, 0]))

    def within(
        self, residual: FloatArray, used: BoolArray, own: float, colour: bool
    ) -> tuple[Noise, float]:
        """Return noise with less of the driving force's in it, or none: see ``Noise``.

        Whichever makes the residual likelier.
        """
        found = self.likeliest(residual, used) if colour else None
        if found is None or not found.force:
            return Noise(own), 0.0
        return found, found.force

    def restart_estimate(self) -> Coloured:
        """Return the same: its white noise is not told from the samples alone."""
        return self

    @property
    def covariance(self) -> FloatArray:
        """Of consecutive samples, shape (p + 1, p + 1)."""
        whole = self.force**2 * self.driven
        whole[np.diag_indices(len(whole))] += self.own**2 + COVARIANCE_ROUNDING * np.mean(
            np.diag(whole)
        )
        return whole

    @cached_property
    def rows(self) -> FloatArray:
        """The rows that whiten, shape (p + 1, p + 1), lower triangular.

        Row k serves the sample that follows k others of its stretch; the last all after p others.
        """
        return np.tril(np.linalg.inv(np.linalg.cholesky(self.covariance)))

    @property
    def news(self) -> float:
        """Standard deviation of the part of a sample that those before it do not tell."""
        return float(1.0 / self.rows[-1, -1])

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
        masked: FloatArray = (white.T * used).T
        return masked

    def likeliest(self, residual: FloatArray, used: BoolArray) -> Coloured:
        """Return the noise, no larger than this in the force, that a residual is likeliest for.

        Both deviations are told: their ratio is tried, and the size follows from the residual, as
        the likelihood is the product of ``news`` over all samples then.

        Parameters
        ----------
        residual : array, shape (n,)
            Of a model.
        used : array of bool, shape (n,)
            Which samples count.
        """
        size = float(np.sqrt(np.mean(residual[used] ** 2)))
        best, least = replace(self, own=size, force=0.0), size
        coloured = replace(self, force=1.0).by_input
        for ratio in RATIOS:
            one = replace(self, force=1.0, own=ratio * coloured)
            left = float(np.sqrt(np.mean(one.white(residual, used)[used] ** 2)))
            if left <= self.force and left * one.news < least:
                best, least = replace(self, force=left, own=left * one.own), left * one.news
        return best
