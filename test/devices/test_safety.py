"""Whatever goes wrong behind the guard, the coil is at zero before anyone hears of it."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from fake_probe import FakeProbe
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule, run_state_machine_as_test

from tissue_probe.devices.device import DeviceError, Samples
from tissue_probe.devices.interlock import Interlock
from tissue_probe.devices.limits import LimitExceeded, Limits
from tissue_probe.devices.safety import GuardedDevice, Tripped
from tissue_probe.excitation import Sine

LIMITS = Limits(command_limit=5.0, current_limit=1.0, rms_current_limit=0.5, heating_time=0.01)
AMPERES_PER_VOLT = 0.25

FAILURES = (DeviceError, OSError, ZeroDivisionError, MemoryError, KeyboardInterrupt, SystemExit)


def guard(probe: FakeProbe, interlock: Interlock | None = None, **limits: float) -> GuardedDevice:
    chosen = LIMITS.model_copy(update=limits)
    return GuardedDevice(probe, chosen, AMPERES_PER_VOLT, interlock or Interlock())


class AnyUse(RuleBasedStateMachine):
    """Commands, faults, trips and resets in any order."""

    def __init__(self) -> None:
        super().__init__()
        self.probe = FakeProbe()
        self.interlock = Interlock()
        self.guarded = guard(self.probe, self.interlock)
        self.driven = False
        self.told_before_trip: int | None = None
        self.voltages_at_failures: list[float] = []

    def attempt(self, action, *arguments) -> None:
        try:
            action(*arguments)
        except (*FAILURES, LimitExceeded):
            self.voltages_at_failures.append(self.probe.commanded_voltage)
            self.driven = False
        if self.interlock.tripped and self.told_before_trip is None:
            self.told_before_trip = len(self.probe.told)

    @rule(failure=st.sampled_from(FAILURES))
    def something_will_fail(self, failure) -> None:
        self.probe.failure = failure("by chance")

    @rule(position=st.floats(-0.01, 0.01), force=st.floats(-12.0, 12.0) | st.just(np.nan))
    def the_probe_is_elsewhere(self, position, force) -> None:
        self.probe.position, self.probe.force = position, force

    @rule(gain=st.sampled_from([1.0, 1.0, 3.0, -2.0]))
    def the_device_commands_what_it_likes(self, gain) -> None:
        self.probe.gain = gain

    @rule(amplitude=st.floats(0.1, 9.0), frequency=st.floats(1.0, 100.0))
    def start(self, amplitude, frequency) -> None:
        self.driven = True
        self.attempt(self.guarded.start, Sine(amplitude=amplitude, frequency=frequency))

    @rule(count=st.integers(1, 40))
    def read(self, count) -> None:
        self.attempt(self.guarded.read, count)

    @rule()
    def emergency_stop(self) -> None:
        self.guarded.trip("by hand")
        self.driven = False
        self.attempt(lambda: None)

    @rule()
    def reset(self) -> None:
        self.interlock.reset()
        self.told_before_trip = None

    @rule()
    def stop(self) -> None:
        self.guarded.stop()
        self.driven = False

    @rule()
    def close(self) -> None:
        self.guarded.close()
        self.driven = False

    def teardown(self) -> None:
        self.guarded.close()

    @invariant()
    def the_coil_is_at_zero_as_a_failure_arrives(self) -> None:
        assert not any(self.voltages_at_failures)

    @invariant()
    def the_coil_is_live_only_while_driven(self) -> None:
        assert (self.guarded.commanded_voltage != 0.0) == self.driven

    @invariant()
    def no_command_beyond_the_limits_is_ever_told(self) -> None:
        allowed = min(LIMITS.command_limit, LIMITS.current_limit / AMPERES_PER_VOLT)
        assert max(self.probe.told, default=0.0) <= allowed

    @invariant()
    def nothing_is_told_after_a_trip_until_the_reset(self) -> None:
        if self.interlock.tripped:
            assert self.probe.commanded_voltage == 0.0
            assert len(self.probe.told) == self.told_before_trip


@pytest.mark.slow
@pytest.mark.parametrize("runs", [150, pytest.param(600, marks=pytest.mark.battery)])
def test_in_any_of_thousands_of_uses_nothing_is_driven_beyond_limits_or_after_a_trip(runs):
    run_state_machine_as_test(
        AnyUse, settings=settings(max_examples=runs, stateful_step_count=20, deadline=None)
    )


def started(interlock: Interlock | None = None) -> tuple[FakeProbe, GuardedDevice]:
    probe = FakeProbe()
    guarded = guard(probe, interlock)
    guarded.start(Sine(amplitude=1.0))
    return probe, guarded


@pytest.mark.parametrize("failure", FAILURES)
def test_a_failure_while_it_runs_trips_and_only_a_reset_arms_again(failure):
    interlock = Interlock()
    probe, guarded = started(interlock)
    probe.failure = failure("the cable is out")
    with pytest.raises(failure):
        guarded.read(1)
    assert interlock.reason == "the cable is out"
    for _ in range(2):
        with pytest.raises(Tripped, match="the cable is out"):
            guarded.read(1)
        with pytest.raises(Tripped, match="the cable is out"):
            guarded.start(Sine(amplitude=1.0))
        assert probe.commanded_voltage == 0.0
    assert len(probe.told) == 1
    interlock.reset()
    guarded.start(Sine(amplitude=1.0))
    assert guarded.read(5).position.size == 5
    guarded.stop()


def test_the_trip_outlives_the_device():
    interlock = Interlock()
    _, guarded = started(interlock)
    guarded.trip("by hand")
    guarded.close()
    with pytest.raises(Tripped, match="by hand"):
        guard(FakeProbe(), interlock).start(Sine(amplitude=1.0))


def test_the_first_reason_stays():
    interlock = Interlock()
    interlock.trip("first")
    interlock.trip("second")
    assert interlock.reason == "first"


def test_what_fails_before_it_runs_does_not_trip():
    interlock = Interlock()
    probe = FakeProbe()
    guarded = guard(probe, interlock)
    with pytest.raises(DeviceError):
        guarded.read(1)
    probe.failure = DeviceError("not plugged in")
    with pytest.raises(DeviceError, match="not plugged in"):
        guarded.start(Sine(amplitude=1.0))
    assert not interlock.tripped
    assert probe.commanded_voltage == 0.0


class StallingProbe(FakeProbe):
    """Its read never ends by itself; a stop from another thread ends it, as a DAQ's does."""

    def __init__(self) -> None:
        super().__init__()
        self.stopped = threading.Event()

    def read(self, count: int) -> Samples:
        self.stopped.clear()
        assert self.stopped.wait(20.0)
        raise DeviceError("the task was stopped")

    def stop(self) -> None:
        super().stop()
        self.stopped.set()


