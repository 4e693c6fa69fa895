# ruff: noqa: F821
"""Robust extended Kalman filter: a constant force as fifth state, and a gate on the innovations."""

from tissue_probe.estimation.ekf import predict, update

__all__ = ["EXTRA", "predict", "update", "weigh"]

# Means over the last ten or so samples: of NIS, and of the innovations' squares [N^2].
EXTRA = {"MEAN_NIS": 1.0, "MEAN_SQUARE": 0.0}


def weigh(constants, memory, innovation, S):
    """Re-open the covariance where innovations prove that the tissue has changed."""
    memory[MEAN_NIS] = 0.9 * memory[MEAN_NIS] + 0.1 * innovation * innovation / S
    memory[MEAN_SQUARE] = 0.9 * memory[MEAN_SQUARE] + 0.1 * innovation * innovation
    if memory[MEAN_NIS] < 3.5:
        return S
    R = constants[FORCE_VARIANCE]
    factor = max(2.0, (memory[MEAN_SQUARE] - R) / (S - R))
    inflate(constants, memory, factor)
    cap(constants, memory)
    memory[MEAN_NIS] = 1.0
    predicted, S = output(constants, memory)
    return S
