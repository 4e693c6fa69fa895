"""The probe on a DAQ: force in, coil out, encoder in, all on the DAQ's sample clock."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from threading import Lock
from typing import Protocol, TypeVar

import nidaqmx
import yaml
from nidaqmx.constants import AcquisitionType, TerminalConfiguration
from nidaqmx.errors import Error
from nidaqmx.stream_writers import AnalogSingleChannelWriter

from tissue_probe.alignment import Alignment
from tissue_probe.devices.calibration import Calibration
from tissue_probe.devices.device import DeviceError, Samples
from tissue_probe.devices.nidaqmx.connection import Connection
from tissue_probe.devices.nidaqmx.decoder import Hctl2032, InterpolatedHctl2032
from tissue_probe.devices.nidaqmx.encoder import DAQ_BUFFER_TIME, CounterEncoder, Encoder, LoadCell
from tissue_probe.devices.nidaqmx.errors import convert_errors
from tissue_probe.devices.nidaqmx.guard import HardwareWatchdog, find_watchdog
from tissue_probe.devices.nidaqmx.output import (
    RegeneratedOutput,
    StreamedOutput,
    TimedOutput,
    period_in_samples,
)
from tissue_probe.devices.nidaqmx.settings import NiDaqmxSettings
from tissue_probe.excitation import Excitation

TERMINALS = {
    "rse": TerminalConfiguration.RSE,
    "nrse": TerminalConfiguration.NRSE,
    "differential": TerminalConfiguration.DIFF,
}


class _Closes(Protocol):
    def close(self) -> None: ...


_Closeable = TypeVar("_Closeable", bound=_Closes)

ENCODERS: dict[str, Callable[[Connection, NiDaqmxSettings, float], Encoder]] = {
    encoder.name: encoder for encoder in (CounterEncoder, Hctl2032, InterpolatedHctl2032)
}
STOPPED = "the DAQ was stopped while it was read"
#: Largest voltage of the output, either way [V]; the limits say which is allowed.
COIL_SPAN = 10.0
#: A voltage so near to an end of the amplifier's span, as a part of it, may be any beyond it.
SATURATION = 0.0005


class NiDaqmxProbe:
    """A probe on a DAQ.

    The output is armed first and waits for the start of the load cell's input, and the counter is
    clocked by that input's sample clock: sample n of force, position and command belong together.
    Where the calibration knows a delay of the force, the earlier channel is delayed by as much.

    Parameters
    ----------
    settings : NiDaqmxSettings
        Wiring, and where the DAQ is.
    calibration : Calibration
        Volts as newtons, counts as metres.
    clock : callable
        The time [s] by which requests to the DAQ are placed.

    Raises
    ------
    DeviceError
        If the DAQ cannot be reached, or cannot follow the settings.
    """

    Settings = NiDaqmxSettings
    samples_per_read = 10
    sample_period: float

    _coil: nidaqmx.Task | None
    _input: nidaqmx.Task
    _encoder: Encoder
    _watchdog: HardwareWatchdog | None

    def __init__(
        self,
        settings: NiDaqmxSettings,
        calibration: Calibration,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._clock = clock
        self.commanded_voltage = 0.0
        self._settings = settings
        self._calibration = calibration
        margin = SATURATION * (settings.force_high - settings.force_low)
        ends = calibration.force([settings.force_low + margin, settings.force_high - margin])
        self.force_range = (float(min(ends)), float(max(ends)))
        self._lock = Lock()
        self._sampling = False
        self._output: TimedOutput | None = None
        self._opened: list[_Closes] = []
        self._failed = False
        self._open()

    def start(self, excitation: Excitation) -> None:
        """Begin to sample; the excitation [V] begins with sample 0, by the same trigger.

        Raises
        ------
        DeviceError
            If the DAQ refuses.
        """
        self.stop()
        if self._failed:
            self._let_go()  # a failure may have left tasks in any state
        if not self._opened:
            self._open()
        with convert_errors("the DAQ cannot start"):
            try:
                self._coil = coil = self._coil_task()
                self._output = self._make_output(coil, excitation)
                if self._watchdog is not None:
                    self._watchdog.start()
                self._encoder.arm(excitation)
                coil.start()
                self._taken = 0
                delay = self._calibration.force_delay / self.sample_period
                self._alignment = Alignment(delay)
                self._sampling = True
                self._input.start()
            except BaseException:
                self._sampling = True  # a started task must be stopped
                with suppress(DeviceError):
                    self.stop()
                raise

    def read(self, count: int) -> Samples:
        """Wait for ``count`` samples.

        Raises
        ------
        DeviceError
            If the DAQ failed, lost samples, or is stopped meanwhile.
        """
        output = self._output
        if not self._sampling or output is None:
            raise DeviceError("the DAQ is not sampling: start it before you read")
        try:
            with convert_errors("the DAQ cannot be read"):
                volts, counts = self._encoder.read(self._load_cell, count)
                command = output.commands(self._taken, count)
                self._taken += count
                output.advance(self._taken)
                if self._watchdog is not None:
                    self._watchdog.feed()
        except DeviceError:
            self._failed = True
            if not self._sampling:
                raise DeviceError(STOPPED) from None
            raise
        with self._lock:
            if not self._sampling:
                raise DeviceError(STOPPED)
            self.commanded_voltage = float(command[-1])
        position, force = self._alignment.apply(
            self._calibration.position(counts), self._calibration.force(volts)
        )
        return Samples(position, force, command)

    @property
    def worst_lateness(self) -> float:
        """How long the oldest sample has waited to be fetched [s]."""
        if not self._sampling:
            return 0.0
        with suppress(Error, ValueError):  # the next read will tell
            return float(self._load_cell.waiting * self.sample_period)
        return 0.0

    @property
    def description(self) -> str:
        """The DAQ, its encoder, and the end of the output if the driver dies, in YAML."""
        return str(yaml.safe_dump(self._description, sort_keys=False))

    def stop(self) -> None:
        """Put the coil at zero volts and end sampling.

        Raises
        ------
        DeviceError
            If the DAQ could not be told to.
        """
        with self._lock:
            if not self._sampling:
                return
            self._sampling = False
            self.commanded_voltage = 0.0
            failed, self._failed = self._failed, True  # until all is done
            with convert_errors(f"the coil may be driven on for {self._driven_on}"):
                if self._coil is not None:
                    self._coil.close()
                    self._coil = None
                if self._watchdog is not None:
                    self._watchdog.stop()
                self._put_at_zero()
            with suppress(Error, ValueError):  # the coil is at zero, and that counts
                self._input.stop()
                self._encoder.stop()
                self._failed = failed

    def close(self) -> None:
        """Stop, and let go of the DAQ until the next start."""
        with suppress(DeviceError):
            self.stop()
        self._let_go()

    def _open(self) -> None:
        self._connection = Connection(self._settings.server, self._settings.timeout, self._clock)
        try:
            with convert_errors("the DAQ cannot be used"):
                self._look_at_daq()
                self._make_tasks()
                self._put_at_zero()
        except BaseException:
            self._let_go()
            raise
        self._failed = False

    def _look_at_daq(self) -> None:
        """Refuse a DAQ that cannot do it; free it from tasks that a dead driver left behind."""
        settings = self._settings
        daq = self._connection.device(settings.device)
        daq.reset_device()
        fastest = min(daq.ai_max_single_chan_rate, daq.ao_max_rate)
        if not daq.ao_samp_clk_supported or settings.sample_rate > fastest:
            raise DeviceError(
                f"{settings.device}, a {daq.product_type}, plays and measures at most "
                f"{fastest if daq.ao_samp_clk_supported else 0:g} samples a second by its own "
                f"clock: lower nidaqmx.sample_rate, or use another DAQ"
            )
        self._description = {"daq": daq.product_type, "serial_number": f"{daq.serial_num:X}"}

    def _make_tasks(self) -> None:
        """Make the lasting tasks; the coil's task is made for each excitation."""
        connection, settings = self._connection, self._settings
        self._coil = None
        self._input = self._opens(connection.task())
        self._input.ai_channels.add_ai_voltage_chan(
            f"{settings.device}/{settings.force_channel}",
            terminal_config=TERMINALS[settings.force_terminals],
            min_val=settings.force_low,
            max_val=settings.force_high,
        )
        self._input.timing.cfg_samp_clk_timing(
            settings.sample_rate,
            sample_mode=AcquisitionType.CONTINUOUS,
            samps_per_chan=round(DAQ_BUFFER_TIME * settings.sample_rate),
        )
        self.sample_period = 1.0 / self._input.timing.samp_clk_rate
        self._load_cell = LoadCell(self._input, settings.timeout)
        self._zero = self._opens(self._coil_task())
        self._encoder = self._opens(
            ENCODERS[settings.encoder](connection, settings, self.sample_period)
        )
        self._watchdog = find_watchdog(connection, settings)
        if self._watchdog is not None:
            self._opens(self._watchdog)
        self._description |= {
            "encoder": self._encoder.name,
            "coil_driven_after_death": self._driven_on,
        }

    def _make_output(self, coil: nidaqmx.Task, excitation: Excitation) -> TimedOutput:
        """Arm nothing yet: load the coil's task with the excitation, to start with the input."""
        settings = self._settings
        trigger = f"/{settings.device}/ai/StartTrigger"
        coil.triggers.start_trigger.cfg_dig_edge_start_trig(trigger)
        samples = period_in_samples(excitation, self.sample_period)
        if self._watchdog is not None and samples is not None:
            return RegeneratedOutput(coil, excitation, self.sample_period, samples)
        return StreamedOutput(coil, excitation, self.sample_period, settings.expiry)

    def _coil_task(self) -> nidaqmx.Task:
        task = self._connection.task()
        channel = f"{self._settings.device}/{self._settings.coil_channel}"
        task.ao_channels.add_ao_voltage_chan(channel, min_val=-COIL_SPAN, max_val=COIL_SPAN)
        return task

    def _put_at_zero(self) -> None:
        AnalogSingleChannelWriter(self._zero.out_stream, auto_start=True).write_one_sample(0.0)
        self._zero.stop()  # else it would keep the channel from the excitation

    def _opens(self, what: _Closeable) -> _Closeable:
        self._opened.append(what)
        return what

    def _let_go(self) -> None:
        """Close all; where the server no longer answers, it has nothing that could be closed."""
        try:
            while self._opened:
                self._opened.pop().close()
        except (Error, ValueError):
            self._opened.clear()
        self._connection.close()

    @property
    def _driven_on(self) -> str:
        if self._watchdog is not None:
            return f"{self._settings.expiry:g} s, by the DAQ's watchdog"
        return (
            f"{self._settings.expiry:g} s and up to the next zero of the excitation, when the "
            "DAQ's buffer runs dry"
        )
