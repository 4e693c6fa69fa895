"""The same driver node on a DAQ: a process of its own, over a real socket, at 2 kHz."""

from __future__ import annotations

import signal
import time

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from lifecycle_msgs.msg import State, Transition
from nidaqmx.error_codes import DAQmxErrors
from std_msgs.msg import String
from std_srvs.srv import Trigger

from conftest import PATIENCE, activate, change_state, collect, driver, state_of
from daq_server import CDAQ, USB_6002, X_SERIES, Board, DaqServer
from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration
from tissue_probe.nodes.conversions import samples_from_message
from tissue_probe.nodes.qos import LATCHED
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.recording.reader import read_recording
from tissue_probe.signals import join
from tissue_probe_msgs.msg import ProbeSamples

CALIBRATION = Calibration.load(stock_configuration("calibration.yaml"))
#: Half a step of the stock excitation next to a zero [V].
HELD = 0.5 * 0.85 * 2.0 * np.pi * 10.0 * 5e-4


@pytest.fixture(params=[X_SERIES, CDAQ], ids=["dry_buffer", "watchdog"])
def daq(request):
    with DaqServer(Board(request.param, CALIBRATION)) as server:
        yield server


def on_daq(server: DaqServer, **parameters: object) -> NodeProcess:
    # A busy machine may be late by a second.
    patient = {"nidaqmx__expiry": 2.0, "limits__stale_limit": 1.5}
    return driver(device="nidaqmx", nidaqmx__server=server.address, **patient | parameters)


def still_at(server: DaqServer, largest: float) -> bool:
    end = time.monotonic() + 0.1
    while time.monotonic() < end:
        if abs(server.coil_voltage) > largest:
            return False
    return True


def test_it_runs_at_2_khz_with_no_sample_lost(session, daq):
    running = session(on_daq(daq))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    running.wait_until(lambda: len(blocks) >= 1000, "five seconds of samples")
    run = join(samples_from_message(block) for block in blocks)
    assert len(run) == 1
    assert run[0].sequence == 0
    assert run[0].sample_period == 0.0005
    t = np.arange(run[0].command.size) * 0.0005
    np.testing.assert_allclose(run[0].command, 0.85 * np.sin(20.0 * np.pi * t), atol=1e-9)
    assert np.ptp(run[0].position) == pytest.approx(2e-3, rel=0.2)
    late = running.node.get_clock().now().nanoseconds - samples_from_message(blocks[-1]).end
    assert late < 2e9  # the DAQ's clock and this machine's agree


def gone(code: DAQmxErrors):
    return lambda server: setattr(server.board.faults, "gone", code)


FAULTS = {
    "overrun": (
        lambda server: setattr(server.board.faults, "overrun", True),
        "samples were not fetched in time and are lost",
    ),
    "gone": (gone(DAQmxErrors.DEV_CANNOT_BE_ACCESSED), "the DAQ is gone: check its cable"),
    "unplugged": (
        gone(DAQmxErrors.DRIVER_DEVICE_GUID_NOT_FOUND_ROUTING),
        "the DAQ is gone: check its cable",
    ),
    "stall": (lambda server: server.board.faults.stall(), "no sample came for 1.5 s"),
    "dead": (lambda server: server.die(), "gRPC device server does not answer"),
    "saturated": (
        lambda server: setattr(server.board.faults, "saturated", True),
        "the load cell's input is saturated",
    ),
    "stuck": (
        lambda server: setattr(server.board.faults, "stuck", True),
        "the encoder stayed at",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_told_the_coil_is_at_zero_and_what_was_recorded_is_kept(
    session, daq, name, tmp_path
):
    fault, said = FAULTS[name]
    bag = tmp_path / "run.mcap"
    recorder = NodeProcess("recorder", "recorder", parameters={"output": str(bag)})
    running = session(on_daq(daq), recorder)
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    health = collect(running.node, DiagnosticArray, "/diagnostics")
    running.activate({"/probe/driver": 2})
    running.wait_until(lambda: len(blocks) >= 200 or faults[-1].data, "a second of samples")
    assert faults[-1].data == ""
    fault(daq)
    running.wait_until(lambda: state_of(running) == State.PRIMARY_STATE_INACTIVE, "inactivity")
    running.wait_until(lambda: faults and said in faults[-1].data, "the reason")
    assert "\n" not in faults[-1].data
    running.wait_until(
        lambda: any(
            status.level == DiagnosticStatus.ERROR
            and status.message.startswith("FAULT: ")
            and said in status.message
            for array in health
            for status in array.status
        ),
        "diagnostics",
    )
    running.wait_until(lambda: still_at(daq, HELD), "the coil to rest at zero")
    assert not change_state(running, Transition.TRANSITION_ACTIVATE)
    run = join(samples_from_message(block) for block in blocks)
    assert len(run) == 1
    running.processes["recorder"].send_signal(signal.SIGINT)
    assert running.processes["recorder"].wait(PATIENCE) == 0
    recorded = join(read_recording(bag).blocks)
    assert len(recorded) == 1
    np.testing.assert_array_equal(recorded[0].force, run[0].force)
    if name == "saturated":  # the reason is in the recording
        assert run[0].force.max() > 19.9


def test_after_a_fault_is_mended_the_reset_makes_it_run_again(session, daq):
    running = session(on_daq(daq))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    running.wait_until(lambda: len(blocks) >= 50, "samples")
    daq.board.faults.gone = DAQmxErrors.DEV_CANNOT_BE_ACCESSED
    running.wait_until(lambda: state_of(running) == State.PRIMARY_STATE_INACTIVE, "inactivity")
    daq.board.faults.clear()
    client = running.node.create_client(Trigger, "/probe/reset")
    running.wait_until(client.service_is_ready, "the driver")
    answer = client.call_async(Trigger.Request())
    running.wait_until(answer.done, "its answer")
    assert answer.result().success
    count = len(blocks)
    assert change_state(running, Transition.TRANSITION_ACTIVATE)
    running.wait_until(lambda: len(blocks) >= count + 100, "samples")


def test_an_emergency_stop_puts_the_coil_at_zero_within_a_block(session, daq):
    running = session(on_daq(daq))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    client = running.node.create_client(Trigger, "/probe/emergency_stop")
    activate(running)
    running.wait_until(lambda: len(blocks) >= 50, "samples")
    running.wait_until(client.service_is_ready, "the service")
    answer = client.call_async(Trigger.Request())
    running.wait_until(answer.done, "its answer")
    assert daq.coil_voltage == 0.0  # the answer comes when it is done
    assert answer.result().success


def test_the_coil_ends_at_zero_after_the_driver_was_killed(session, daq):
    running = session(on_daq(daq, nidaqmx__expiry=1.0))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    running.wait_until(lambda: len(blocks) >= 50, "samples")
    running.processes["driver"].send_signal(signal.SIGKILL)
    killed = time.monotonic()
    end = killed + PATIENCE
    while not still_at(daq, HELD):
        assert time.monotonic() < end, "the coil is driven on"
    assert time.monotonic() - killed < 1.0 + 0.05 + 2.0  # expiry, half a period, and the look


def test_the_papers_daq_is_refused_at_2_khz_with_one_sentence(session):
    with DaqServer(Board(USB_6002, CALIBRATION)) as server:
        running = session(on_daq(server, nidaqmx__encoder="hctl2032"))
        assert not change_state(running, Transition.TRANSITION_CONFIGURE)
        assert "the HCTL-2032 can be read" in running.log("driver")
        assert "not 2000: give nidaqmx.sample_rate" in running.log("driver")
