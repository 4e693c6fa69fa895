"""Extended Kalman filter (paper, section III-A)."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tissue_probe.estimation.equations import Filter
    from tissue_probe.estimation.kernel_names import noise
    from tissue_probe.signals import FloatArray


# Numbers that a filter keeps beside mean and covariance: names and values at the start.
EXTRA: dict[str, float] = {}
# Whether a change of stiffness and damping is followed, so that a first harmonic in the innovations
# is no contradiction.
FOLLOWS = False


def predict(filter: Filter) -> None:
    """Advance mean and covariance by one sample: eqs. 20 and 23.

    F is the exact derivative of the step (with ``discretisation='euler'``, eq. 17). Eq. 20 is
    printed with f(X_t, u_t) for f(X_(t-1), u_(t-1)). Q is read as a variance per sample.
    """
    X, F = filter.step()
    P = filter.let("FP", F * filter.P) * F.T + filter.Q
    filter.assign(X, P)


def update(filter: Filter) -> None:
    """Take in the force: eqs. 19, 21 and 22 (Joseph's form).

    Eq. 21 is printed with h(X_t) for h(X_t^-), and eq. 18 calls H a 4x1 matrix; it is 1x4.
    """
    P, H, S, R = filter.P, filter.H, filter.S, filter.R
    HP = filter.let("HP", H * P)
    K = filter.let("K", HP.T / S)
    LP = filter.let("LP", P - K * HP)  # L = I - K H
    P = LP + (K * R - filter.let("LPH", LP * H.T)) * K.T  # L P L^T + K R K^T
    filter.assign(filter.X + K * filter.innovation, P)


def weigh(
    constants: FloatArray, memory: FloatArray, innovation: float, S: float
) -> tuple[float, float]:
    """Return the variances of the innovation and of the force: those that were predicted."""
    return S, noise(constants, memory)
