"""The outcome of one test of a residual.

Contents: the arguments and the result of every such test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.signals import FloatArray

#: How often a model without fault fails a test.
SIGNIFICANCE = 1e-3
#: Samples that can be judged: eight segments of eight, in which spectra are averaged and blocks are
#: held out; how well they determine a stiffness is another question (``inspection.information``).
SHORTEST_RESIDUAL = 64


@dataclass(frozen=True)
class ResidualTest:
    """One question put to a residual, and its answer.

    Parameters
    ----------
    name : str
        The tested property, as a short noun.
    statistic : float
        The measured value; ``finding`` says of which quantity, in which unit. NaN if this record
        cannot tell.
    p_value : float
        Chance of such a statistic under a right model with white noise.
    passed : bool
        Whether a right model could have left this: the p-value is not below `SIGNIFICANCE`.
    finding : str
        The statistic in words.
    hint : str
        Which physical effects leave such a residual; empty if passed.
    """

    name: str
    statistic: float
    p_value: float
    passed: bool
    finding: str
    hint: str


def judge_test(
    name: str, statistic: float, p_value: float, finding: str, hint: str
) -> ResidualTest:
    """Return a test as decided by its p-value; the hint of one that is passed is dropped."""
    passed = bool(p_value >= SIGNIFICANCE)
    return ResidualTest(
        name, float(statistic), float(p_value), passed, finding, "" if passed else hint
    )


def untold(name: str, reason: str) -> ResidualTest:
    """Return a test that this record cannot decide, and why."""
    return ResidualTest(name, np.nan, 1.0, True, f"cannot be told: {reason}", "")


def check_signals(noise: float, *signals: FloatArray) -> tuple[FloatArray, ...]:
    """Return the signals of a record as arrays, fit to be judged.

    Raises
    ------
    ValueError
        If they differ in length, are too short or not finite, or the noise is not positive.
    """
    arrays = tuple(np.asarray(each, dtype=np.float64) for each in signals)
    shapes = {array.shape for array in arrays}
    if len(shapes) > 1 or arrays[0].ndim != 1 or arrays[0].size < SHORTEST_RESIDUAL:
        raise ValueError(
            f"signals of shapes {', '.join(str(array.shape) for array in arrays)} cannot be "
            f"judged; give one length of at least {SHORTEST_RESIDUAL} samples"
        )
    if not (all(np.isfinite(array).all() for array in arrays) and noise > 0.0):
        raise ValueError("every sample must be finite, and the noise positive")
    return arrays
