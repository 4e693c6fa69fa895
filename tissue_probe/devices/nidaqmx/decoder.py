"""The HCTL-2032 quadrature decoder, read byte by byte over digital lines.

The lines of a small DAQ change only when a program asks, so this path is paced by software. It is
therefore measured before it is used. Two ways of using it: a reading for every sample, or as many
readings as there can be, and between them a position that is interpolated.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from statistics import median

import numpy as np
from nidaqmx.stream_readers import DigitalSingleChannelReader
from nidaqmx.stream_writers import DigitalSingleChannelWriter

from tissue_probe.devices.device import DeviceError
from tissue_probe.devices.nidaqmx.connection import Connection
from tissue_probe.devices.nidaqmx.encoder import LoadCell
from tissue_probe.devices.nidaqmx.settings import NiDaqmxSettings
from tissue_probe.excitation import Excitation
from tissue_probe.signals import FloatArray

#: Bits of the control lines.
OE, SEL1, SEL2 = 1, 2, 4
#: The selection of each byte, the most significant first, with the output enabled (OE low): the
#: first latches the count, OE high releases it (Avago HCTL-2032 data sheet, byte selection).
BYTE_SELECTIONS = (SEL2, SEL1 | SEL2, 0, SEL1)
#: Readings that are timed before the first use.
TIMED = 50
#: The slowest reading may take so much of a sample period.
READING_SHARE = 0.8
#: So many readings in each period of the fastest sine leave an interpolated position right to 1 %.
READINGS_A_PERIOD = 8
#: A reading that latched within a longer time than this is left out: who knows when [s].
LONGEST_LATCH = 0.005
#: So many readings tell when samples are taken: those of some ten seconds.
READINGS_REMEMBERED = 400


class Chip:
    """The decoder with OE, SEL1 and SEL2 at control lines, D0 to D7 at data lines.

    X/Y low, EN1 high and EN2 low (fourfold count) are wired.
    """

    def __init__(self, connection: Connection, settings: NiDaqmxSettings) -> None:
        self._control_task = connection.task()
        self._control_task.do_channels.add_do_chan(f"{settings.device}/{settings.decoder_control}")
        self._data_task = connection.task()
        self._data_task.di_channels.add_di_chan(f"{settings.device}/{settings.decoder_data}")
        self._control = DigitalSingleChannelWriter(self._control_task.out_stream, auto_start=True)
        self._data = DigitalSingleChannelReader(self._data_task.in_stream)
        self._timeout = settings.timeout
        self._clock = connection.clock

    def latch(self) -> None:
        """Hold the count of this instant until it is read."""
        self._select(BYTE_SELECTIONS[0])

    def read_latched(self) -> int:
        """Read the count that is held, 0 to 2^32 - 1, and let go of it."""
        value = self._byte()
        for selection in BYTE_SELECTIONS[1:]:
            self._select(selection)
            value = value << 8 | self._byte()
        self._select(OE)
        return value

    def count(self) -> int:
        """Read the present count."""
        self.latch()
        return self.read_latched()

    def time_reading(self) -> float:
        """Read once; return how long it took [s]."""
        begin = self._clock()
        self.count()
        return self._clock() - begin

    def time_readings(self) -> list[float]:
        """Read some times; return how long each took [s], the slowest last."""
        return sorted(self.time_reading() for _ in range(TIMED))

    def close(self) -> None:
        """Let go of the lines."""
        self._control_task.close()
        self._data_task.close()

    def _select(self, lines: int) -> None:
        self._control.write_one_sample_port_byte(lines, self._timeout)

    def _byte(self) -> int:
        return int(self._data.read_one_sample_port_byte(self._timeout))


class Hctl2032:
    """A reading for every sample.

    Raises
    ------
    DeviceError
        If the decoder cannot be read once in every sample period.
    """

    name = "hctl2032"

    def __init__(
        self, connection: Connection, settings: NiDaqmxSettings, sample_period: float
    ) -> None:
        self._chip = Chip(connection, settings)
        fastest = READING_SHARE / self._chip.time_readings()[-1]
        if fastest * sample_period < 1.0:
            raise DeviceError(
                f"the HCTL-2032 can be read {fastest:.0f} times a second over these lines, not "
                f"{1.0 / sample_period:g}: give nidaqmx.sample_rate {_rounded_down(fastest):g} or "
                "less, or nidaqmx.encoder:=hctl2032_interpolated for a slow excitation, or use a "
                "DAQ with a quadrature counter"
            )

    def arm(self, excitation: Excitation) -> None:
        """Call the present count 0."""
        self._zero = self._chip.count()

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
            counts[n] = _sign_count(self._chip.count() - self._zero)
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
        self._chip.close()


class InterpolatedHctl2032:
    """As many readings as there can be, placed in time, and a cubic through four between them.

    So force and coil keep the DAQ's own rate, while samples come two readings late, and only an
    excitation is accepted that is slow beside the readings.
    """

    name = "hctl2032_interpolated"

    def __init__(
        self, connection: Connection, settings: NiDaqmxSettings, sample_period: float
    ) -> None:
        self._chip = Chip(connection, settings)
        self._now = connection.clock
        self._period = sample_period
        self._reading_time = median(self._chip.time_readings())

    def arm(self, excitation: Excitation) -> None:
        """Call the present count 0; the coil rests until the load cell starts.

        Raises
        ------
        DeviceError
            If the excitation is too fast to be followed by the decoder.
        """
        longest = 1.0 / (READINGS_A_PERIOD * excitation.highest_frequency)
        if self._reading_time > longest:
            fastest = 1.0 / (READINGS_A_PERIOD * self._reading_time)
            raise DeviceError(
                f"the HCTL-2032 can be read {1.0 / self._reading_time:.0f} times a second over "
                f"these lines, too seldom for {excitation.highest_frequency:g} Hz: drive the coil "
                f"at {_two_digits_of(fastest):g} Hz or slower, or use a DAQ with a quadrature "
                "counter"
            )
        self._longest = longest / self._period
        self._zero = self._chip.count()
        before = 0.25 * self._longest
        self._knots = deque([(-2.0 * before, 0.0), (-before, 0.0)], maxlen=4)
        self._clock = SampleClock(self._period)
        self._fetched = 0
        self._ready = np.empty((2, 0))

    def read(self, load_cell: LoadCell, count: int) -> tuple[FloatArray, FloatArray]:
        """Wait for ``count`` samples; return the load cell's volts and the encoder's counts.

        The count is NaN between two readings so far apart that the coil could not be followed.
        """
        while self._ready.shape[1] < count:
            self._read_decoder(load_cell)
            if len(self._knots) == 4:
                self._fetch(load_cell)
        (volts, counts), self._ready = self._ready[:, :count], self._ready[:, count:]
        return volts, counts

    def stop(self) -> None:
        """Nothing was started."""

    def close(self) -> None:
        """Let go of the lines."""
        self._chip.close()

    def _read_decoder(self, load_cell: LoadCell) -> None:
        """Add a reading and the instant of it, in samples since the start."""
        before = self._now()
        self._chip.latch()
        after = self._now()
        count = float(_sign_count(self._chip.read_latched() - self._zero))
        self._clock.see(self._fetched + load_cell.waiting, self._now())
        instant = self._clock.samples_at(0.5 * (before + after))
        since = instant - self._knots[-1][0]
        if after - before > LONGEST_LATCH:
            if since <= self._longest:
                return
            count = math.nan  # nothing better came in time
        if since > 1.0:
            self._knots.append((instant, count))

    def _fetch(self, load_cell: LoadCell) -> None:
        """Take the samples up to the last reading but one, which has a reading on either side."""
        end = int(self._knots[2][0]) + 1
        if end <= self._fetched:
            return
        instants = np.arange(self._fetched, end)
        followed = self._knots[2][0] - self._knots[1][0] <= self._longest
        unknown = np.full(instants.size, np.nan)
        counts = _cubic(self._knots, instants.astype(float)) if followed else unknown
        samples = np.stack([load_cell.read(instants.size), counts])
        self._ready = np.concatenate([self._ready, samples], axis=1)
        self._fetched = end


class SampleClock:
    """Tells which sample the DAQ takes at an instant of this machine's clock.

    The samples that have arrived by then are never more than those taken, and now and then nearly
    as many: so the two clocks are laid together, and kept so while they drift.
    """

    def __init__(self, sample_period: float) -> None:
        self._rate = 1.0 / sample_period
        self._offsets: deque[float] = deque(maxlen=READINGS_REMEMBERED)

    def see(self, arrived: int, now: float) -> None:
        """Hear that so many samples had arrived at ``now`` [s]."""
        self._offsets.append(arrived - 1 - self._rate * now)

    def samples_at(self, instant: float) -> float:
        """Return the number of the sample taken at ``instant`` [s], with its fraction."""
        return self._rate * instant + max(self._offsets)


def _cubic(knots: Sequence[tuple[float, float]], at: FloatArray) -> FloatArray:
    """Return the values of the cubic through four points (Lagrange)."""
    total = np.zeros(len(at))
    for time_here, value in knots:
        others = [other for other, _ in knots if other != time_here]
        weight = np.prod([(at - other) / (time_here - other) for other in others], axis=0)
        total += value * weight
    return total


def _sign_count(count: int) -> int:
    """Return a difference of 32-bit counts as a signed number: the counter wraps around."""
    return (count + 2**31) % 2**32 - 2**31


def _rounded_down(rate: float) -> float:
    """Round down to a step that most clocks divide."""
    return max(1.0, rate // 10 * 10)


def _two_digits_of(frequency: float) -> float:
    """Round down to two digits: a frequency above the fastest would be refused again."""
    step = 10.0 ** (math.floor(math.log10(frequency)) - 1)
    return math.floor(frequency / step) * step