def test_a_read_that_stalls_is_ended_with_the_coil_at_zero():
    probe, interlock = StallingProbe(), Interlock()
    guarded = guard(probe, interlock, stale_limit=0.05)
    guarded.start(Sine(amplitude=1.0))
    with pytest.raises(Tripped, match="no sample came for 0\\.05 s"):
        guarded.read(10)
    assert probe.commanded_voltage == 0.0


def test_samples_that_nobody_reads_trip_it_too():
    probe, interlock = FakeProbe(), Interlock()
    stopped = threading.Event()
    stop, probe.stop = probe.stop, lambda: (stop(), stopped.set())
    guarded = guard(probe, interlock, stale_limit=0.05)
    guarded.start(Sine(amplitude=1.0))
    stopped.clear()
    assert stopped.wait(20.0)
    assert "no sample came" in interlock.reason
    assert probe.commanded_voltage == 0.0


def test_an_emergency_stop_does_not_wait_for_the_read_under_way():
    probe, interlock = StallingProbe(), Interlock()
    guarded = guard(probe, interlock, stale_limit=5.0)
    guarded.start(Sine(amplitude=1.0))
    raised: list[BaseException] = []

    def read() -> None:
        try:
            guarded.read(10)
        except DeviceError as error:
            raised.append(error)

    reader = threading.Thread(target=read)
    reader.start()
    guarded.trip("someone pressed the button")
    assert probe.commanded_voltage == 0.0
    probe.stopped.set()
    reader.join(20.0)
    assert [str(error) for error in raised] == ["someone pressed the button"]


class TrippedWhileStarting(FakeProbe):
    def __init__(self, interlock: Interlock) -> None:
        super().__init__()
        self._interlock = interlock

    def start(self, excitation: Sine) -> None:
        self._interlock.trip("pressed just now")
        super().start(excitation)


def test_an_emergency_stop_in_the_middle_of_a_start_wins():
    interlock = Interlock()
    probe = TrippedWhileStarting(interlock)
    guarded = guard(probe, interlock)
    with pytest.raises(Tripped, match="pressed just now"):
        guarded.start(Sine(amplitude=1.0))
    assert probe.commanded_voltage == 0.0


class DeafProbe(FakeProbe):
    def stop(self) -> None:
        super().stop()
        raise DeviceError("the coil could not be put at zero")


def test_a_coil_that_cannot_be_put_at_zero_trips():
    interlock = Interlock()
    guarded = guard(DeafProbe(), interlock)
    guarded.stop()
    assert interlock.reason == "the coil could not be put at zero"


def test_an_excitation_that_is_refused_stops_the_one_before():
    probe, guarded = started()
    with pytest.raises(LimitExceeded):
        guarded.start(Sine(amplitude=6.0))
    assert probe.commanded_voltage == 0.0


def test_a_guarded_device_shows_what_the_device_does():
    guarded = guard(FakeProbe())
    assert guarded.sample_period == 5e-4
    assert guarded.samples_per_read == 1
    assert guarded.force_range == (-np.inf, np.inf)
    assert guarded.worst_lateness == 0.25
    assert guarded.description == "fake: true"


def test_closing_lets_go_of_the_device():
    probe, guarded = started()
    guarded.close()
    assert probe.closed
    assert probe.commanded_voltage == 0.0


@pytest.mark.parametrize(
    ("limit", "quantity"), [({"travel_limit": 2e-4}, "position"), ({"force_limit": 0.05}, "force")]
)
def test_a_simulated_probe_that_passes_a_limit_is_stopped(probe, limit, quantity):
    device = probe()
    device.place(0.0, 0.0, 0.0)
    guarded = GuardedDevice(device, Limits(**limit), 0.28, Interlock())
    guarded.start(Sine(amplitude=0.85))

    def palpate():
        while True:
            guarded.read(1)

    with pytest.raises(LimitExceeded, match=quantity):
        palpate()
    assert device.commanded_voltage == 0.0


def test_a_simulated_probe_that_lost_samples_is_stopped(probe, clock):
    device = probe()
    guarded = GuardedDevice(device, Limits(), 0.28, Interlock())
    guarded.start(Sine(amplitude=0.85))
    guarded.read(30)
    assert device.commanded_voltage != 0.0
    clock.now += 10.0
    with pytest.raises(DeviceError, match="lost"):
        guarded.read(1)
    assert device.commanded_voltage == 0.0
