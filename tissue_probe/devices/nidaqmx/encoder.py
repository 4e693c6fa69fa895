"""Where the encoder's counts come from."""

from __future__ import annotations

from typing import Protocol

import nidaqmx
import numpy as np
from nidaqmx.constants import AcquisitionType, EncoderType, LengthUnits, UsageTypeCI
from nidaqmx.stream_readers import AnalogSingleChannelReader, CounterReader

from tissue_probe.devices.device import DeviceError
from tissue_probe.devices.nidaqmx.connection import Connection
from tissue_probe.devices.nidaqmx.settings import NiDaqmxSettings
from tissue_probe.excitation import Excitation
from tissue_probe.signals import FloatArray

#: Samples wait this long in this machine's buffer to be fetched before they are lost [s].
DAQ_BUFFER_TIME = 10.0
#: Once in so many fetches it is asked how many samples wait.
FETCHES_PER_LOOK = 10


class LoadCell:
    """The clocked analog input, whose samples pace everything else."""

    def __init__(self, task: nidaqmx.Task, timeout: float) -> None:
        self._reader = AnalogSingleChannelReader(task.in_stream)
        self._reader.verify_array_shape = False
        self._stream = task.in_stream
        self._timeout = timeout

    @property
    def waiting(self) -> int:
        """How many samples wait to be fetched."""
        count: int = self._stream.avail_samp_per_chan
        return count

    def read(self, count: int) -> FloatArray:
        """Wait for ``count`` samples [V]."""
        volts = np.empty(count)
        self._reader.read_many_sample(volts, count, self._timeout)
        return volts


class Encoder(Protocol):
    """A source of counts, one for each sample of the load cell."""

    name: str

    def arm(self, excitation: Excitation) -> None:
        """Make ready to count from 0, before the load cell starts and the excitation with it."""

    def read(self, load_cell: LoadCell, count: int) -> tuple[FloatArray, FloatArray]:
        """Wait for ``count`` samples; return the load cell's volts and the encoder's counts."""

    def stop(self) -> None:
        """End an armed task."""

    def close(self) -> None:
        """Let go of counter or lines."""


class CounterEncoder:
    """The DAQ's quadrature counter, latched by the load cell's own sample clock.

    Raises
    ------
    DeviceError
        If the DAQ has no counter that decodes quadrature.
    """

    name = "counter"

    def __init__(
        self, connection: Connection, settings: NiDaqmxSettings, sample_period: float
    ) -> None:
        supported = connection.device(settings.device).ci_meas_types
        if UsageTypeCI.POSITION_LINEAR_ENCODER not in supported:
            raise DeviceError(
                f"{settings.device} has no quadrature counter: wire the encoder to an HCTL-2032 "
                "and give nidaqmx.encoder:=hctl2032, or use a DAQ that has one"
            )
        self._task = connection.task()
        self._task.ci_channels.add_ci_lin_encoder_chan(
            f"{settings.device}/{settings.counter}",
            decoding_type=EncoderType.X_4,
            units=LengthUnits.TICKS,
            dist_per_pulse=1.0,
        )
        rate = 1.0 / sample_period
        self._task.timing.cfg_samp_clk_timing(
            rate,
            f"/{settings.device}/ai/SampleClock",
            sample_mode=AcquisitionType.CONTINUOUS,
            samps_per_chan=round(DAQ_BUFFER_TIME * rate),
        )
        self._reader = CounterReader(self._task.in_stream)
        self._reader.verify_array_shape = False
        self._timeout = settings.timeout

    def arm(self, excitation: Excitation) -> None:
        """Start the counter; it waits for the load cell's clock."""
        self._fetched = np.empty((2, 0))
        self._fetches = 0
        self._task.start()

    def read(self, load_cell: LoadCell, count: int) -> tuple[FloatArray, FloatArray]:
        """Wait for ``count`` samples; return the load cell's volts and the encoder's counts."""
        missing = count - self._fetched.shape[1]
        if missing > 0:
            self._fetch(load_cell, missing)
        (volts, counts), self._fetched = self._fetched[:, :count], self._fetched[:, count:]
        return volts, counts

    def _fetch(self, load_cell: LoadCell, count: int) -> None:
        """Fetch ``count`` samples, now and then all that wait: many cost little more than few.

        So a driver that fell behind catches up.
        """
        if self._fetches % FETCHES_PER_LOOK == FETCHES_PER_LOOK - 1:
            count = max(count, load_cell.waiting)
        self._fetches += 1
        more = np.empty((2, count))
        more[0] = load_cell.read(count)
        self._reader.read_many_sample_double(more[1], count, self._timeout)
        self._fetched = np.concatenate([self._fetched, more], axis=1)

    def stop(self) -> None:
        """Stop the counter."""
        self._task.stop()

    def close(self) -> None:
        """Let go of the counter."""
        self._task.close()
