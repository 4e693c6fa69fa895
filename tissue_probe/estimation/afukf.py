"""Adaptive fading unscented Kalman filter: the paper's future work (section VI).

The sigma points are the unscented filter's. The fading is that of eqs. 24-28 with the innovations'
variance C_t measured, as Xia, Rao, Ying and Shen (Automatica 30, 1994) have it, instead of the
predicted one that eq. 25 prints:

    lambda = max(1, alpha (C_t - R) / (H P H^T)),  C_t = S times the mean NIS of ten samples

With alpha = 1 the noise of C_t itself drives lambda up to 5 in calm; 1/2 keeps calm and change
apart.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tissue_probe.estimation.ekf import FOLLOWS, update
from tissue_probe.estimation.few_points import spread

if TYPE_CHECKING:
    from tissue_probe.estimation.equations import Filter
    from tissue_probe.estimation.kernel_names import RECENT_NIS, cap, inflate, noise, output
    from tissue_probe.signals import FloatArray

__all__ = ["EXTRA", "FOLLOWS", "predict", "update", "weigh"]

EXTRA: dict[str, float] = {"RECENT_NIS": 1.0}


def predict(filter: Filter) -> None:
    """Send the sigma points through the step, as the unscented filter does."""
    spread(filter, filter.linear_states)


def weigh(
    constants: FloatArray, memory: FloatArray, innovation: float, S: float
) -> tuple[float, float]:
    """Let the past fade as far as the innovations exceed their prediction: eqs. 26-28."""
    R = noise(constants, memory)
    recent = 0.9 * memory[RECENT_NIS] + 0.1 * innovation * innovation / S
    memory[RECENT_NIS] = recent
    fading = 0.5 * (recent * S - R) / (S - R)
    if fading > 1.0:
        inflate(constants, memory, fading, fading)
        cap(constants, memory)
        predicted = S
        _, S = output(constants, memory)
        memory[RECENT_NIS] = recent * predicted / S
    return S, R
