"""Where the course of a position between its samples is not known: at corners, and at jumps.

What belongs here: finding the samples of the force that depend on it. What does not: samples that
are off for a short time, whatever drives (``outliers``).

A smooth course through the samples overshoots beside a corner, and the true one turns anywhere
between two samples. Where the force follows the tip's speed at once, damping and mass make a force
of that, which is another one for each course. It tells of the course, and not of the tissue.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter1d, percentile_filter

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Measurement
from tissue_probe.quantities import FORCE
from tissue_probe.signals import BoolArray, FloatArray

#: The rig whose force follows the tip's speed at once.
AT_ONCE = "rigid_probe"
#: Differences of this order leave noise, and of a motion that is sampled well hardly anything.
ORDER = 6
#: What exceeds the usual difference around by this factor is neither noise, of which one sample in
#: 10^7 does, nor smooth.
STANDS_OUT = 8.0
#: Samples around, of which the usual difference is taken.
AROUND = 151
#: Of a record with more corners than leave this share of it nothing is left out: they are all that
#: it has.
LEFT = 0.5


def without_corners(fit: Fit) -> list[Measurement] | None:
    """Return what was fitted without the samples that tell of the course; None if there are none.

    Those are samples near a corner of the position of which the slopes that a course may have there
    make forces that differ by more than the noise, with the damping and the mass of the fit.
    """
    if fit.composition.rig != AT_ONCE or fit.output is not FORCE:
        return None
    found = [
        each.used & _depends(each, fit.named()) & corners(each.position)
        for each in fit.measurements
    ]
    count = sum(int(each.sum()) for each in found)
    if not 0 < count <= (1.0 - LEFT) * fit.samples:
        return None
    return [
        replace(measurement, used=measurement.used & ~each, noise=0.0)
        if each.any()
        else measurement
        for measurement, each in zip(fit.measurements, found, strict=True)
    ]


def corners(position: FloatArray) -> BoolArray:
    """Return which samples, evenly spaced, are near a corner: as near as it reaches differences."""
    if position.size <= ORDER:
        return np.zeros(position.size, dtype=bool)
    rough = np.abs(np.diff(position, ORDER))
    usual = percentile_filter(rough, 68, AROUND)
    # Beside a motion differences of numbers that are rounded are nothing.
    least = np.finfo(float).eps * 2.0**ORDER * np.abs(position).max(initial=0.0)
    stands_out = np.zeros(position.size, dtype=bool)
    stands_out[ORDER // 2 : -ORDER // 2] = rough > STANDS_OUT * np.maximum(usual, least)
    return maximum_filter1d(stands_out, 2 * ORDER + 1)


def _depends(measurement: Measurement, values: dict[str, float]) -> BoolArray:
    """Return of which samples the course beside them tells more than the noise.

    The slope may be that of the straight line on either side, or of a smooth course.
    """
    from scipy.interpolate import CubicSpline  # long in coming, and seldom needed

    position, period = measurement.position, measurement.sample_period
    smooth = CubicSpline(period * np.arange(position.size), position)(
        period * np.arange(position.size), 1
    )
    straight = np.diff(position) / period
    before = np.concatenate([straight[:1], straight])
    after = np.concatenate([straight, straight[-1:]])
    apart = np.maximum(np.abs(smooth - before), np.abs(smooth - after))
    answer = values.get("damping", 0.0) + values.get("tip_mass", 0.0) / period
    return answer * apart > measurement.noise
