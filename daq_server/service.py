"""The requests of ``nidaqmx``, answered as NI's gRPC device server does.

A failed call ends with status UNKNOWN, the vendor's words as details, and the code in the trailing
metadata ``ni-error``; a read that timed out ends well, with the code as the response's status.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from typing import Any

import grpc
import numpy as np
from nidaqmx._stubs import nidaqmx_pb2 as messages
from nidaqmx._stubs.nidaqmx_pb2_grpc import NiDAQmxServicer
from nidaqmx.constants import WDTTaskAction
from nidaqmx.error_codes import DAQmxErrors as Code
from session_pb2 import Session

from daq_server.board import Acquisition, Board
from daq_server.faults import DaqmxError, words
from daq_server.tasks import Task, Tasks

SERIAL_NUMBER = 0x1C0FFEE
#: Attributes of the device, by their numbers in NI-DAQmx.
STRINGS = {0x0631: lambda model: model.product}
NUMBERS = {0x298C: lambda model: model.input_rate, 0x2997: lambda model: model.output_rate}
LISTS = {0x2FD4: lambda model: [usage.value for usage in model.counts]}
CLOCKED_OUTPUT, SERIAL, CLOCK_RATE, AVAILABLE = 0x2996, 0x0632, 0x1344, 0x1223
OUTPUT_BUFFER, REGENERATION, TASK_NAME, EXPIRED = 0x186D, 0x1453, 0x1276, 0x21A8
VERSION = {0x1272: 25, 0x1923: 5, 0x2F22: 0}
#: Where a failed transfer tells how many samples it moved.
_COUNTS = {
    **dict.fromkeys(("ReadAnalogF64", "ReadCounterF64", "ReadDigitalU8"), "ni-samps-per-chan-read"),
    **dict.fromkeys(("WriteAnalogF64", "WriteDigitalU8"), "ni-samps-per-chan-written"),
}


def _answers(method: Callable[..., Any]) -> Callable[..., Any]:
    """Hold the board's lock, and send errors of NI-DAQmx as the device server does."""

    @functools.wraps(method)
    def answer(self: Service, request: Any, context: grpc.ServicerContext) -> Any:
        try:
            with self.board.lock:
                if self.board.faults.gone is not None and method.__name__ != "ClearTask":
                    raise DaqmxError(self.board.faults.gone)
                return method(self, request, context)
        except DaqmxError as error:
            metadata = [("ni-error", str(error.code))]
            if key := _COUNTS.get(method.__name__):
                metadata.append((key, str(error.samples)))
            context.set_trailing_metadata(metadata)
            context.abort(grpc.StatusCode.UNKNOWN, str(error))

    return answer


