"""The stand-in behaves as NI-DAQmx is documented to, for the vendor's own client."""

from __future__ import annotations

import re
import signal
import subprocess
import sys

import grpc
import nidaqmx
import numpy as np
import pytest
from nidaqmx.constants import AcquisitionType
from nidaqmx.errors import DaqError, DaqReadError
from nidaqmx.grpc_session_options import GrpcSessionOptions
from nidaqmx.stream_readers import AnalogSingleChannelReader
from nidaqmx.stream_writers import AnalogSingleChannelWriter

from daq_server import CDAQ, X_SERIES, Board, DaqServer
from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration

CALIBRATION = Calibration.load(stock_configuration("calibration.yaml"))


class Daq:
    """A client of a server whose clock is moved by hand."""

    def __init__(self, model) -> None:
        self.now = 0.0
        self.board = Board(model, CALIBRATION, clock=lambda: self.now)
        self.server = DaqServer(self.board)
        self._channel = grpc.insecure_channel(self.server.address)
        self._options = GrpcSessionOptions(self._channel, session_name="")

    def task(self) -> nidaqmx.Task:
        return nidaqmx.Task(grpc_options=self._options)

    def input(self) -> nidaqmx.Task:
        task = self.task()
        task.ai_channels.add_ai_voltage_chan("Dev1/ai0")
        task.timing.cfg_samp_clk_timing(2000.0, sample_mode=AcquisitionType.CONTINUOUS)
        return task

    def output(self, values: np.ndarray) -> nidaqmx.Task:
        task = self.task()
        task.ao_channels.add_ao_voltage_chan("Dev1/ao0")
        task.timing.cfg_samp_clk_timing(2000.0, sample_mode=AcquisitionType.CONTINUOUS)
        task.triggers.start_trigger.cfg_dig_edge_start_trig("/Dev1/ai/StartTrigger")
        task.out_stream.output_buf_size = values.size
        writer = AnalogSingleChannelWriter(task.out_stream, auto_start=False)
        writer.verify_array_shape = False
        writer.write_many_sample(values)
        return task

    def close(self) -> None:
        self._channel.close()
        self.server.die()


@pytest.fixture
def daq(request):
    made = Daq(getattr(request, "param", X_SERIES))
    yield made
    made.close()


def read(task: nidaqmx.Task, count: int, timeout: float = 0.2) -> np.ndarray:
    volts = np.empty(count)
    reader = AnalogSingleChannelReader(task.in_stream)
    reader.verify_array_shape = False
    reader.read_many_sample(volts, count, timeout)
    return volts


def code_of(action, *arguments) -> int:
    with pytest.raises(DaqError) as raised:
        action(*arguments)
    return raised.value.error_code


def test_an_armed_output_waits_for_the_input_and_is_regenerated(daq):
    table = np.array([1.0, 2.0, 3.0])
    output, task = daq.output(table), daq.input()
    output.start()
    daq.now = 5.0
    assert daq.server.coil_voltage == 0.0
    task.start()
    for n in range(9):
        daq.now = 5.0 + (n + 0.5) * 5e-4
        assert daq.server.coil_voltage == table[n % 3]


def test_an_output_armed_after_the_input_has_missed_its_trigger(daq):
    output, task = daq.output(np.ones(10)), daq.input()
    task.start()
    output.start()
    daq.now = 1.0
    assert daq.server.coil_voltage == 0.0


def test_a_stopped_output_keeps_its_voltage(daq):
    output, task = daq.output(np.full(10, 3.0)), daq.input()
    output.start()
    task.start()
    daq.now = 0.1
    output.stop()
    daq.now = 0.2
    assert daq.server.coil_voltage == 3.0


def test_what_nobody_fetches_overruns_the_buffer_with_the_vendors_code(daq):
    task = daq.input()
    task.start()
    daq.now = 6.0  # the default buffer is 10 000 samples
    assert read(task, 10_000).size == 10_000
    with pytest.raises(DaqReadError) as raised:
        read(task, 1)
    assert raised.value.error_code == -200279


def test_a_read_that_times_out_tells_how_many_samples_it_brought(daq):
    task = daq.input()
    task.start()
    daq.now = 0.0031
    with pytest.raises(DaqReadError) as raised:
        read(task, 10, timeout=0.05)
    assert raised.value.error_code == -200284
    assert raised.value.samps_per_chan_read == 7


def test_a_channel_belongs_to_one_running_task(daq):
    daq.input().start()
    assert code_of(daq.input().start) == -50103


def test_a_route_that_does_not_exist_is_refused(daq):
    task = daq.output(np.ones(10))
    trigger = task.triggers.start_trigger
    assert code_of(trigger.cfg_dig_edge_start_trig, "/Dev1/moon") == -89136


def test_an_output_beyond_the_converters_range_is_refused(daq):
    assert code_of(daq.output, np.full(10, 10.5)) == -200561


def test_a_task_that_was_cleared_is_unknown(daq):
    task = daq.input()
    handle = task._handle
    task.close()
    task._handle = handle
    assert code_of(task.start) == -200088


@pytest.mark.parametrize("daq", [CDAQ], indirect=True)
def test_a_watchdog_wants_to_be_the_first(daq):
    watchdog = nidaqmx.system.watchdog.WatchdogTask("Dev1", timeout=0.1, grpc_options=daq._options)
    task = daq.input()
    task.start()
    assert code_of(watchdog.start) == -201477
    task.stop()
    watchdog.start()
    daq.now = 0.2
    assert watchdog.expired
    assert code_of(watchdog.reset_timer) == -200644
    watchdog.clear_expiration()
    assert not watchdog.expired


def test_as_a_program_it_serves_until_ctrl_c():
    program = subprocess.Popen(
        [sys.executable, "-m", "daq_server", "--port", "0", "--model", "cdaq"],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        told = program.stdout.readline()
        address = re.search(r"cDAQ-9189 as Dev1 at (\S+);", told)[1]
        with grpc.insecure_channel(address) as channel:
            device = nidaqmx.system.Device("Dev1", grpc_options=GrpcSessionOptions(channel, ""))
            assert device.product_type == "cDAQ-9189"
        program.send_signal(signal.SIGINT)
        assert program.wait(20.0) == 0
    finally:
        program.kill()
