"""The driver node: what it publishes, how it is run, and the coil at zero after anything."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, WrenchStamped
from lifecycle_msgs.msg import State, Transition
from rcl_interfaces.srv import DescribeParameters

from conftest import (
    PATIENCE,
    activate,
    ask,
    change_state,
    collect,
    deactivate,
    driver,
    fails_with,
    samples_publisher,
    set_parameter,
    stage_on_tissue,
    state_of,
)
from tissue_probe.nodes.conversions import from_time, samples_from_message
from tissue_probe.nodes.driver import Driver
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.settings import SettingsError
from tissue_probe.signals import join
from tissue_probe_msgs.msg import ProbeSamples


def health_of(running) -> list[DiagnosticStatus]:
    received = collect(running.node, DiagnosticArray, "/diagnostics")
    statuses: list[DiagnosticStatus] = []

    def seen() -> bool:
        statuses[:] = [s for m in received for s in m.status if s.name == "/probe/driver"]
        return bool(statuses)

    running.wait_until(seen, "diagnostics of the driver")
    return statuses


def test_a_driver_that_starts_itself_needs_no_request(session):
    running = session(driver(autostart=True))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    running.wait_until(lambda: len(blocks) >= 20, "samples")
    assert state_of(running) == State.PRIMARY_STATE_ACTIVE


def test_samples_are_numbered_from_zero_and_stamped_at_exactly_2_khz(session):
    running = session(driver())
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    running.wait_until(lambda: len(blocks) >= 100, "half a second of samples")
    joined = join(samples_from_message(block) for block in blocks)
    assert len(joined) == 1
    assert joined[0].sequence == 0
    assert joined[0].sample_period == 0.0005
    assert np.all(np.diff(joined[0].stamps) == 500_000)
    assert all(len(block.position) == 10 for block in blocks)


def test_samples_keep_up_with_the_clock_without_drifting(session):
    running = session(driver())
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    delays = []

    def watch() -> bool:
        while blocks:
            block = samples_from_message(blocks.pop(0))
            delays.append(running.node.get_clock().now().nanoseconds - block.end)
        return len(delays) >= 600

    running.wait_until(watch, "three seconds of samples")
    # The sample clock neither runs ahead (a block comes when its last sample is taken, half a
    # millisecond before the end) nor falls behind by more than the machine's noise.
    assert min(delays) > -1_000_000
    assert abs(np.median(delays[-100:]) - np.median(delays[100:200])) < 20_000_000


def test_each_sample_is_also_published_alone_for_surgical_stacks(session):
    running = session(driver(), stage_on_tissue())
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    poses = collect(running.node, PoseStamped, "/probe/measured_cp")
    wrenches = collect(running.node, WrenchStamped, "/probe/measured_cf")
    assert change_state(running, Transition.TRANSITION_CONFIGURE)
    running.wait_until(
        lambda: running.node.count_publishers("/probe/measured_cf") == 1, "the publishers"
    )
    assert change_state(running, Transition.TRANSITION_ACTIVATE)
    running.wait_until(lambda: len(wrenches) >= 1000 and len(poses) >= 1000, "samples")
    running.wait_until(lambda: 10 * len(blocks) >= len(wrenches), "their blocks")
    run = join(samples_from_message(block) for block in blocks)[0]
    begin = int(np.searchsorted(run.stamps, from_time(wrenches[0].header.stamp)))
    for i, (pose, wrench) in enumerate(zip(poses[:900], wrenches[:900], strict=True)):
        assert from_time(wrench.header.stamp) == run.stamps[begin + i]
        assert wrench.wrench.force.z == run.force[begin + i]
        assert (
            pose.pose.position.z
            == run.position[int(np.searchsorted(run.stamps, from_time(pose.header.stamp)))]
        )


def test_a_new_activation_numbers_its_samples_from_zero_again(session):
    running = session(driver())
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    running.wait_until(lambda: len(blocks) >= 20, "samples")
    deactivate(running)
    count = len(blocks)
    assert change_state(running, Transition.TRANSITION_ACTIVATE)
    running.wait_until(lambda: len(blocks) >= count + 20, "samples again")
    starts = [block.sequence for block in blocks if block.sequence == 0]
    assert starts == [0, 0]
    stamps = [from_time(block.header.stamp) for block in blocks]
    assert all(later > earlier for earlier, later in pairwise(stamps))


def test_the_lifecycle_can_be_gone_through_twice(session):
    running = session(driver())
    for _ in range(2):
        activate(running)
        assert state_of(running) == State.PRIMARY_STATE_ACTIVE
        deactivate(running)
        assert state_of(running) == State.PRIMARY_STATE_INACTIVE
        assert change_state(running, Transition.TRANSITION_CLEANUP)
        assert state_of(running) == State.PRIMARY_STATE_UNCONFIGURED


def test_samples_cut_short_by_deactivation_are_not_lost(session):
    running = session(driver(block_size=1000))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    running.wait_until(lambda: len(blocks) >= 1, "a block")
    deactivate(running)
    running.wait_until(lambda: len(blocks[-1].position) < 1000, "the last, shorter block")
    assert len(join(samples_from_message(block) for block in blocks)) == 1


def test_a_deactivation_lasts_no_longer_than_the_last_samples_are_on_their_way(session):
    """Who has them says so when asked: by itself Fast DDS asks every 3 s."""
    running = session(driver())
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    took = []
    for _ in range(3):
        blocks.clear()
        running.wait_until(lambda: len(blocks) > 5, "samples")
        began = time.monotonic()
        deactivate(running)
        took.append(time.monotonic() - began)
        assert change_state(running, Transition.TRANSITION_ACTIVATE)
    assert min(took) < 1.5


@pytest.mark.parametrize("size", [1, 25])
def test_the_block_size_is_a_parameter(session, size):
    running = session(driver(block_size=size))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    running.wait_until(lambda: len(blocks) >= 10, "samples")
    assert {len(block.position) for block in blocks} == {size}


class Witnessed:
    """A driver in a process of its own, and the voltages that its coil saw."""

    def __init__(self, tmp_path: Path, running, fails_after: int | None, *arguments: str) -> None:
        self._file = tmp_path / "voltages"
        environment = {**os.environ, "WITNESS": str(self._file)}
        if fails_after is not None:
            environment["WITNESS_FAILS_AFTER"] = str(fails_after)
        self.process = subprocess.Popen(
            [
                *(sys.executable, str(Path(__file__).parent / "witness.py"), "--ros-args"),
                *("-r", "__ns:=/probe", "-p", "limits.stale_limit:=5.0", *arguments),
            ],
            env=environment,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        self._running = running

    def voltages(self) -> list[float]:
        return [float(line) for line in self._file.read_text().split()]

    def wait_until_driven(self) -> None:
        self._running.wait_until(lambda: max(map(abs, self.voltages())) > 0.1, "the coil to move")

    def wait_until_zero(self) -> None:
        self._running.wait_until(lambda: self.voltages()[-1] == 0.0, "the coil to be at zero")


@pytest.fixture
def witnessed(tmp_path, session):
    started = []

    def start(*arguments: str, fails_after: int | None = None):
        running = session()
        started.append(Witnessed(tmp_path, running, fails_after, *arguments))
        if fails_after != -1:
            activate(running)
        return running, started[-1]

    yield start
    for each in started:
        each.process.kill()
        each.process.wait()


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_the_coil_is_at_zero_after_the_process_is_told_to_end(witnessed, ending):
    _, driver_process = witnessed()
    driver_process.wait_until_driven()
    driver_process.process.send_signal(ending)
    assert driver_process.process.wait(PATIENCE) == 0
    assert driver_process.voltages()[-1] == 0.0


def test_a_configuration_that_broke_off_half_way_is_let_go_of(witnessed):
    running, driver_process = witnessed(fails_after=-1)
    assert not change_state(running, Transition.TRANSITION_CONFIGURE)
    assert state_of(running) == State.PRIMARY_STATE_UNCONFIGURED
    driver_process.process.send_signal(signal.SIGTERM)
    assert driver_process.process.wait(PATIENCE) == 0


def test_the_coil_is_at_zero_after_deactivation_and_shutdown(witnessed):
    running, driver_process = witnessed()
    driver_process.wait_until_driven()
    deactivate(running)
    assert driver_process.voltages()[-1] == 0.0
    assert change_state(running, Transition.TRANSITION_ACTIVATE)
    running.wait_until(lambda: driver_process.voltages()[-1] != 0.0, "the coil to move again")
    assert change_state(running, Transition.TRANSITION_ACTIVE_SHUTDOWN)
    assert driver_process.voltages()[-1] == 0.0


def test_the_coil_is_at_zero_after_the_loop_crashed_and_the_driver_says_why(witnessed):
    running, driver_process = witnessed(fails_after=2000)
    driver_process.wait_until_driven()
    driver_process.wait_until_zero()
    running.wait_until(lambda: state_of(running) == State.PRIMARY_STATE_INACTIVE, "inactivity")
    status = health_of(running)[-1]
    assert status.level == DiagnosticStatus.ERROR
    assert "a fault that nobody foresaw" in status.message


@pytest.mark.parametrize(
    ("limit", "value", "name"),
    [("limits.travel_limit", "0.0005", "position"), ("limits.force_limit", "0.1", "force")],
)
def test_the_coil_is_at_zero_after_a_limit_was_passed(witnessed, limit, value, name):
    running, driver_process = witnessed("-p", f"{limit}:={value}")
    driver_process.wait_until_driven()
    driver_process.wait_until_zero()
    running.wait_until(lambda: state_of(running) == State.PRIMARY_STATE_INACTIVE, "inactivity")
    status = health_of(running)[-1]
    assert status.level == DiagnosticStatus.ERROR
    assert name in status.message
    assert value.rstrip("0") in status.message


def test_an_excitation_above_the_command_limit_is_refused(session):
    running = session(driver(limits__command_limit=0.5))
    assert change_state(running, Transition.TRANSITION_CONFIGURE)
    assert not change_state(running, Transition.TRANSITION_ACTIVATE)
    assert "command limit of 0.5 V" in running.whole_log("driver")


def test_a_second_driver_is_refused_and_the_first_goes_on(session):
    running = session(driver())
    activate(running)
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    running.wait_until(lambda: bool(blocks), "samples")
    other = session(NodeProcess("driver", "second"))
    other.wait_until(lambda: other.node.count_publishers("/probe/samples") == 1, "the first")
    # Its own process may not have heard of the first: then it is configured, which must not matter.
    configured = change_state(other, Transition.TRANSITION_CONFIGURE, "/probe/second")
    if not configured:
        assert "/probe/driver publishes /probe/samples already" in other.whole_log("second")
    count = len(blocks)
    running.wait_until(lambda: len(blocks) > count + 600, "the first to go on for three seconds")
    assert state_of(running) == State.PRIMARY_STATE_ACTIVE
    assert len(join(samples_from_message(block) for block in blocks)) == 1


def test_a_driver_that_hears_another_ones_samples_gives_way(session):
    running = session(driver())
    activate(running)
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    running.wait_until(lambda: bool(blocks), "samples")
    samples = samples_publisher(running.node)
    # What can publish and does not is borne, however long; what it then says is not.
    running.wait_until(
        lambda: any("could publish" in status.message for status in health_of(running)), "a warning"
    )
    assert state_of(running) == State.PRIMARY_STATE_ACTIVE
    running.wait_until(lambda: samples.get_subscription_count() == 2, "the driver to listen")

    foreign = ProbeSamples(sample_period=5e-4, position=[0.0], force=[0.0], command=[0.0])

    def gave_way() -> bool:
        samples.publish(foreign)
        return state_of(running) == State.PRIMARY_STATE_INACTIVE

    running.wait_until(gave_way, "the driver to give way")
    assert "began to publish /probe/samples too" in health_of(running)[-1].message


def test_a_driver_is_not_activated_beside_another_one(session):
    running = session(driver())
    assert change_state(running, Transition.TRANSITION_CONFIGURE)
    samples = samples_publisher(running.node)
    running.wait_until(lambda: running.node.count_publishers("/probe/samples") == 2, "both")
    assert not change_state(running, Transition.TRANSITION_ACTIVATE)
    assert "publishes /probe/samples already" in running.whole_log("driver")
    running.node.destroy_publisher(samples)


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("excitation.frequency", 1000.0, "from 0.01 to 100 [Hz]"),
        ("excitation.frequency", "fast", "a number from 0.01 to 100 [Hz]"),
        ("block_size", 0, "a whole number from 1 to 2000"),
        ("block_size", 2.5, "a whole number from 1 to 2000"),
        ("device", "teapot", "one of simulated"),
        ("excitation.kind", "sawtooth", "one of sine, stepped_sweep, chirp, multisine"),
        ("simulated.sample_rate", 1.0, "from 500 to 10000 [Hz]"),
    ],
)
def test_a_wrong_parameter_at_start_is_refused_with_range_and_unit(name, value, expected):
    rclpy.init(args=["--ros-args", "-p", f"{name}:={value}"])
    with pytest.raises(SettingsError) as refused:
        Driver()
    rclpy.shutdown()
    assert name in str(refused.value)
    assert expected in str(refused.value)


def test_a_refusal_at_start_ends_the_process_with_one_sentence():
    said = fails_with(driver(block_size=0))
    assert "driver: parameter block_size: give a whole number from 1 to 2000" in said
    assert "Traceback" not in said


def test_a_wrong_parameter_while_running_is_refused_and_a_right_one_is_taken(session):
    running = session(driver())
    assert set_parameter(running, "/probe/driver", "excitation.frequency", 20.0) == (True, "")
    accepted, reason = set_parameter(running, "/probe/driver", "excitation.frequency", 1e3)
    assert not accepted
    accepted, reason = set_parameter(running, "/probe/driver", "excitation.kind", "sawtooth")
    assert not accepted
    assert "one of sine, stepped_sweep, chirp, multisine" in reason


def test_parameters_describe_themselves_with_unit_and_range(session):
    running = session(driver())
    wanted = DescribeParameters.Request(names=["excitation.frequency"])
    answer = ask(running, DescribeParameters, "/probe/driver/describe_parameters", wanted)
    descriptor = answer.descriptors[0]
    assert "[Hz]" in descriptor.description
    assert descriptor.floating_point_range[0].to_value == 100.0


def test_a_parameter_that_does_not_exist_is_told(session):
    running = session(driver(exitation__amplitude=1.0))
    running.wait_until(
        lambda: "no parameter exitation.amplitude" in running.whole_log("driver"), "it"
    )
    assert "excitation.amplitude" in running.whole_log("driver")


def test_a_phantom_that_is_not_there_keeps_the_driver_unconfigured(session, tmp_path):
    running = session(driver(simulated__phantom=str(tmp_path / "none.yaml")))
    assert not change_state(running, Transition.TRANSITION_CONFIGURE)
    assert "none.yaml" in running.whole_log("driver")


def test_a_transition_that_the_state_does_not_have_is_refused_and_survived(session):
    running = session(driver())
    assert not change_state(running, Transition.TRANSITION_DEACTIVATE)
    assert "refused: there is no transition" in running.whole_log("driver")
    activate(running)
    assert not change_state(running, Transition.TRANSITION_CONFIGURE)
    assert state_of(running) == State.PRIMARY_STATE_ACTIVE
