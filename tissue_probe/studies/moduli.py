"""Storage and loss of a recording at the frequency that drives it.

Kelvin-Voigt tissue, k x + beta x', has at one frequency f the complex stiffness k + i 2 pi f beta
(any other tissue has another one, which is not told). Its parts are force over indentation [N/m],
and become moduli [Pa] over a length of the contact, which no recording tells. The frequency is that
of the measured position, by T. Grandke, IEEE Trans. Instrum. Meas. 32 (1983) 350.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tissue_probe.signals import FloatArray

#: Below this share of the motion's power one line does not drive alone: a chirp, several sines.
_ALONE = 0.5


def moduli(row: Mapping[str, Any], position: FloatArray, sample_period: float) -> dict[str, float]:
    """Return ``frequency`` [Hz], ``storage`` and ``loss`` with their errors [N/m].

    Parameters
    ----------
    row : mapping
        Has stiffness [N/m], damping [N s/m] and their standard deviations.
    position : array, shape (n,)
        Evenly sampled [m].
    sample_period : float
        Between its samples [s].

    Returns
    -------
    dict
        Empty where no single frequency drives, or the row lacks a value.
    """
    frequency = driving_frequency(position, sample_period)
    if frequency is None or not {"stiffness", "stiffness_sd", "damping", "damping_sd"} <= set(row):
        return {}
    rate = 2.0 * np.pi * frequency
    return {
        "frequency": frequency,
        "storage": row["stiffness"],
        "storage_sd": row["stiffness_sd"],
        "loss": rate * row["damping"],
        "loss_sd": rate * row["damping_sd"],
    }


def driving_frequency(position: FloatArray, sample_period: float) -> float | None:
    """Return the frequency of a motion [Hz]; None where it has not one alone."""
    size = np.abs(np.fft.rfft((position - position.mean()) * np.hanning(position.size)))
    peak = int(np.argmax(size[1:-1])) + 1 if size.size > 2 else 0
    # A line spreads over two bins to either side of its middle.
    power = float((size[max(peak - 2, 1) : peak + 3] ** 2).sum())
    if not power > _ALONE * float((size[1:] ** 2).sum()) or peak < 2:
        return None  # slower than two periods in the record it is told from no drift
    side = 1 if size[peak + 1] > size[peak - 1] else -1
    ratio = size[peak + side] / size[peak]
    offset = side * (2.0 * ratio - 1.0) / (ratio + 1.0)
    return float((peak + offset) / (position.size * sample_period))
