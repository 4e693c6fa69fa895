"""The DAQ's own watchdog, which puts the coil at zero when the driver no longer speaks."""

from __future__ import annotations

from collections.abc import Callable

from nidaqmx.constants import WatchdogAOExpirState
from nidaqmx.errors import DaqError
from nidaqmx.system.watchdog import WatchdogTask
from nidaqmx.types import AOExpirationState

from tissue_probe.devices.nidaqmx.connection import Connection
from tissue_probe.devices.nidaqmx.settings import NiDaqmxSettings


class HardwareWatchdog:
    """A watchdog that is fed with every few reads."""

    def __init__(self, task: WatchdogTask, expiry: float, clock: Callable[[], float]) -> None:
        self._task = task
        self._clock = clock
        self._interval = expiry / 4.0
        self._fed = 0.0

    def start(self) -> None:
        """Begin to watch; before other tasks are started, as some chassis demand."""
        self._task.start()
        self._fed = self._clock()

    def feed(self) -> None:
        """Say that the driver lives; sent only as often as it is of use."""
        if self._clock() - self._fed >= self._interval:
            self._task.reset_timer()
            self._fed = self._clock()

    def stop(self) -> None:
        """Cease to watch; unlocks the output if the watchdog expired."""
        if self._task.expired:
            self._task.clear_expiration()
        self._task.stop()

    def close(self) -> None:
        """Let go of the watchdog."""
        self._task.close()


def find_watchdog(connection: Connection, settings: NiDaqmxSettings) -> HardwareWatchdog | None:
    """Return the DAQ's watchdog, set to put the coil at 0 V; None if it has none for outputs.

    No attribute of NI-DAQmx tells: the DAQ refuses the task if it cannot do it.
    """
    channel = f"{settings.device}/{settings.coil_channel}"
    zero = AOExpirationState(channel, 0.0, WatchdogAOExpirState.VOLTAGE)
    try:
        task = connection.watchdog(settings.device, settings.expiry)
    except DaqError:
        return None
    try:
        task.cfg_watchdog_ao_expir_states([zero])
    except DaqError:
        task.close()
        return None
    return HardwareWatchdog(task, settings.expiry, connection.clock)
