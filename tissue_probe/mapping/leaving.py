"""When a dwell has told enough: the probe may leave before its longest time is over.

Contents: the test, fed with the samples and estimates of one dwell.

A filter's variance is of white noise alone. Its other errors, of which those of the tip's unknown
motion at the start are the largest, recur with the drive and fade: they show as a course of the
estimate over the time of late. So the probe stays until

- one period of the motion is seen, since before that an error cannot be told from the tissue;
- the filters' tests of their model have had their time;
- each filter that is heard in the dwell has of late called its value converged, and none has
  rejected its model or was disturbed since the dwell began;
- two standard deviations of the stiffness are below 1 %, where to each filter's variance is added
  the mean square of its deviations from its newest value over the last period (or the last half of
  the dwell, if that is less), and to all the spread between the filters.
"""

from __future__ import annotations

import math

import numpy as np

from tissue_probe.mapping.fusion import Estimate, fuse_stddev, inverse_variance_weights
from tissue_probe.signals import NANOSECONDS, FloatArray, SampleBlock, Status

#: Two standard deviations relative to the stiffness.
EXACT_STIFFNESS = 0.01
#: A motion has turned when it has come back by a tenth of its extent: less is a sensor's noise.
_TURNED = 0.1
#: A filter that was silent for longer has not spoken of late [ns]: ten blocks of samples.
_LATE = 50_000_000


class DwellEvidence:
    """What was heard in one dwell, and whether that is enough.

    Parameters
    ----------
    begin : int
        When the dwell begins [ns since the epoch].
    test_time : float
        In which a filter's test finds a wrong model, from the dwell's begin on [s].
    """

    def __init__(self, begin: int, test_time: float) -> None:
        self._begin, self._test = begin, round(test_time * NANOSECONDS)
        self._position: list[FloatArray] = []
        self._period: int | None = None
        self._found: dict[str, list[tuple[int, Estimate]]] = {}
        self._doubted = False

    def add_samples(self, block: SampleBlock) -> None:
        """Take the next samples, those that are in the dwell."""
        if self._period is not None:
            return
        step = block.sample_period * NANOSECONDS
        first = max(0, math.ceil((self._begin - block.stamp) / step))
        if first < len(block):
            self._position.append(block.position[first:])
            count = period(np.concatenate(self._position))
            self._period = None if count is None else round(count * step)

    def add_estimate(self, estimator: str, status: int, estimate: Estimate) -> None:
        """Take an estimate; left out are those from before the dwell, and of unknown samples."""
        if estimate.stamp < self._begin or not math.isfinite(estimate.innovation):
            return
        self._doubted |= status in (Status.MODEL_REJECTED, Status.DISTURBED)
        self._found.setdefault(estimator, []).append((status, estimate))

    def enough(self) -> int | None:
        """Return the first time that was not needed any more [ns since the epoch], or None."""
        if self._period is None or not self._found or self._doubted:
            return None
        newest = max(found[-1][1].stamp for found in self._found.values())
        elapsed = newest - self._begin
        if elapsed < max(self._period, self._test):
            return None
        late = newest - min(self._period, elapsed // 2)
        values, variances = [], []
        for found in self._found.values():
            status, last = found[-1]
            if status != Status.CONVERGED or last.stamp < newest - _LATE or not last.has_weight():
                return None
            course = np.array([each.stiffness for _, each in found if each.stamp >= late])
            values.append(last.stiffness)
            variances.append(
                last.stiffness_variance + float(((course - last.stiffness) ** 2).mean())
            )
        value, variance = np.array(values), np.array(variances)
        weights = inverse_variance_weights(variance)
        error = fuse_stddev(weights, value, variance)
        return newest + 1 if 2.0 * error <= EXACT_STIFFNESS * abs(float(weights @ value)) else None


def period(position: FloatArray) -> int | None:
    """Return after how many samples a motion has gone through its first period; None if it has not.

    It has when it has turned twice and passes where it began, whatever its phase was; one that
    began just before a turn has then gone up to a quarter farther.
    """
    known = position[np.isfinite(position)]
    if known.size < 4:
        return None
    threshold = _TURNED * float(np.ptp(known))
    start = extreme = float(known[0])
    direction, turns = 0.0, 0
    for count, value in enumerate(known.tolist(), start=1):
        if direction == 0.0:
            if abs(value - start) > threshold:
                direction, extreme = math.copysign(1.0, value - start), value
        elif direction * (value - extreme) >= 0.0:
            extreme = value
        elif direction * (extreme - value) > threshold:
            direction, extreme, turns = -direction, value, turns + 1
        if turns >= 2 and direction * (value - start) >= 0.0:
            return count
    return None
