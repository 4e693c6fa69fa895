"""The load cell's zero while the driver runs: found in free air, taken off from then on."""

from __future__ import annotations

from collections import deque
from threading import Lock

import numpy as np

from tissue_probe.devices.calibration import Calibration
from tissue_probe.devices.calibration import Tare as TareRecord
from tissue_probe.devices.device import Samples
from tissue_probe.identification.free_air import Refused, free_air_zero
from tissue_probe.signals import NANOSECONDS, FloatArray

#: So much of the latest samples tells contact from free air [s].
WINDOW = 1.0


class RunningTare:
    """Takes the tare off the force, and finds it anew when asked.

    ``apply`` may run in one thread and ``take`` in another.

    Attributes
    ----------
    calibration : Calibration
        The instrument's, with every tare since it was loaded.
    """

    def __init__(self, calibration: Calibration) -> None:
        self.calibration = calibration
        self._force = 0.0
        self._lock = Lock()
        self._running = False

    def begin(self, start: int, sample_period: float) -> None:
        """Begin with sample 0, stamped ``start`` [ns], at an activation."""
        with self._lock:
            self._start, self._period = start, sample_period
            self._count = 0
            self._recent: deque[Samples] = deque()
            self._recent_count = 0
            self._running = True

    def end(self) -> None:
        """No more samples come until ``begin``."""
        with self._lock:
            self._running = False

    def apply(self, samples: Samples) -> Samples:
        """Return the next samples with the tare taken off the force."""
        with self._lock:
            self._remember(samples)
            if self._force == 0.0:
                return samples
            return Samples(samples.position, samples.force - self._force, samples.command)

    def take(self) -> float:
        """Make the load cell's present reading its zero; return it [N].

        Raises
        ------
        Refused
            If no samples come, the probe is in contact, or that cannot be told.
        """
        position, force = self._latest()
        tool = self.calibration.tip_mass, self.calibration.load_cell_stiffness
        zero = free_air_zero(position, force, self._period, *tool)
        with self._lock:
            self._force = zero
            stamp = self._start + round(self._count * self._period * NANOSECONDS)
            record = TareRecord(stamp=stamp, force=zero)
            self.calibration = self.calibration.changed(tares=(*self.calibration.tares, record))
        return zero

    def _latest(self) -> tuple[FloatArray, FloatArray]:
        """Return position and untared force of the window; the fit must not hold up samples."""
        with self._lock:
            if not self._running:
                raise Refused("no samples come: activate the driver, in free air, then tare")
            if self._recent_count * self._period < 0.9 * WINDOW:
                raise Refused(f"the samples began less than {WINDOW:g} s ago: tare again")
            recent = list(self._recent)
        position = np.concatenate([samples.position for samples in recent])
        return position, np.concatenate([samples.force for samples in recent])

    def _remember(self, samples: Samples) -> None:
        self._count += samples.position.size
        self._recent.append(samples)
        self._recent_count += samples.position.size
        while self._recent_count - self._recent[0].position.size >= WINDOW / self._period:
            self._recent_count -= self._recent.popleft().position.size