class Service(NiDAQmxServicer):
    """One device, ``Dev1``, and the tasks on it."""

    def __init__(self, board: Board, device: str = "Dev1") -> None:
        self.board = board
        self.tasks = Tasks(board, device)

    def GetSystemInfoAttributeUInt32(self, request, context):
        return messages.GetSystemInfoAttributeUInt32Response(value=VERSION[request.attribute_raw])

    def GetErrorString(self, request, context):
        return messages.GetErrorStringResponse(error_string=words(request.error_code))

    @_answers
    def ResetDevice(self, request, context):
        self.tasks.check_device(request.device_name)
        self.tasks.abort_all()
        return messages.ResetDeviceResponse()

    @_answers
    def GetDeviceAttributeString(self, request, context):
        value = STRINGS[request.attribute_raw](self.board.model)
        return messages.GetDeviceAttributeStringResponse(value=value)

    @_answers
    def GetDeviceAttributeDouble(self, request, context):
        value = NUMBERS[request.attribute_raw](self.board.model)
        return messages.GetDeviceAttributeDoubleResponse(value=value)

    @_answers
    def GetDeviceAttributeInt32Array(self, request, context):
        value = LISTS[request.attribute_raw](self.board.model)
        return messages.GetDeviceAttributeInt32ArrayResponse(value_raw=value)

    @_answers
    def GetDeviceAttributeBool(self, request, context):
        return messages.GetDeviceAttributeBoolResponse(
            value=request.attribute_raw == CLOCKED_OUTPUT
        )

    @_answers
    def GetDeviceAttributeUInt32(self, request, context):
        return messages.GetDeviceAttributeUInt32Response(
            value=SERIAL_NUMBER if request.attribute_raw == SERIAL else 0
        )

    @_answers
    def CreateTask(self, request, context):
        task = self.tasks.make(request.session_name)
        return messages.CreateTaskResponse(
            task=Session(name=task.name), new_session_initialized=True
        )

    @_answers
    def ClearTask(self, request, context):
        self.tasks.clear(request.task.name)
        return messages.ClearTaskResponse()

    @_answers
    def GetTaskAttributeString(self, request, context):
        return messages.GetTaskAttributeStringResponse(value=self._task(request).name)

    @_answers
    def StartTask(self, request, context):
        self.tasks.start(self._task(request))
        return messages.StartTaskResponse()

    @_answers
    def StopTask(self, request, context):
        self.tasks.stop(self._task(request))
        return messages.StopTaskResponse()

    @_answers
    def CreateAIVoltageChan(self, request, context):
        self.tasks.add_channel(self._task(request), "ai", request.physical_channel)
        return messages.CreateAIVoltageChanResponse()

    @_answers
    def CreateAOVoltageChan(self, request, context):
        self.tasks.add_channel(self._task(request), "ao", request.physical_channel)
        return messages.CreateAOVoltageChanResponse()

    @_answers
    def CreateCILinEncoderChan(self, request, context):
        self.tasks.add_channel(self._task(request), "ci", request.counter)
        return messages.CreateCILinEncoderChanResponse()

    @_answers
    def CreateDIChan(self, request, context):
        self.tasks.add_channel(self._task(request), "di", request.lines)
        return messages.CreateDIChanResponse()

    @_answers
    def CreateDOChan(self, request, context):
        self.tasks.add_channel(self._task(request), "do", request.lines)
        return messages.CreateDOChanResponse()

    @_answers
    def CfgSampClkTiming(self, request, context):
        self.tasks.clock(
            self._task(request),
            request.rate,
            request.source,
            request.sample_mode_raw,
            request.samps_per_chan,
        )
        return messages.CfgSampClkTimingResponse()

    @_answers
    def GetTimingAttributeDouble(self, request, context):
        return messages.GetTimingAttributeDoubleResponse(value=self._task(request).rate)

    @_answers
    def CfgDigEdgeStartTrig(self, request, context):
        self.tasks.set_trigger(self._task(request), request.trigger_source)
        return messages.CfgDigEdgeStartTrigResponse()

    @_answers
    def SetBufferAttributeUInt32(self, request, context):
        self._task(request).buffer = request.value
        return messages.SetBufferAttributeUInt32Response()

    @_answers
    def SetWriteAttributeInt32(self, request, context):
        self.tasks.allow_regeneration(self._task(request), request.value_raw)
        return messages.SetWriteAttributeInt32Response()

    @_answers
    def WriteAnalogScalarF64(self, request, context):
        self.tasks.write(self._task(request), np.array([request.value]), request.auto_start)
        return messages.WriteAnalogScalarF64Response()

    @_answers
    def WriteAnalogF64(self, request, context):
        values = np.array(request.write_array)
        task, deadline = self._task(request), time.monotonic() + request.timeout
        written = 0
        while True:
            written += self.tasks.write(task, values[written:], request.auto_start)
            if written == values.size:
                return messages.WriteAnalogF64Response(samps_per_chan_written=written)
            if time.monotonic() > deadline:
                raise DaqmxError(Code.SAMPLES_CAN_NOT_YET_BE_WRITTEN, written)
            self.board.wait(0.005)

    @_answers
    def GetReadAttributeUInt32(self, request, context):
        self.board.catch_up()
        acquisition = self._task(request).acquisition
        return messages.GetReadAttributeUInt32Response(
            value=0 if acquisition is None else len(acquisition)
        )

    @_answers
    def ReadAnalogF64(self, request, context):
        return self._read(request, context, messages.ReadAnalogF64Response())

    @_answers
    def ReadCounterF64Ex(self, request, context):
        return self._read(request, context, messages.ReadCounterF64ExResponse())

    @_answers
    def ReadCounterF64(self, request, context):
        return self._read(request, context, messages.ReadCounterF64Response())

    @_answers
    def WriteDigitalU8(self, request, context):
        self._spend_on_digital_lines()
        self.board.catch_up()
        self.board.chip.set_control(request.write_array[-1], self.board.count)
        return messages.WriteDigitalU8Response(samps_per_chan_written=1)

    @_answers
    def ReadDigitalU8(self, request, context):
        self._spend_on_digital_lines()
        return messages.ReadDigitalU8Response(
            read_array=bytes([self.board.chip.data]), samps_per_chan_read=1
        )

    @_answers
    def CreateWatchdogTimerTaskEx(self, request, context):
        self.tasks.check_device(request.device_name)
        if not self.board.model.has_watchdog:
            raise DaqmxError(Code.WATCHDOG_TIMER_NOT_SUPPORTED)
        task = self.tasks.make(request.session_name)
        task.kind, task.timeout = "watchdog", request.timeout
        return messages.CreateWatchdogTimerTaskExResponse(
            task=Session(name=task.name), new_session_initialized=True
        )

    @_answers
    def CfgWatchdogAOExpirStates(self, request, context):
        if list(request.expir_state_array) != [0.0]:
            raise DaqmxError(Code.INVALID_ATTRIBUTE_VALUE)
        return messages.CfgWatchdogAOExpirStatesResponse()

    @_answers
    def GetWatchdogAttributeBool(self, request, context):
        self.board.catch_up()
        return messages.GetWatchdogAttributeBoolResponse(value=self.board.expired)

    @_answers
    def ControlWatchdogTask(self, request, context):
        task = self._task(request)
        self.board.catch_up()
        if request.action_raw == WDTTaskAction.CLEAR_EXPIRATION.value:
            self.board.expired = False
        elif self.board.expired:
            raise DaqmxError(Code.CANT_RESET_EXPIRED_WATCHDOG)
        else:
            self.board.feed(task.timeout)
        return messages.ControlWatchdogTaskResponse()

    def _task(self, request: Any) -> Task:
        return self.tasks.find(request.task.name)

    def _read(self, request: Any, context: grpc.ServicerContext, response: Any) -> Any:
        """Wait for samples, with the lock released; a wait that is too long gives what there is."""
        task, board, count = self._task(request), self.board, request.num_samps_per_chan
        if task.acquisition is None:
            raise DaqmxError(Code.INVALID_TASK)
        acquisition: Acquisition = task.acquisition
        deadline = time.monotonic() + request.timeout
        while True:
            board.catch_up()
            if board.faults.gone is not None:
                raise DaqmxError(board.faults.gone)
            if board.faults.overrun or (acquisition.overwritten and len(acquisition) < count):
                raise DaqmxError(Code.SAMPLES_NO_LONGER_AVAILABLE)
            if task.acquisition is not acquisition:
                raise DaqmxError(Code.RUNTIME_ABORTED_ROUTING)
            flowing = not board.faults.stalled
            if flowing and (len(acquisition) >= count or time.monotonic() >= deadline):
                break
            if not context.is_active():
                context.abort(grpc.StatusCode.CANCELLED, "the client hung up")
            missing = count - len(acquisition)
            if flowing:
                board.wait(max(0.0002, board.time_of(missing)))
            else:
                board.lock.wait(0.02)
        values = acquisition.take(count)
        if len(values) < count:
            response.status = int(Code.SAMPLES_NOT_YET_AVAILABLE)
        response.samps_per_chan_read = len(values)
        padding = [0.0] * (request.array_size_in_samps - len(values))
        response.read_array.extend(values + padding)
        return response

    def _spend_on_digital_lines(self) -> None:
        """Take the time that a static line takes."""
        self.board.take_time(self.board.model.digital_time)
