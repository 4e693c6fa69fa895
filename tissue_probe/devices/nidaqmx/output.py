"""The signal that the DAQ plays on the coil, and how long it plays on without the driver.

Two ways, for a DAQ with a watchdog and for one without. Both are given to the DAQ as samples on
its own clock; neither is paced by this machine.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Protocol

import nidaqmx
import numpy as np
from nidaqmx.constants import AcquisitionType, RegenerationMode
from nidaqmx.stream_writers import AnalogSingleChannelWriter

from tissue_probe.devices.device import DeviceError
from tissue_probe.excitation import Excitation
from tissue_probe.signals import FloatArray

#: Most samples that are regenerated from the DAQ's buffer.
LONGEST_TABLE = 40_000
#: Longest time between two zeros of an excitation that a DAQ without watchdog plays [s].
LONGEST_SWING = 1.0


class TimedOutput(Protocol):
    """A hardware-timed output; sample n is played with sample n of the inputs."""

    def advance(self, taken: int) -> None:
        """Give the DAQ the next samples it needs, now that ``taken`` samples have been read."""

    def commands(self, first: int, count: int) -> FloatArray:
        """Return the voltages of ``count`` samples from number ``first`` [V]."""


def period_in_samples(excitation: Excitation, sample_period: float) -> int | None:
    """Return after how many samples the excitation repeats; None if too late or never."""
    if excitation.period is None:
        return None
    turn = sample_period / excitation.period
    fraction = Fraction(turn).limit_denominator(LONGEST_TABLE)
    return fraction.denominator if math.isclose(turn, fraction, rel_tol=1e-12) else None


class RegeneratedOutput:
    """A periodic excitation that the DAQ plays from its buffer again and again, unaided.

    It would go on for ever after the driver died: only for a DAQ whose watchdog ends it.
    """

    def __init__(
        self, task: nidaqmx.Task, excitation: Excitation, sample_period: float, samples: int
    ) -> None:
        self._table = excitation(np.arange(samples, dtype=float) * sample_period)
        # A DAQ wants at least two samples, some an even number: several periods do no harm.
        data = np.tile(self._table, 2)
        rate = 1.0 / sample_period
        task.timing.cfg_samp_clk_timing(rate, "", sample_mode=AcquisitionType.CONTINUOUS)
        task.out_stream.output_buf_size = data.size
        task.out_stream.regen_mode = RegenerationMode.ALLOW_REGENERATION
        _writer(task).write_many_sample(data)

    def advance(self, taken: int) -> None:
        """Nothing needs to be done."""

    def commands(self, first: int, count: int) -> FloatArray:
        """Return the voltages of ``count`` samples from number ``first`` [V]."""
        return self._table[np.arange(first, first + count) % self._table.size]


class StreamedOutput:
    """Any excitation, fed to the DAQ a little ahead, in portions that each end at a zero.

    When the driver dies the DAQ plays its buffer, stops, and holds the last voltage: that of the
    sample nearest to a zero of the excitation, at most half a step of it.

    Parameters
    ----------
    task : nidaqmx.Task
        With the output channel.
    excitation : Excitation
        The played signal [V].
    sample_period : float
        Time between two samples [s].
    ahead : float
        The DAQ always has samples for this time [s], and up to the next zero.

    Raises
    ------
    DeviceError
        If the excitation stays on one side of zero for longer than ``LONGEST_SWING``.
    """

    def __init__(
        self, task: nidaqmx.Task, excitation: Excitation, sample_period: float, ahead: float
    ) -> None:
        self._excitation = excitation
        self._period = sample_period
        self._ahead = math.ceil(ahead / sample_period)
        self._swing = math.ceil(LONGEST_SWING / sample_period)
        self._written = 0
        task.timing.cfg_samp_clk_timing(
            1.0 / sample_period, "", sample_mode=AcquisitionType.CONTINUOUS
        )
        task.out_stream.output_buf_size = 2 * (self._ahead + self._swing)
        task.out_stream.regen_mode = RegenerationMode.DONT_ALLOW_REGENERATION
        self._writer = _writer(task)
        self.advance(0)

    def advance(self, taken: int) -> None:
        """Write the next portion if the DAQ has less than ``ahead`` left."""
        missing = taken + self._ahead - self._written
        if missing <= 0:
            return
        count = missing + self._swing
        values = self.commands(self._written, count)
        portion = values[: _up_to_zero(values, missing)]
        if portion.size == count:
            raise DeviceError(
                f"the excitation stays on one side of zero for more than {LONGEST_SWING:g} s, and "
                "this DAQ has no watchdog that would end it if the driver died: give frequencies "
                f"of {0.5 / LONGEST_SWING:g} Hz or more"
            )
        self._writer.write_many_sample(portion)
        self._written += portion.size

    def commands(self, first: int, count: int) -> FloatArray:
        """Return the voltages of ``count`` samples from number ``first`` [V]."""
        return self._excitation(np.arange(first, first + count, dtype=float) * self._period)


def _writer(task: nidaqmx.Task) -> AnalogSingleChannelWriter:
    writer = AnalogSingleChannelWriter(task.out_stream, auto_start=False)
    writer.verify_array_shape = False  # it would ask the DAQ for the number of channels each time
    return writer


def _up_to_zero(values: FloatArray, at_least: int) -> int:
    """Return how many values to take, ``at_least`` so many, for the last to be next to a zero.

    All, if there is no zero after that many.
    """
    here, there = values[at_least - 1 : -1], values[at_least:]
    crossings = np.flatnonzero(here * there <= 0.0)
    if not crossings.size:
        return values.size
    before = at_least - 1 + int(crossings[0])
    nearest = before if abs(values[before]) <= abs(values[before + 1]) else before + 1
    return nearest + 1
