"""The guard between every command and every device: limits, and zero after any failure."""

from __future__ import annotations

import time

from tissue_probe.devices.device import Device, DeviceError, Samples
from tissue_probe.devices.interlock import Interlock
from tissue_probe.devices.limits import LimitMonitor, Limits
from tissue_probe.devices.watchdog import Watchdog
from tissue_probe.excitation import Excitation


class Tripped(DeviceError):
    """The interlock is tripped: the coil stays at zero until it is reset."""


class GuardedDevice:
    """A device within its limits: at any fault the coil is at zero before anyone hears.

    A failure while it runs trips the interlock; it does not start again before that is reset. It
    is itself a ``Device``; ``trip`` and ``stop`` may come from any thread at any time.

    Parameters
    ----------
    device : Device
        The guarded device.
    limits : Limits
        Its limits.
    current_per_volt : float
        Coil current for each volt of the command, for a coil at rest [A/V].
    interlock : Interlock
        The interlock that a failure trips.

    Attributes
    ----------
    started : int
        When the device began to sample [ns of the monotonic clock].
    """

    def __init__(
        self, device: Device, limits: Limits, current_per_volt: float, interlock: Interlock
    ) -> None:
        self._device = device
        self._monitor = LimitMonitor(
            limits, device.sample_period, current_per_volt, device.force_range
        )
        self._interlock = interlock
        self._watchdog = Watchdog(self._trip_as_stale)
        self._running = False
        self.started = 0

    def change_limits(self, limits: Limits) -> None:
        """Guard by other limits, from the next read on; an excitation above them trips."""
        self._monitor.limits = limits

    @property
    def sample_period(self) -> float:
        """Time between two samples [s]."""
        return self._device.sample_period

    @property
    def samples_per_read(self) -> int:
        """How many samples the device likes to hand over at once."""
        return self._device.samples_per_read

    @property
    def force_range(self) -> tuple[float, float]:
        """Smallest and largest force that can be measured [N]."""
        return self._device.force_range

    @property
    def commanded_voltage(self) -> float:
        """Voltage that the coil is told now [V]."""
        return self._device.commanded_voltage

    @property
    def description(self) -> str:
        """The device's description, in YAML."""
        return self._device.description

    @property
    def worst_lateness(self) -> float:
        """Longest delay between a sample and its being fetched since last asked [s]."""
        return self._device.worst_lateness

    def start(self, excitation: Excitation) -> None:
        """Begin to sample with the excitation on the coil.

        Raises
        ------
        Tripped
            If the interlock is tripped, also while it starts.
        LimitExceeded
            If the excitation would pass a limit; nothing is started then, and an earlier one is
            stopped.
        """
        self.stop()
        self._refuse_if_tripped()
        self._monitor.judge_excitation(excitation)
        try:
            self._monitor.begin()
            self._device.start(excitation)
            self.started = time.monotonic_ns()  # before the watchdog's thread takes its time
            self._running = True
            self._watchdog.start(self._monitor.limits.stale_limit)
            self._refuse_if_tripped()
        except BaseException:
            self.stop()
            raise

    def read(self, count: int) -> Samples:
        """Read ``count`` samples.

        Raises
        ------
        Tripped
            If the interlock was tripped meanwhile.
        LimitExceeded
            If a sample passed a limit; it brings the samples.
        DeviceError
            If the device is not running, or failed.
        """
        if not self._running:
            self._refuse_if_tripped()
            raise DeviceError("the device is not sampling: start it before you read")
        self._watchdog.expect_within(self._monitor.limits.stale_limit + count * self.sample_period)
        try:
            samples = self._device.read(count)
            self._refuse_if_tripped()
            self._monitor.judge(samples)
        except BaseException as error:
            if not self._running:
                self._refuse_if_tripped()  # the error is the consequence of a trip
            else:
                self.trip(str(error) or type(error).__name__)
            raise
        self._watchdog.expect_within(self._monitor.limits.stale_limit)
        return samples

    def trip(self, reason: str) -> None:
        """Put the coil at zero, and keep it there until the interlock is reset."""
        self._interlock.trip(reason)
        self.stop()

    def stop(self) -> None:
        """Put the coil at zero volts and end sampling; trips if that cannot be done."""
        self._running = False
        self._watchdog.stop()
        try:
            self._device.stop()
        except DeviceError as error:
            self._interlock.trip(str(error))

    def close(self) -> None:
        """Stop, and let go of the hardware."""
        self.stop()
        self._device.close()

    def _trip_as_stale(self) -> None:
        self.trip(
            f"no sample came for {self._monitor.limits.stale_limit:g} s: the coil is at zero; the "
            "device or this machine stalled"
        )

    def _refuse_if_tripped(self) -> None:
        if self._interlock.tripped:
            raise Tripped(self._interlock.reason)
