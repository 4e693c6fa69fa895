"""The hardware: one sample clock, the converters, the counter, the watchdog, and the probe.

It is computed when someone looks, up to the moment of the look; no thread of its own is needed.
Voltages and counts are what a converter of 16 bits and an encoder give.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable

import numpy as np
from nidaqmx.error_codes import DAQmxErrors as Code

from daq_server.faults import DaqmxError, Faults
from daq_server.hctl2032 import Chip
from daq_server.models import Model
from daq_server.plant import Plant
from tissue_probe.devices.calibration import Calibration

RANGE = 10.0
STEP = 2.0 * RANGE / 2**16


class Generation:
    """Samples on their way to the output converter."""

    def __init__(self, size: int, regenerates: bool) -> None:
        self.size = size
        self.regenerates = regenerates
        self.data = np.empty(0)
        self.played = 0
        self.ran_dry = False

    @property
    def space(self) -> int:
        """How many samples can be written now."""
        return self.size - (self.data.size if self.regenerates else self.data.size - self.played)

    def next(self) -> float | None:
        """Return the next voltage; None if there is none."""
        if self.regenerates:
            value = self.data[self.played % self.data.size]
        elif self.played < self.data.size:
            value = self.data[self.played]
        else:
            self.ran_dry = True
            return None
        self.played += 1
        return float(value)


class Acquisition:
    """Samples between a converter or counter and who fetches them."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._values: list[float] = []
        self.overwritten = False

    def __len__(self) -> int:
        return len(self._values)

    def put(self, value: float) -> None:
        """Add a sample; once the buffer is full, the acquisition ends."""
        self.overwritten = self.overwritten or len(self._values) >= self._size
        if not self.overwritten:
            self._values.append(value)

    def take(self, count: int) -> list[float]:
        """Fetch up to ``count`` samples."""
        taken, self._values = self._values[:count], self._values[count:]
        return taken


class Board:
    """A DAQ with the probe wired to it. All its methods want ``lock`` held.

    Parameters
    ----------
    model : Model
        What it can do.
    calibration : Calibration
        How the probe's force and position become volts and counts.
    stiffness, damping : float
        Of the tissue under the tip [N/m], [N s/m].
    force_noise : float
        Standard deviation of the load cell's noise [N].
    skew : int
        How many samples the force comes after the position; before it, where negative.
    clock : callable
        The time [s].
    wait : callable, optional
        Lets a time pass [s]; by default with the lock released, as long as it takes.
    """

    def __init__(
        self,
        model: Model,
        calibration: Calibration,
        stiffness: float = 450.0,
        damping: float = 5.0,
        force_noise: float = 0.005,
        skew: int = 0,
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], object] | None = None,
    ) -> None:
        self.model = model
        self.faults = Faults()
        self.lock = threading.Condition()
        self.chip = Chip()
        self.coil_voltage = 0.0
        self.largest_voltage = 0.0
        self._calibration = calibration
        self._tissue = stiffness, damping
        self._noise = np.random.default_rng(0), force_noise
        self._clock = clock
        self.wait = wait or self.lock.wait
        self._count = 0
        self._late_force = deque([0.0] * max(0, skew), maxlen=max(0, skew) + 1)
        self._late_position = deque([0.0] * max(0, -skew), maxlen=max(0, -skew) + 1)
        self.reset()

    def reset(self) -> None:
        """Abort everything; outputs go to zero."""
        self.generation: Generation | None = None
        self.acquisition: Acquisition | None = None
        self.counter: Acquisition | None = None
        self.expiry = math.inf
        self.expired = False
        self.coil_voltage = 0.0
        self._running = False

    def begin(self, rate: float, acquisition: Acquisition) -> None:
        """Start the input's sample clock: the first sample is taken now."""
        self.acquisition = acquisition
        self._period = 1.0 / rate
        self._start = self._clock()
        self._taken = 0
        self._plant = Plant(self._period, *self._tissue)
        self._running = True

    def time_of(self, more: int) -> float:
        """Return in how long the next ``more`` samples will have been taken [s]."""
        return self._start + (self._taken + more - 1) * self._period - self._clock()

    def catch_up(self) -> None:
        """Let everything happen that has happened by now."""
        if not self._running:
            self._look_at_watchdog(self._clock())
            return
        due = math.floor((self._clock() - self._start) / self._period * (1.0 + 1e-12)) + 1
        for number in range(self._taken, due):
            self._look_at_watchdog(self._start + number * self._period)
            self._tick()
        self._taken = max(self._taken, due)

    def put_out(self, voltage: float) -> None:
        """Set the coil's voltage now."""
        if self.expired:
            raise DaqmxError(Code.WRITE_FAILED_BECAUSE_WATCHDOG_EXPIRED)
        self.coil_voltage = voltage
        self.largest_voltage = max(self.largest_voltage, abs(voltage))

    def feed(self, timeout: float) -> None:
        """Start the watchdog's timer anew."""
        self.expiry = self._clock() + timeout

    def take_time(self, seconds: float) -> None:
        """Be busy for a time; everything else goes on meanwhile."""
        end = self._clock() + seconds
        while (left := end - self._clock()) > 0.0:
            self.wait(left)

    @property
    def count(self) -> int:
        """What the encoder stands at."""
        return self._count

    def _tick(self) -> None:
        if self.faults.gone is not None:
            self.generation, self.coil_voltage = None, 0.0
        if self.generation is not None and not self.expired:
            voltage = self.generation.next()
            if voltage is not None:
                self.put_out(voltage)
        position, force = self._plant.step(self.coil_voltage)
        self._late_position.append(position)
        self._late_force.append(force)
        position, force = self._late_position[0], self._late_force[0]
        if not self.faults.stuck:
            self._count = round(float(self._calibration.counts(position)))
        if self.acquisition is None:
            return  # without the input there is no sample clock
        self.acquisition.put(self._volts(force))
        if self.counter is not None:
            self.counter.put(float(self._count))

    def _volts(self, force: float) -> float:
        if self.faults.saturated:
            return RANGE - STEP
        generator, deviation = self._noise
        volts = float(self._calibration.volts(force + deviation * generator.standard_normal()))
        return min(max(round(volts / STEP) * STEP, -RANGE), RANGE - STEP)

    def _look_at_watchdog(self, now: float) -> None:
        if now >= self.expiry:
            self.expired, self.expiry = True, math.inf
            self.coil_voltage = 0.0
