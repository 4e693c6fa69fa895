"""Samples that no model follows, since they stand alone in its residual: disturbances.

Contents: finding them in the residual of a fit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.ndimage import binary_closing, median_filter, percentile_filter

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.signals import BoolArray, FloatArray, spans_of

#: A row of outliers is off by this many standard deviations of the residual around it, at the worst
#: and at the least: of white noise one sample in 26 million is at the worst.
FAR, NEXT = 5.5, 3.5
#: And that at once, by this many from a sample to the next: a missing effect comes more slowly.
EDGE_DEVIATIONS = 2.5
#: Samples in a row at the most, and between two such rows at least.
LONGEST, APART = 8, 20
#: Samples around, of which the median is the model's residual, and the spread the noise.
AROUND, SPREAD = 25, 151
#: Outliers in more than this share of the samples are an effect that the model lacks.
RARE = 0.01
#: Residual over noise of the rest above which a model lacks so much that nothing is said.
NEARLY = 2.5


def without_outliers(fit: Fit) -> list[Measurement] | None:
    """Return the measurements of a fit without its outliers; None where there are none."""
    pairs = zip(fit.measurements, fit.residuals, strict=True)
    found = [outliers(residual, measurement) for measurement, residual in pairs]
    kept = fit.without(found, RARE)
    return kept if kept and _measure_rest(fit, found) <= NEARLY else None


def _measure_rest(fit: Fit, outliers: Sequence[BoolArray]) -> float:
    """Return residual over noise, root mean square, without the outliers."""
    over_noise = [
        (residual / measurement.noise.own)[measurement.used & ~each]
        for residual, measurement, each in zip(
            fit.residuals, fit.measurements, outliers, strict=True
        )
    ]
    return float(np.sqrt(np.mean(np.concatenate(over_noise) ** 2)))


def outliers(residual: FloatArray, measurement: Measurement) -> BoolArray:
    """Tell the samples that are off for a short time, and at once."""
    number, used = np.arange(residual.size), measurement.used
    if used.any():  # samples that are left out already tell nothing of those beside them
        residual = np.interp(number, number[used], residual[used])
    over = _measure_deviation(residual, residual, measurement)
    far = over > FAR
    if not far.any():
        return far
    # A long row moves the median around it, so that the samples beside it seem to be off, too.
    bridged = np.interp(number, number[~far], residual[~far])
    over = np.pad(_measure_deviation(residual, bridged, measurement), LONGEST)
    found = np.zeros(over.size, dtype=bool)
    for first, stop in _find_lone_rows(over):
        if min(over[first] - over[first - 1], over[stop - 1] - over[stop]) > EDGE_DEVIATIONS:
            found[first:stop] = True
    return found[LONGEST:-LONGEST] & used


def _measure_deviation(
    residual: FloatArray, others: FloatArray, measurement: Measurement
) -> FloatArray:
    """Return by how many standard deviations each sample is off the median of others around it."""
    off = np.abs(residual - median_filter(others, AROUND))
    found: FloatArray = off / np.maximum(percentile_filter(off, 68, SPREAD), measurement.noise.own)
    return found


def _find_lone_rows(over: FloatArray) -> Iterator[tuple[int, int]]:
    """Yield (first, stop) of each row that is short, and far from any other.

    Up to two samples within it may be less off.
    """
    rows = spans_of(binary_closing(over > NEXT, np.ones(3)))
    worst = [(first, stop) for first, stop in rows if over[first:stop].max() > FAR]
    for place, (first, stop) in enumerate(worst):
        before = worst[place - 1][1] if place else -APART
        after = worst[place + 1][0] if place + 1 < len(worst) else np.inf
        if stop - first <= LONGEST and first - before >= APART and after - stop >= APART:
            yield first, stop
