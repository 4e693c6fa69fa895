"""The same driver node on a DAQ: a process of its own, over a real socket, at 2 kHz."""

from __future__ import annotations

import functools
import signal
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from lifecycle_msgs.msg import State, Transition
from nidaqmx.error_codes import DAQmxErrors
from std_msgs.msg import String
from std_srvs.srv import Trigger

from conftest import (
    PATIENCE,
    activate,
    ask,
    change_state,
    collect,
    deactivate,
    driver,
    driver_log,
    estimator,
    own_domain,
    set_parameter,
    state_of,
)
from daq_server import CDAQ, USB_6002, X_SERIES, Board, DaqServer, Model
from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration
from tissue_probe.nodes.conversions import samples_from_message
from tissue_probe.nodes.qos import LATCHED
from tissue_probe.nodes.session import NodeProcess, Session
from tissue_probe.recording.bags.reader import read_recording
from tissue_probe.signals import SampleBlock, join
from tissue_probe_msgs.msg import ProbeSamples, TissueEstimate

CALIBRATION = Calibration.load(stock_configuration("calibration.yaml"))
#: Half a step of the stock excitation next to a zero [V].
HELD = 0.5 * 0.85 * 2.0 * np.pi * 10.0 * 5e-4


MODELS = pytest.mark.parametrize("model", [X_SERIES, CDAQ], ids=["dry_buffer", "watchdog"])


def on_daq(server: DaqServer, **parameters: object) -> NodeProcess:
    # A busy machine may be late by a second.
    patient = {"nidaqmx__expiry": 2.0, "limits__stale_limit": 1.5}
    return driver(device="nidaqmx", nidaqmx__server=server.address, **patient | parameters)


class Bench:
    """A DAQ, the driver on it and a recorder, and what they told."""

    def __init__(self, server: DaqServer, running: Session, bag: Path) -> None:
        self.daq, self.running, self.bag = server, running, bag
        self.blocks = collect(running.node, ProbeSamples, "/probe/samples")
        self.faults = collect(running.node, String, "/probe/fault", LATCHED)
        self.health = collect(running.node, DiagnosticArray, "/diagnostics")
        running.activate({"/probe/driver": 2})
        deactivate(running)

    def activate(self, blocks: int) -> None:
        """Begin anew, and wait for so many blocks."""
        self.blocks.clear()
        assert change_state(self.running, Transition.TRANSITION_ACTIVATE), driver_log(self.running)
        self.running.wait_until(
            lambda: len(self.blocks) >= blocks or self.faults[-1].data, "samples"
        )
        assert self.faults[-1].data == ""

    def run(self) -> SampleBlock:
        """Return the samples of this activation, none of which is missing."""
        (run,) = join(samples_from_message(block) for block in self.blocks)
        assert run.sequence == 0
        return run

    def call(self, service: str) -> None:
        assert ask(self.running, Trigger, f"/probe/{service}").success

    def wait_for_fault(self, said: str) -> None:
        """Wait until it is told everywhere, and the coil rests."""
        running = self.running
        running.wait_until(lambda: said in self.faults[-1].data, "the reason")
        assert "\n" not in self.faults[-1].data
        running.wait_until(lambda: state_of(running) == State.PRIMARY_STATE_INACTIVE, "inactivity")
        running.wait_until(lambda: any(map(self._is_told, self.health)), "diagnostics")
        running.wait_until(lambda: still_at(self.daq, HELD), "the coil to rest at zero")

    def _is_told(self, array: DiagnosticArray) -> bool:
        return any(
            status.level == DiagnosticStatus.ERROR
            and status.message == f"FAULT: {self.faults[-1].data}"
            for status in array.status
        )


@pytest.fixture(scope="module")
def benches(tmp_path_factory):
    """One bench for each kind of DAQ, started when it is first wanted."""
    with ExitStack() as stack:

        @functools.cache
        def make(model: Model) -> Bench:
            bag = tmp_path_factory.mktemp("bench") / "run.mcap"
            server = stack.enter_context(DaqServer(Board(model, CALIBRATION)))
            recorder = NodeProcess("recorder", "recorder", parameters={"output": str(bag)})
            patch = stack.enter_context(pytest.MonkeyPatch.context())
            patch.setenv("ROS_DOMAIN_ID", str(stack.enter_context(own_domain())))
            running = stack.enter_context(Session([on_daq(server), recorder]))
            patch.undo()
            return Bench(server, running, bag)

        yield make


@pytest.fixture
def bench(benches, model):
    """A driver that is inactive and armed, as it is left behind."""
    made = benches(model)
    yield made
    made.daq.board.faults.clear()
    # After a fault the driver deactivates by itself, perhaps just now.
    change_state(made.running, Transition.TRANSITION_DEACTIVATE)
    made.running.wait_until(
        lambda: state_of(made.running) == State.PRIMARY_STATE_INACTIVE, "inactivity"
    )
    made.call("reset")


def still_at(server: DaqServer, largest: float) -> bool:
    end = time.monotonic() + 0.1
    while time.monotonic() < end:
        if abs(server.coil_voltage) > largest:
            return False
    return True


