"""Weights of free functions, smooth as far as the evidence asks.

Contents: one penalised fit of a set of groups, from their products alone; its evidence, and its
residual on blocks that it was not fitted to.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from tissue_probe.diagnosis.fitting.outcome import REASON
from tissue_probe.diagnosis.shape.gram import Gram
from tissue_probe.signals import FloatArray, IntArray

#: Rounds of the penalties, and the change of their logarithms below which they have settled.
ROUNDS, SETTLED = 40, 0.03
#: Penalties of scaled columns: none, and such that a group is gone.
LEAST, MOST = 1e-13, 1e12
#: Added to the products of columns of unit size, so that equal ones can be told.
ROUNDING = 1e-13


@dataclass(frozen=True, eq=False)
class Smooth:
    """Free functions fitted together to a model's residual.

    Attributes
    ----------
    columns : array of int, shape (p,)
        Of the Gram matrix: the model's own, then those of the groups.
    weights : array, shape (p,)
        Of these columns as they are (not over their scale).
    covariance : array, shape (p, p)
        Of the errors of the weights.
    evidence : float
        Logarithm of the probability of the residual, up to a constant of the record.
    ratio : float
        Residual over the noise, rms.
    heldout : float
        The same of each block, by a fit to all others.
    """

    columns: IntArray
    weights: FloatArray
    covariance: FloatArray
    evidence: float
    ratio: float
    heldout: float


def smooth(gram: Gram, groups: Sequence[str]) -> Smooth:
    """Fit groups together, each with a penalty of its own by restricted maximum likelihood.

    The penalties follow the rule of Wood and Fasiolo (Biometrics 73 (2017), 1071).
    """
    fitted = _Fitted(gram, groups)
    return fitted.settled()


class _Fitted:
    def __init__(self, gram: Gram, groups: Sequence[str]) -> None:
        self.gram = gram
        places = [gram.places[name] for name in groups]
        self.columns = np.concatenate([np.arange(gram.own), *places]).astype(int)
        self.own = gram.own
        every = np.ix_(np.arange(len(gram.products)), self.columns, self.columns)
        self.blocks = gram.products[every]
        self.towards = gram.towards[:, self.columns]
        self.whole = self.blocks.sum(axis=0)
        self.right = self.towards.sum(axis=0)
        self.right[: self.own] += gram.precision * gram.departure
        self.square = float(gram.squares.sum() + gram.precision @ gram.departure**2)
        sizes = [place.size for place in places]
        ends = self.own + np.cumsum([0, *sizes])
        self.slices = [slice(a, b) for a, b in pairwise(ends)]
        # A penalty is on the columns as they are; within a group its mean is 1.
        self.shares = [self._shares(gram.scale[place]) for place in places]

    @staticmethod
    def _shares(scale: FloatArray) -> FloatArray:
        return np.asarray(np.mean(scale**2) / scale**2)

    def settled(self) -> Smooth:
        penalties = np.ones(len(self.slices))
        for _ in range(ROUNDS):
            factor, weights, inverse, noise = self._solved(penalties)
            before = penalties.copy()
            for index, (place, shares) in enumerate(zip(self.slices, self.shares, strict=True)):
                size = float(shares @ weights[place] ** 2)
                free = shares.size - penalties[index] * float(shares @ np.diag(inverse)[place])
                asked = noise * max(free, 0.0) / max(size, 1e-300)
                penalties[index] = np.clip(asked, LEAST, MOST)
            if np.all(np.abs(np.log(penalties / before)) < SETTLED):
                break
        factor, weights, inverse, noise = self._solved(penalties)
        left = self._left(weights)
        samples = self.gram.samples
        volume = 2.0 * np.sum(np.log(np.diag(factor)))
        volume -= sum(
            float(np.sum(np.log(each * shares)))
            for each, shares in zip(penalties, self.shares, strict=True)
        )
        cost = samples * np.log(noise) + (self.square - self.right @ weights) / noise + volume
        scale = self.gram.scale[self.columns]
        return Smooth(
            self.columns,
            weights / scale,
            noise * inverse / np.multiply.outer(scale, scale),
            -0.5 * float(cost),
            float(np.sqrt(max(left, 0.0) / samples)),
            self._held_out(weights, penalties),
        )

    def _penalised(self, penalties: FloatArray) -> FloatArray:
        whole = self.whole.copy()
        diagonal = np.zeros(self.columns.size)
        diagonal[: self.own] = self.gram.precision
        for place, each, shares in zip(self.slices, penalties, self.shares, strict=True):
            diagonal[place] = each * shares
        whole.flat[:: self.columns.size + 1] += diagonal + ROUNDING
        found: FloatArray = whole
        return found

    def _solved(self, penalties: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, float]:
        factor = cho_factor(self._penalised(penalties), lower=True)
        weights = cho_solve(factor, self.right)
        inverse = cho_solve(factor, np.eye(self.columns.size))
        # No fit is better than the noise is known to be.
        noise = max(1.0, (self.square - float(self.right @ weights)) / self.gram.samples)
        return factor[0], weights, inverse, noise

    def _left(self, weights: FloatArray) -> float:
        towards = self.towards.sum(axis=0)
        return float(
            self.gram.squares.sum() - 2.0 * towards @ weights + weights @ self.whole @ weights
        )

    def _held_out(self, weights: FloatArray, penalties: FloatArray) -> float:
        """Return the residual of each block, of a fit to the others; starts stay as they are."""
        whole = self._penalised(penalties)
        free = np.setdiff1d(np.arange(self.columns.size), self.gram.starts)
        root = np.sqrt(np.diag(whole)[free])
        left = 0.0
        for block, towards, square in zip(
            self.blocks, self.towards, self.gram.squares, strict=True
        ):
            rest = (whole - block)[np.ix_(free, free)] / np.multiply.outer(root, root)
            # A weight that only this block tells stays within reason.
            rest.flat[:: free.size + 1] += REASON * 1e-2
            pull = (towards - block @ weights)[free] / root
            other = weights.copy()
            other[free] -= np.linalg.solve(rest, pull) / root
            left += float(square - 2.0 * towards @ other + other @ block @ other)
        return float(np.sqrt(max(left, 0.0) / self.gram.samples))
