"""Tasks as NI-DAQmx keeps them: what was configured, what is reserved, what runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from nidaqmx.constants import AcquisitionType, RegenerationMode
from nidaqmx.error_codes import DAQmxErrors as Code

from daq_server.board import Acquisition, Board, Generation
from daq_server.faults import DaqmxError
from tissue_probe.signals import FloatArray

#: Clock from which sample clocks are divided [Hz].
TIMEBASE = 80e6
START_TRIGGER = "ai/StartTrigger"
INPUT_CLOCK = "ai/SampleClock"


@dataclass
class Task:
    """One task.

    Attributes
    ----------
    kind : str
        ai, ao, ci, di, do or watchdog; empty before it has a channel.
    """

    name: str
    kind: str = ""
    rate: float = 0.0
    source: str = ""
    buffer: int = 0
    regenerates: bool = True
    trigger: str = ""
    timeout: float = 0.0
    running: bool = False
    generation: Generation | None = None
    acquisition: Acquisition | None = None


class Tasks:
    """All tasks on a board; the board's lock is held by the caller."""

    def __init__(self, board: Board, device: str) -> None:
        self._board = board
        self._device = device
        self._tasks: dict[str, Task] = {}
        self._made = 0
        self._armed: Task | None = None

    def make(self, name: str) -> Task:
        """Make an empty task."""
        self._made += 1
        task = Task(name or f"_unnamedTask<{self._made:X}>")
        if task.name in self._tasks:
            raise DaqmxError(Code.DUPLICATE_TASK)
        self._tasks[task.name] = task
        return task

    def find(self, name: str) -> Task:
        """Return a task."""
        if name not in self._tasks:
            raise DaqmxError(Code.INVALID_TASK)
        return self._tasks[name]

    def clear(self, name: str) -> None:
        """Stop and forget a task."""
        self.stop(self.find(name))
        del self._tasks[name]

    def abort_all(self) -> None:
        """Do what a reset of the device does."""
        for task in self._tasks.values():
            task.running = False
        self._armed = None
        self._board.reset()

    def add_channel(self, task: Task, kind: str, channel: str) -> None:
        """Give a task its channel."""
        self.check_device(channel.partition("/")[0])
        if not channel.partition("/")[2].startswith(("ctr",) if kind == "ci" else (kind, "port")):
            raise DaqmxError(Code.PHYSICAL_CHAN_DOES_NOT_EXIST)
        task.kind = kind

    def check_device(self, name: str) -> None:
        """Refuse other devices than ours."""
        if name != self._device:
            raise DaqmxError(Code.INVALID_DEVICE_ID)

    def clock(self, task: Task, rate: float, source: str, mode: int, samples: int) -> None:
        """Give a task its sample clock, of the nearest rate that the timebase divides to."""
        if task.kind in ("di", "do"):
            raise DaqmxError(Code.INVALID_ATTRIBUTE_VALUE)  # static lines: on demand only
        if source and (task.kind != "ci" or source != f"/{self._device}/{INPUT_CLOCK}"):
            raise DaqmxError(Code.ROUTE_NOT_SUPPORTED_BY_HW_ROUTING)
        if AcquisitionType(mode) != AcquisitionType.CONTINUOUS:
            raise DaqmxError(Code.INVALID_ATTRIBUTE_VALUE)
        task.rate = TIMEBASE / round(TIMEBASE / rate)
        task.source = source
        # As NI-DAQmx sizes the buffer of a continuous task of 100 to 10 000 samples a second.
        task.buffer = max(10_000, samples)

    def set_trigger(self, task: Task, source: str) -> None:
        """Let a task wait for a digital edge."""
        if source != f"/{self._device}/{START_TRIGGER}":
            raise DaqmxError(Code.ROUTE_NOT_SUPPORTED_BY_HW_ROUTING)
        task.trigger = source

    def allow_regeneration(self, task: Task, mode: int) -> None:
        """Say whether an output may play its samples again."""
        task.regenerates = RegenerationMode(mode) == RegenerationMode.ALLOW_REGENERATION

    def start(self, task: Task) -> None:
        """Start a task; what waits for a trigger is armed."""
        self._board.catch_up()
        others = [other for other in self._tasks.values() if other is not task and other.running]
        if any(other.kind == task.kind for other in others):
            raise DaqmxError(Code.PAL_RESOURCE_RESERVED)
        getattr(self, f"_start_{task.kind}", lambda task: None)(task)
        task.running = True

    def stop(self, task: Task) -> None:
        """Stop a task; an output keeps its voltage."""
        board = self._board
        board.catch_up()
        if task.running and task.kind == "ao":
            board.generation = None
            self._armed = None
        elif task.running and task.kind == "ai":
            board.acquisition = None
        elif task.running and task.kind == "ci":
            board.counter = None
        elif task.running and task.kind == "watchdog":
            board.expiry = float("inf")
        task.running = False
        task.generation = task.acquisition = None
        board.lock.notify_all()

    def write(self, task: Task, values: FloatArray, auto_start: bool) -> int:
        """Write voltages; returns how many found a place."""
        board = self._board
        board.catch_up()
        if task.kind != "ao":
            raise DaqmxError(Code.WRITE_CHAN_TYPE_MISMATCH)
        if np.abs(values).max(initial=0.0) > 10.0:
            raise DaqmxError(Code.INVALID_AO_DATA_WRITE)
        if not task.rate:
            if not task.running:
                self.start(task)
            board.put_out(float(values[-1]))
            return values.size
        generation = task.generation
        if generation is None:
            generation = task.generation = Generation(task.buffer, task.regenerates)
        if generation.ran_dry:
            raise DaqmxError(Code.GEN_STOPPED_TO_PREVENT_REGEN_OF_OLD_SAMPLES)
        accepted = min(values.size, generation.space)
        generation.data = np.concatenate([generation.data, values[:accepted]])
        if auto_start and not task.running:
            self.start(task)
        return accepted

    def _start_ai(self, task: Task) -> None:
        if task.rate > self._board.model.input_rate:
            raise DaqmxError(Code.INVALID_ATTRIBUTE_VALUE)
        task.acquisition = Acquisition(task.buffer)
        self._board.begin(task.rate, task.acquisition)
        if self._armed is not None:
            self._board.generation = self._armed.generation

    def _start_ao(self, task: Task) -> None:
        if not task.rate:
            return
        if task.generation is None:
            raise DaqmxError(Code.AO_CALL_WRITE_BEFORE_START_FOR_SAMP_CLK_TIMING_TYPE)
        if task.rate > self._board.model.output_rate:
            raise DaqmxError(Code.INVALID_ATTRIBUTE_VALUE)
        if task.trigger:
            self._armed = task
        else:
            self._board.generation = task.generation

    def _start_ci(self, task: Task) -> None:
        task.acquisition = self._board.counter = Acquisition(task.buffer)

    def _start_watchdog(self, task: Task) -> None:
        if any(other.running for other in self._tasks.values()):
            raise DaqmxError(Code.CANT_RESERVE_WATCHDOG_TASK_WHILE_OTHER_TASKS_RESERVED)
        self._board.feed(task.timeout)
