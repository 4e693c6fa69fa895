"""The HCTL-2032 quadrature decoder, read byte by byte over digital lines.

The lines of a small DAQ change only when a program asks, so this path is paced by software. It is
therefore measured before it is used, and each reading must be done before the next sample is due.
"""

from __future__ import annotations

import time

import numpy as np
from nidaqmx.stream_readers import DigitalSingleChannelReader
from nidaqmx.stream_writers import DigitalSingleChannelWriter

from tissue_probe.devices.device import DeviceError
from tissue_probe.devices.nidaqmx.connection import Connection
from tissue_probe.devices.nidaqmx.encoder import LoadCell
from tissue_probe.devices.nidaqmx.settings import NiDaqmxSettings
from tissue_probe.signals import FloatArray

#: Bits of the control lines.
OE, SEL1, SEL2 = 1, 2, 4
#: The selection of each byte, the most significant first, with the output enabled (OE low): the
#: first latches the count, OE high releases it (Avago HCTL-2032 data sheet, byte selection).
BYTES = (SEL2, SEL1 | SEL2, 0, SEL1)
#: Readings that are timed before the first use.
TIMED = 50
#: The slowest reading may take so much of a sample period.
SHARE = 0.8


class Hctl2032:
    """The decoder with OE, SEL1 and SEL2 at control lines, D0 to D7 at data lines.

    X/Y low, EN1 high and EN2 low (fourfold count) are wired.

    Attributes
    ----------
    reading_time : float
        Time that the slowest of the timed readings took [s].

    Raises
    ------
    DeviceError
        If the decoder cannot be read once in every sample period.
    """

    name = "hctl2032"

    def __init__(
        self, connection: Connection, settings: NiDaqmxSettings, sample_period: float
    ) -> None:
        self._control_task = connection.task()
        self._control_task.do_channels.add_do_chan(f"{settings.device}/{settings.decoder_control}")
        self._data_task = connection.task()
        self._data_task.di_channels.add_di_chan(f"{settings.device}/{settings.decoder_data}")
        self._control = DigitalSingleChannelWriter(self._control_task.out_stream, auto_start=True)
        self._data = DigitalSingleChannelReader(self._data_task.in_stream)
        self._timeout = settings.timeout
        self._zero = 0
        self.reading_time = max(self.time_reading() for _ in range(TIMED))
        fastest = SHARE / self.reading_time
        if fastest * sample_period < 1.0:
            raise DeviceError(
                f"the HCTL-2032 can be read {fastest:.0f} times a second over these lines, not "
                f"{1.0 / sample_period:g}: give nidaqmx.sample_rate {_rounded_down(fastest):g} or "
                "less, or use a DAQ with a quadrature counter"
            )

    def arm(self) -> None:
        """Call the present count 0."""
        self._zero = self._count()

    def read(self, load_cell: LoadCell, count: int) -> tuple[FloatArray, FloatArray]:
        """Wait for ``count`` samples; return the load cell's volts and the encoder's counts.

        Raises
        ------
        DeviceError
            If the next sample was taken before the decoder was read: the count would be stale.
        """
        volts, counts = np.empty(count), np.empty(count)
        for n in range(count):
            volts[n : n + 1] = load_cell.read(1)
            counts[n] = _signed(self._count() - self._zero)
            if load_cell.waiting:
                raise DeviceError(
                    "the HCTL-2032 was read too late, after the next sample: lower "
                    "nidaqmx.sample_rate, or use a DAQ with a quadrature counter"
                )
        return volts, counts

    def stop(self) -> None:
        """Nothing was started."""

    def close(self) -> None:
        """Let go of the lines."""
        self._control_task.close()
        self._data_task.close()

    def time_reading(self) -> float:
        """Read the decoder once; return how long it took [s]."""
        begin = time.perf_counter()
        self._count()
        return time.perf_counter() - begin

    def _count(self) -> int:
        value = 0
        for selection in BYTES:
            self._control.write_one_sample_port_byte(selection, self._timeout)
            value = value << 8 | self._data.read_one_sample_port_byte(self._timeout)
        self._control.write_one_sample_port_byte(OE, self._timeout)
        return value


def _signed(count: int) -> int:
    """Return a difference of 32-bit counts as a signed number: the counter wraps around."""
    return (count + 2**31) % 2**32 - 2**31


def _rounded_down(rate: float) -> float:
    """Round down to a step that most clocks divide."""
    return max(1.0, rate // 10 * 10)
