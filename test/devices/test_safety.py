"""Whatever goes wrong behind the guard, the coil is at zero before anyone hears of it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule, run_state_machine_as_test
from pydantic import ValidationError

from tissue_probe.devices import DeviceError, GuardedDevice, LimitExceeded, Limits
from tissue_probe.devices.device import Samples
from tissue_probe.excitation import Sine

LIMITS = Limits(force_limit=8.0, travel_limit=0.006, command_limit=5.0)


class FakeProbe:
    """A device that measures, or fails, as the test says; its coil is live while it runs."""

    sample_period = 5e-4
    samples_per_read = 1
    worst_lateness = 0.25
    description = "fake: true"

    def __init__(self) -> None:
        self.commanded_voltage = 0.0
        self.closed = False
        self.failure: BaseException | None = None
        self.position = 0.0
        self.force = 0.0
        self._excitation: Sine | None = None

    def start(self, excitation: Sine) -> None:
        # A failure comes at the worst moment: the coil is live, the device not yet running.
        self.commanded_voltage = excitation.amplitude
        self._fail()
        self._excitation = excitation

    def read(self, count: int) -> Samples:
        if self._excitation is None:
            raise DeviceError("not started")
        self.commanded_voltage = self._excitation.amplitude
        self._fail()
        values = np.zeros((3, count))
        values[:, -1] = self.position, self.force, self.commanded_voltage
        return Samples(*values)

    def stop(self) -> None:
        self.commanded_voltage = 0.0
        self._excitation = None

    def close(self) -> None:
        self.stop()
        self.closed = True

    def _fail(self) -> None:
        if self.failure is not None:
            failure, self.failure = self.failure, None
            raise failure


FAILURES = (DeviceError, OSError, ZeroDivisionError, MemoryError, KeyboardInterrupt, SystemExit)


class AnyUse(RuleBasedStateMachine):
    """Commands and faults in any order."""

    def __init__(self) -> None:
        super().__init__()
        self.probe = FakeProbe()
        self.guarded = GuardedDevice(self.probe, LIMITS)
        self.driven = False
        self.voltages_at_failures: list[float] = []

    def attempt(self, action, *arguments) -> None:
        try:
            action(*arguments)
        except (*FAILURES, LimitExceeded):
            self.voltages_at_failures.append(self.probe.commanded_voltage)
            self.driven = False

    @rule(failure=st.sampled_from(FAILURES))
    def something_will_fail(self, failure) -> None:
        self.probe.failure = failure("by chance")

    @rule(position=st.floats(-0.01, 0.01), force=st.floats(-12.0, 12.0))
    def the_probe_is_elsewhere(self, position, force) -> None:
        self.probe.position, self.probe.force = position, force

    @rule(amplitude=st.floats(0.1, 9.0))
    def start(self, amplitude) -> None:
        self.driven = True
        self.attempt(self.guarded.start, Sine(amplitude=amplitude))

    @rule(count=st.integers(1, 20))
    def read(self, count) -> None:
        self.attempt(self.guarded.read, count)

    @rule()
    def stop(self) -> None:
        self.guarded.stop()
        self.driven = False

    @rule()
    def close(self) -> None:
        self.guarded.close()
        self.driven = False

    @invariant()
    def the_coil_is_at_zero_as_a_failure_arrives(self) -> None:
        assert not any(self.voltages_at_failures)

    @invariant()
    def the_coil_is_live_only_while_driven_and_within_the_limit(self) -> None:
        assert (self.guarded.commanded_voltage != 0.0) == self.driven
        assert self.probe.commanded_voltage <= LIMITS.command_limit


def test_after_any_failure_in_any_use_the_coil_is_at_zero():
    run_state_machine_as_test(AnyUse, settings=settings(max_examples=150, deadline=None))


def started(**values: float) -> tuple[FakeProbe, GuardedDevice]:
    probe = FakeProbe()
    guarded = GuardedDevice(probe, Limits(**values))
    guarded.start(Sine(amplitude=1.0))
    return probe, guarded


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("quantity", "limit", "value", "said"),
    [
        ("force", "force_limit", 2.0, "the force was {}2.002 N, beyond its limit of 2 N"),
        ("position", "travel_limit", 0.002, "the position was {}0.002002 m, beyond its limit of"),
    ],
)
def test_a_sample_beyond_a_limit_puts_the_coil_at_zero_and_is_named(
    quantity, limit, value, said, sign
):
    probe, guarded = started(**{limit: value})
    setattr(probe, quantity, sign * value)
    guarded.read(5)  # the limit itself is allowed
    assert probe.commanded_voltage == 1.0
    setattr(probe, quantity, sign * 1.001 * value)
    with pytest.raises(LimitExceeded) as raised:
        guarded.read(5)
    assert said.format("-" if sign < 0 else "") in str(raised.value)
    assert probe.commanded_voltage == 0.0
    with pytest.raises(DeviceError):
        guarded.read(1)


@given(position=st.floats(-0.02, 0.02), force=st.floats(-30.0, 30.0), count=st.integers(1, 4))
def test_samples_pass_exactly_if_they_keep_all_limits(position, force, count):
    probe, guarded = started(force_limit=8.0, travel_limit=0.006)
    probe.position, probe.force = position, force
    if abs(position) <= 0.006 and abs(force) <= 8.0:
        samples = guarded.read(count)
        assert (samples.position[-1], samples.force[-1]) == (position, force)
    else:
        with pytest.raises(LimitExceeded):
            guarded.read(count)


@pytest.mark.parametrize("quantity", ["position", "force"])
def test_an_infinite_sample_is_beyond_every_limit(quantity):
    probe, guarded = started()
    setattr(probe, quantity, -np.inf)
    with pytest.raises(LimitExceeded, match="-inf"):
        guarded.read(1)
    assert probe.commanded_voltage == 0.0


def test_a_sample_not_known_is_handed_on():
    probe, guarded = started()
    probe.position = probe.force = np.nan
    assert np.isnan(guarded.read(1).force).all()
    assert probe.commanded_voltage == 1.0


def test_an_excitation_beyond_the_command_limit_is_not_started():
    probe = FakeProbe()
    guarded = GuardedDevice(probe, Limits(command_limit=2.0))
    with pytest.raises(LimitExceeded, match=r"2\.001 V, above the command limit of 2 V: lower it"):
        guarded.start(Sine(amplitude=2.001))
    with pytest.raises(DeviceError):
        guarded.read(1)
    guarded.start(Sine(amplitude=2.0))
    assert probe.commanded_voltage == 2.0


def test_an_excitation_that_is_refused_stops_the_one_before():
    probe, guarded = started(command_limit=2.0)
    with pytest.raises(LimitExceeded):
        guarded.start(Sine(amplitude=3.0))
    assert probe.commanded_voltage == 0.0


def test_a_guarded_device_shows_what_the_device_does():
    guarded = GuardedDevice(FakeProbe(), LIMITS)
    assert guarded.sample_period == 5e-4
    assert guarded.samples_per_read == 1
    assert guarded.worst_lateness == 0.25
    assert guarded.description == "fake: true"


def test_closing_lets_go_of_the_device():
    probe, guarded = started()
    guarded.close()
    assert probe.closed
    assert probe.commanded_voltage == 0.0


@pytest.mark.parametrize("name", Limits.model_fields)
@pytest.mark.parametrize("value", [0.0, -1.0, 1e3, float("nan"), float("inf")])
def test_a_limit_that_would_limit_nothing_is_refused(name, value):
    with pytest.raises(ValidationError):
        Limits(**{name: value})


@pytest.mark.parametrize(
    ("limit", "quantity"), [({"travel_limit": 2e-4}, "position"), ({"force_limit": 0.05}, "force")]
)
def test_a_simulated_probe_that_passes_a_limit_is_stopped(probe, limit, quantity):
    device = probe()
    device.place(0.0, 0.0, 0.0)
    guarded = GuardedDevice(device, Limits(**limit))
    guarded.start(Sine(amplitude=0.85))

    def palpate():
        while True:
            guarded.read(1)

    with pytest.raises(LimitExceeded, match=quantity):
        palpate()
    assert device.commanded_voltage == 0.0


def test_a_simulated_probe_that_lost_samples_is_stopped(probe, clock):
    device = probe()
    guarded = GuardedDevice(device, LIMITS)
    guarded.start(Sine(amplitude=0.85))
    guarded.read(30)
    assert device.commanded_voltage != 0.0
    clock.now += 10.0
    with pytest.raises(DeviceError, match="lost"):
        guarded.read(1)
    assert device.commanded_voltage == 0.0
