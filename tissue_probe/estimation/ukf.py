"""Unscented Kalman filter (paper, section III-C)."""

from tissue_probe.estimation.ekf import EXTRA, update, weigh

__all__ = ["EXTRA", "predict", "update", "weigh"]

KAPPA = 2


def predict(filter):
    """Send 2n + 1 sigma points through the step: eqs. 29-36.

    Eqs. 30 and 31 need the square root of the covariance where they print its eigenvalues; the
    columns of a Cholesky factor do the same as eigenvectors, three times faster and sturdier where
    the elements of P differ by 16 orders of magnitude. Eq. 34 needs f(X^i). The output is linear in
    the state: a second set of sigma points (eqs. 37-41) would give what ``update`` computes from H.
    """
    spread(filter, filter.linear_states)


def spread(filter, tangent):
    """Predict; the tangent F says where the points of the first ``tangent`` states go.

    It does so exactly where the step is linear in these states (all that move, or none). With an
    upper factor P = U U^T their points differ from the mean in nothing else, and together carry
    C = P - sum of U_j U_j^T over the other columns j. So only these columns are computed:

        a_j, b_j = (f(X + c U_j) +- f(X - c U_j)) / 2,  c^2 = n + kappa
        mean = f(X) + d,  d = sum of (a_j - f(X)) / c^2
        P = F C F^T + sum of ((a_j - f(X)) (a_j - f(X))^T + b_j b_j^T) / c^2 - d d^T + Q

    The parameters, which do not move, keep their means and their part of P.
    """
    import sympy as sp  # only where a kernel has to be generated: it takes half a second

    moving, c_squared = len(filter.model.states), len(filter.X) + KAPPA
    X, F = filter.step() if tangent else (filter.step_of(filter.X), None)
    U, C = filter.upper_cholesky(filter.P, tangent)
    squares = sp.zeros(moving, len(filter.X))
    d = sp.zeros(moving, 1)
    for j in range(U.cols):
        offset = filter.let("offset", sp.sqrt(c_squared) * U[:, j])
        ahead, behind = (filter.step_of(filter.X + side)[:moving, :] for side in (offset, -offset))
        a = filter.let("a", (ahead + behind) / 2 - X[:moving, :])
        b = filter.let("b", (ahead - behind) / 2)
        d += a / c_squared
        squares += (b * b.T + a * a.T).row_join(b * offset[moving:, :].T) / c_squared
    d = filter.let("d", d)
    P = filter.P + filter.Q
    P[:moving, :] = squares
    P[:moving, :moving] += filter.Q[:moving, :moving] - d * d.T
    if tangent:
        F = F[:, :moving]
        P[:moving, :moving] += filter.let("FC", F[:moving, :] * C) * F[:moving, :].T
    filter.assign(X + d.col_join(sp.zeros(len(X) - moving, 1)), P)
