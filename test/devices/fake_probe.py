"""A device that measures, or fails, as the test says; its coil is live while it runs."""

from __future__ import annotations

import math

import numpy as np

from tissue_probe.devices.device import DeviceError, Samples
from tissue_probe.excitation import Excitation


class FakeProbe:
    """Position and force of the last sample of each read are what the test sets.

    Attributes
    ----------
    told : list of float
        Amplitude of each excitation that reached the device [V].
    gain : float
        By how much its commands are larger than told; 1 for a device that obeys.
    """

    sample_period = 5e-4
    samples_per_read = 1
    worst_lateness = 0.25
    force_range = (-math.inf, math.inf)
    description = "fake: true"

    def __init__(self) -> None:
        self.commanded_voltage = 0.0
        self.closed = False
        self.failure: BaseException | None = None
        self.position = 0.0
        self.force = 0.0
        self.gain = 1.0
        self.told: list[float] = []
        self._excitation: Excitation | None = None
        self._taken = 0

    def start(self, excitation: Excitation) -> None:
        # A failure comes at the worst moment: the coil is live, the device not yet running.
        self.told.append(excitation.amplitude)
        self.commanded_voltage = excitation.amplitude
        self._fail()
        self._excitation = excitation
        self._taken = 0

    def read(self, count: int) -> Samples:
        if self._excitation is None:
            raise DeviceError("not started")
        self._fail()
        number = np.arange(self._taken, self._taken + count)
        self._taken += count
        command = self.gain * self._excitation(number * self.sample_period)
        self.commanded_voltage = self.gain * self._excitation.amplitude
        # A nanometre to and fro: an encoder that lives.
        position = 1e-9 * (number % 2.0)
        position[-1] += self.position
        force = np.full(count, self.force)
        return Samples(position, force, command)

    def stop(self) -> None:
        self.commanded_voltage = 0.0
        self._excitation = None

    def close(self) -> None:
        self.stop()
        self.closed = True

    def _fail(self) -> None:
        if self.failure is not None:
            failure, self.failure = self.failure, None
            raise failure
