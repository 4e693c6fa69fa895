"""The findings of a figure, in words and numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from tissue_probe.reproduction.experiment import SAMPLE_PERIOD
from tissue_probe.signals import FloatArray


@dataclass(frozen=True)
class ReproducedQuantity:
    """One row of the table: a quantity, the paper's value, those of its method and ours."""

    quantity: str
    stated: str
    paper: str
    ours: str


@dataclass(frozen=True)
class Reproduction:
    """A figure of the paper, made again, and its findings."""

    figure: Figure
    findings: tuple[ReproducedQuantity, ...]


def describe_settling(values: FloatArray, truth: FloatArray, begin: float = 0.0) -> str:
    """Say how long after ``begin`` [s] values come within 5 % of the truth for good.

    Where the truth is 0, within 5 % of the value before ``begin``.
    """
    first = round(begin / SAMPLE_PERIOD)
    scale = np.abs(truth[first:])
    if not scale.all():
        scale = np.where(scale > 0.0, scale, abs(truth[first - 1]))
    outside = np.flatnonzero(~(np.abs(values[first:] - truth[first:]) <= 0.05 * scale))
    sample = outside[-1] + 1 if outside.size else 0
    if sample == scale.size:
        return f"not in {scale.size * SAMPLE_PERIOD:.1f} s"
    return f"{1e3 * sample * SAMPLE_PERIOD:.0f} ms"


def error(values: FloatArray, truth: FloatArray) -> str:
    """Say by how much the mean of the last tenth of a second misses the truth."""
    last = slice(-round(0.1 / SAMPLE_PERIOD), None)
    return f"{100.0 * (values[last].mean() / truth[last].mean() - 1.0):+.2f} %"
