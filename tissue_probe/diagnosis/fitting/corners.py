"""Where the course of a position between its samples is not known: at corners, and at jumps.

Contents: finding the samples of the force that depend on it.

A smooth course through the samples overshoots beside a corner, and the true course turns anywhere
between two samples. Where the force follows the tip's speed at once, damping and mass turn each of
these courses into another force. Such a sample of the force tells of the course, and not of the
tissue.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d, percentile_filter

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.rigs import Rig
from tissue_probe.quantities import FORCE
from tissue_probe.signals import BoolArray, FloatArray

#: Order of the differences that show a corner. A motion with 16 samples a period leaves them
#: 1/283 of its amplitude, white noise 30 times its deviation, a corner 6 times its change of step.
CORNER_ORDER = 6
#: A difference is at a corner where it exceeds the usual one around by this factor: one difference
#: of white noise in 10^15 does.
CORNER_STANDS_OUT = 8.0
#: Samples around, of which the usual difference is taken: enough to tell it to a twelfth, and few
#: beside a protocol's stretch between two corners.
AROUND = 151
#: Of a record with more corners than leave this share of it nothing is left out: it has little
#: else.
RECORD_LEFT = 0.5
#: Share of a slope by which it may be off, and still is known: between motion and rest the straight
#: lines on either side of a corner are farther from their mean than that.
KNOWN = 0.5


def without_corners(fit: Fit) -> list[Measurement] | None:
    """Return the measurements of a fit without samples near corners; None if none are left out.

    Those are left out whose force depends on the course of the position between its samples: the
    slopes that it may have at a corner make forces that differ by more than the noise, with the
    damping and the mass of the fit. Samples at which the slope itself is not known are left out,
    too: a motion may be over between two samples, and a smooth course still moves after the second
    one. There the force would tell that nothing damps.
    """
    near = [each.used & corners_that_count(each, fit.composition.rig) for each in fit.measurements]
    if not any(map(np.any, near)):
        return None
    pairs = zip(fit.measurements, near, strict=True)
    return fit.without(
        [some & _depends(each, fit.named()) for each, some in pairs], 1.0 - RECORD_LEFT
    )


def corners_that_count(measurement: Measurement, rig: Rig) -> BoolArray:
    """Return which samples are near a corner of the position; none where it does not count.

    It counts on a rig whose force follows the tip's speed at once.
    """
    if not rig.tip_is_position or measurement.output is not FORCE:
        return np.zeros(measurement.position.size, dtype=bool)
    found = corners(measurement.on_grid(measurement.position))
    if measurement.at is None:
        return found
    return found[np.rint(measurement.at / measurement.sample_period).astype(np.int64)]


def corners(position: FloatArray) -> BoolArray:
    """Return which samples, evenly spaced, are near a corner: as near as it reaches differences."""
    if position.size <= CORNER_ORDER:
        return np.zeros(position.size, dtype=bool)
    rough = np.abs(np.diff(position, CORNER_ORDER))
    usual = percentile_filter(rough, 68, AROUND)
    # Beside a motion differences of numbers that are rounded are nothing.
    least = np.finfo(float).eps * 2.0**CORNER_ORDER * np.abs(position).max(initial=0.0)
    stands_out = np.zeros(position.size, dtype=bool)
    stands_out[CORNER_ORDER // 2 : -CORNER_ORDER // 2] = rough > CORNER_STANDS_OUT * np.maximum(
        usual, least
    )
    found: BoolArray = maximum_filter1d(stands_out, 2 * CORNER_ORDER + 1)
    return found


def _depends(measurement: Measurement, values: dict[str, float]) -> BoolArray:
    """Return the samples whose force depends on the course beside them by more than the noise.

    The slope of the course may be that of the straight line on either side, or of a smooth course.
    It is not known where these differ by more than half of the smooth one. The slope of a noisy
    position is uncertain everywhere, and that counts as noise already.
    """
    from scipy.interpolate import CubicSpline  # long in coming, and seldom needed

    position, times = measurement.position, measurement.times
    smooth = CubicSpline(times, position)(times, 1)
    straight = np.diff(position) / np.diff(times)
    before = np.concatenate([[0.0 if measurement.at_rest else straight[0]], straight])
    after = np.concatenate([straight, straight[-1:]])
    apart = np.maximum(np.abs(smooth - before), np.abs(smooth - after))
    answer = values.get("damping", 0.0) + values.get("tip_mass", 0.0) / measurement.sample_period
    unknown = (apart > KNOWN * np.abs(smooth)) & (measurement.motion is None)
    found: BoolArray = (answer * apart > np.sqrt(measurement.noise.power)) | unknown
    return found
