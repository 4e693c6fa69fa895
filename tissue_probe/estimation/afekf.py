"""Adaptive fading extended Kalman filter (paper, section III-B), in the reading that works."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tissue_probe.estimation.ekf import EXTRA, FOLLOWS, update, weigh

if TYPE_CHECKING:
    from tissue_probe.estimation.equations import Filter

__all__ = ["EXTRA", "FOLLOWS", "predict", "update", "weigh"]


def predict(filter: Filter) -> None:
    """Advance as the extended filter does, the past fading by a constant: eqs. 20 and 28.

        P_(t+1|t) = alpha F P F^T + Q,  alpha = 1.003

    Taken literally, eqs. 24-27 never forget or never settle. C_t of eq. 25 is the *predicted*
    variance of the innovation, so that no measurement ever enters lambda: N_t = H P_(t|t-1) H^T
    against M_t = H F P_t F^T H^T makes the variance of the force unable to fall, and the filter
    diverges from every P0; with P_t in C_t lambda is 1 and nothing fades; with consistent indices
    N = M and lambda = alpha. Only this last reading gives the paper's figs. 3, 7(c) and 11.
    For a fading that the innovations drive see ``afukf``.
    """
    X, F = filter.step()
    P = filter.constant("fading") * (filter.let("FP", F * filter.P) * F.T) + filter.Q
    filter.assign(X, P)
