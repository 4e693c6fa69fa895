"""The unscented prediction with fewer sigma points: those that the tangent cannot stand for.

In well-conditioned problems it is the prediction of ``ukf`` to the last few bits, at less cost.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tissue_probe.estimation import ekf

if TYPE_CHECKING:
    import sympy as sp

    from tissue_probe.estimation.equations import Filter

KAPPA = 2


def spread(filter: Filter, tangent: int) -> None:
    """Predict; the tangent F says where the points of the first ``tangent`` states go.

    It does so exactly where the step is linear in these states (all that move, or none). With an
    upper factor P = U U^T their points differ from the mean in nothing else, so that only the
    points of the other columns j need a step of their own. With c^2 = n + kappa:

        a_j, b_j = (f(X + c U_j) +- f(X - c U_j)) / 2,  d = sum of (a_j - f(X)) / c^2
        mean = f(X) + d
        P = sum of (F U_i) (F U_i)^T over the first columns
            + sum of ((a_j - f(X)) (a_j - f(X))^T + b_j b_j^T) / c^2 - d d^T + Q

    The parameters do not move; where nothing else does either, no point is needed. Their part of P
    is put together from U all the same: where rounding left P indefinite, this mends it.
    """
    if not filter.model.states:
        ekf.predict(filter)
        return
    import sympy as sp  # only where a kernel has to be generated: it takes half a second

    moving, c_squared = len(filter.model.states), len(filter.X) + KAPPA
    X, F = filter.step() if tangent else (filter.step_of(filter.X), None)
    U = filter.upper_cholesky(filter.P)
    d, P = sp.zeros(moving, 1), sp.Matrix(filter.Q)
    for j in range(tangent, U.cols):
        offset = filter.let("offset", sp.sqrt(c_squared) * U[:, j])
        ahead, behind = (filter.step_of(filter.X + side)[:moving, :] for side in (offset, -offset))
        a = filter.let("a", (ahead + behind) / 2 - X[:moving, :])
        b = filter.let("b", (ahead - behind) / 2).col_join(offset[moving:, :])
        d += a / c_squared
        P += b * b.T / c_squared
        P[:moving, :moving] += a * a.T / c_squared
    d = filter.let("d", d)
    P[:moving, :moving] -= d * d.T
    if F is not None:
        FU = filter.let("FU", F[:moving, :moving] * U[:moving, :moving])
        P[:moving, :moving] += FU * FU.T
    filter.assign(X + d.col_join(sp.zeros(len(X) - moving, 1)), P)


def tangent_is_poor(filter: Filter, P: sp.Matrix) -> str:
    """Return, as source, whether the tangent leaves out more than the process noise.

    The tissue's force k x + beta x' is a product of unknowns: the tangent at their mean leaves out
    errors of the variance P_kk P_xx + P_bb P_vv [N^2], which move the tip by dt / m. P is the
    covariance that counts, in symbols.
    """
    P, Q = filter.diagonal(P), filter.diagonal(filter.Q)
    rate = filter.constant("sample_period") / filter.constant("tip_mass")
    lost = P["stiffness"] * P["tip_position"] + P["damping"] * P["tip_velocity"]
    left_out = filter.program.let("left_out", rate**2 * lost)
    return f"{left_out} > {Q['tip_velocity']}"
