"""What can be made to go wrong, and how NI-DAQmx tells it."""

from __future__ import annotations

from nidaqmx.error_codes import DAQmxErrors

_WORDS = {
    DAQmxErrors.SAMPLES_NO_LONGER_AVAILABLE: "The application is not able to keep up with the "
    "hardware acquisition.",
    DAQmxErrors.DEV_CANNOT_BE_ACCESSED: "Device cannot be accessed.",
    DAQmxErrors.DRIVER_DEVICE_GUID_NOT_FOUND_ROUTING: "The specified device is not present or is "
    "not active in the system.",
}


class DaqmxError(Exception):
    """An error as NI-DAQmx returns it: a code, its words, and how many samples were moved."""

    def __init__(self, code: DAQmxErrors, samples: int = 0) -> None:
        self.code = int(code)
        self.samples = samples
        super().__init__(f"{words(self.code)}\n\nStatus Code: {self.code}")


def words(code: int) -> str:
    """Return a description of an error."""
    error = DAQmxErrors(code)
    return _WORDS.get(error, error.name.replace("_", " ").capitalize() + ".")


class Faults:
    """Switches; every one is off at first.

    Attributes
    ----------
    gone : DAQmxErrors or None
        The DAQ is unplugged: each request ends in this error, and the coil is without current.
    overrun : bool
        The input's buffer was overwritten before it was fetched.
    saturated : bool
        The load cell's amplifier is at the end of its range.
    stuck : bool
        The encoder's signals no longer change.
    stalled : bool
        Reads wait for ever.
    """

    def __init__(self) -> None:
        self.gone: DAQmxErrors | None = None
        self.overrun = False
        self.saturated = False
        self.stuck = False
        self.stalled = False

    def clear(self) -> None:
        """Mend all."""
        self.__init__()
