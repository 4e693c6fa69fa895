"""Unscented Kalman filter (paper, section III-C)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tissue_probe.estimation.ekf import EXTRA, FOLLOWS, update, weigh

if TYPE_CHECKING:
    from collections.abc import Sequence

    import sympy as sp

    from tissue_probe.estimation.equations import Filter

__all__ = ["EXTRA", "FOLLOWS", "predict", "update", "weigh"]

KAPPA = 2


def predict(filter: Filter) -> None:
    """Send 2n + 1 sigma points through the step: eqs. 29-36.

    Eqs. 30 and 31 need the square root of the covariance where they print its eigenvalues; the
    columns of a Cholesky factor do the same as eigenvectors, three times faster and sturdier where
    the elements of P differ by 16 orders of magnitude. Eq. 34 needs f(X^i). With an upper factor
    the first pairs of points differ from the mean in the tip's motion only; where the step is
    linear in the motion its derivative F then gives f(X^i) exactly, and at less cost. The output is
    linear in the state: a second set of sigma points (eqs. 37-41) would give the same as ``update``
    computes from H.
    """
    n = len(filter.X)
    spread = filter.let("spread", (n + KAPPA) ** 0.5 * filter.upper_cholesky(filter.P))
    centre, F = filter.step()
    advanced = [centre]
    for i in range(n):
        if i < filter.linear_states:
            moved = filter.let("moved", F * spread[:, i])
            advanced += [centre + moved, centre - moved]
        else:
            advanced += [filter.step_of(filter.X + spread[:, i])]
            advanced += [filter.step_of(filter.X - spread[:, i])]
    weights = [KAPPA / (n + KAPPA)] + 2 * n * [1 / (2 * (n + KAPPA))]
    mean = filter.let("mean", sum_of(weights, advanced))
    deviations = [filter.let("deviation", point - mean) for point in advanced]
    squares = [deviation * deviation.T for deviation in deviations]
    filter.assign(mean, sum_of(weights, squares) + filter.Q)


def sum_of(weights: Sequence[float], terms: Sequence[sp.Matrix]) -> sp.Matrix:
    """Return the weighted sum of matrices."""
    total = weights[0] * terms[0]
    for weight, term in zip(weights[1:], terms[1:], strict=True):
        total += weight * term
    return total