@MODELS
def test_it_runs_at_2_khz_with_no_sample_lost(bench):
    bench.activate(blocks=600)
    late = bench.running.node.get_clock().now().nanoseconds - bench.run().end
    assert late < 2e9  # the DAQ's clock and this machine's agree
    run = bench.run()
    assert run.sample_period == 0.0005
    t = np.arange(run.command.size) * 0.0005
    np.testing.assert_allclose(run.command, 0.85 * np.sin(20.0 * np.pi * t), atol=1e-9)
    assert np.ptp(run.position) == pytest.approx(2e-3, rel=0.2)


FAULTS = {
    "overrun": ("overrun", True, "samples were not fetched in time and are lost"),
    "gone": ("gone", DAQmxErrors.DEV_CANNOT_BE_ACCESSED, "the DAQ is gone: check its cable"),
    "unplugged": (
        "gone",
        DAQmxErrors.DRIVER_DEVICE_GUID_NOT_FOUND_ROUTING,
        "the DAQ is gone: check its cable",
    ),
    "stall": ("stalled", True, "no sample came for 1.5 s"),
    "saturated": ("saturated", True, "the load cell's input is saturated"),
    "stuck": ("stuck", True, "the encoder stayed at"),
}


@MODELS
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_told_the_coil_is_at_zero_and_it_runs_again_after_the_reset(bench, name):
    fault, value, said = FAULTS[name]
    bench.activate(blocks=50)
    setattr(bench.daq.board.faults, fault, value)
    bench.wait_for_fault(said)
    assert not change_state(bench.running, Transition.TRANSITION_ACTIVATE)
    run = bench.run()
    if name == "saturated":  # the reason is among the samples
        assert run.force.max() > 19.9
    bench.running.wait_until(lambda: len(last_run(bench.bag)) == len(run), "the recording")
    np.testing.assert_array_equal(last_run(bench.bag).force, run.force)
    bench.daq.board.faults.clear()
    bench.call("reset")
    bench.activate(blocks=20)


def last_run(bag: Path) -> SampleBlock:
    """Return what a recorder has stored of the latest activation."""
    return join(read_recording(bag).blocks)[-1]


@MODELS
def test_a_server_that_dies_is_told_and_what_was_measured_is_kept(session, model):
    with DaqServer(Board(model, CALIBRATION)) as server:
        running = session(on_daq(server))
        faults = collect(running.node, String, "/probe/fault", LATCHED)
        blocks = collect(running.node, ProbeSamples, "/probe/samples")
        activate(running)
        running.wait_until(lambda: len(blocks) >= 50, "samples")
        server.die()
        said = "gRPC device server does not answer"
        running.wait_until(lambda: said in faults[-1].data, "the reason")
        running.wait_until(lambda: still_at(server, HELD), "the coil to rest at zero")
        assert len(join(samples_from_message(block) for block in blocks)) == 1


@MODELS
def test_an_emergency_stop_puts_the_coil_at_zero_within_a_block(bench):
    bench.activate(blocks=20)
    bench.call("emergency_stop")
    assert bench.daq.coil_voltage == 0.0  # the answer comes when it is done
    bench.wait_for_fault("emergency_stop")


@MODELS
def test_the_coil_ends_at_zero_after_the_driver_was_killed(session, model):
    with DaqServer(Board(model, CALIBRATION)) as server:
        _kill_driver_on(server, session)


def _kill_driver_on(daq: DaqServer, session) -> None:
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
        assert "the HCTL-2032 can be read" in running.whole_log("driver")
        assert "not 2000: give nidaqmx.sample_rate" in running.whole_log("driver")


def test_the_papers_daq_gives_a_stiffness_where_the_coil_moves_slowly():
    """One decoder reading in 20 ms, forces at 2 kHz, and the stock parameters for it."""
    board = Board(USB_6002, CALIBRATION, stiffness=620.0, damping=6.0)
    with DaqServer(board) as server:
        on_server = {"nidaqmx.server": server.address, "nidaqmx.expiry": 2.0}
        processes = [NodeProcess("driver", "driver", parameters=on_server), estimator("robust_ekf")]
        with Session(processes, stock_configuration("usb6002.yaml")) as running:
            estimates = collect(running.node, TissueEstimate, "/probe/robust_ekf/estimate")
            # A busy machine may read too rarely for seconds; those samples are without position.
            assert set_parameter(running, "/probe/driver", "limits.stale_limit", 5.0)[0]
            running.activate({"/probe/driver": 1, "/probe/robust_ekf": 1})
            running.wait_until(
                lambda: (
                    estimates
                    and estimates[-1].sequence > 6000
                    and estimates[-1].status == TissueEstimate.CONVERGED
                ),
                "three seconds of samples and a converged estimate",
            )
    last = estimates[-1]
    assert last.status == TissueEstimate.CONVERGED
    assert last.stiffness == pytest.approx(620.0, rel=0.02)
    assert abs(last.stiffness - 620.0) < 5.0 * last.stiffness_variance**0.5 < 0.02 * 620.0


def test_the_daq_and_the_driver_are_tried_by_one_command(graph):
    blocks = collect(graph.node, ProbeSamples, "/probe/samples")
    command = [sys.executable, "-m", "daq_server", "--drive", "--port", "0"]
    program = subprocess.Popen(command, start_new_session=True)
    try:
        graph.wait_until(lambda: len(blocks) >= 20)
        program.send_signal(signal.SIGINT)
        assert program.wait(PATIENCE) == 0
    finally:
        program.kill()
