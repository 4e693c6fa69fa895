"""Every limit is kept, named when it is passed, and passed by nothing within it."""

from __future__ import annotations

import numpy as np
import pytest
from fake_probe import FakeProbe
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tissue_probe.devices.device import DeviceError, Samples
from tissue_probe.devices.interlock import Interlock
from tissue_probe.devices.limits import LimitExceeded, LimitMonitor, Limits
from tissue_probe.devices.safety import GuardedDevice
from tissue_probe.excitation import Sine
from tissue_probe.settings import bound

AMPERES_PER_VOLT = 0.25
#: Limits that nothing in these tests passes; each test tightens one.
WIDE = {
    "force_limit": 22.0,
    "force_rate_limit": 1e5,
    "travel_limit": 0.0065,
    "command_limit": 10.0,
    "current_limit": 10.0,
    "rms_current_limit": 10.0,
    "stuck_limit": 20.0,
    "stale_limit": 5.0,
}


def started(**tight: float) -> tuple[FakeProbe, GuardedDevice]:
    probe = FakeProbe()
    guarded = GuardedDevice(probe, Limits(**WIDE | tight), AMPERES_PER_VOLT, Interlock())
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
    assert getattr(raised.value.samples, quantity)[-1] == pytest.approx(sign * 1.001 * value)
    assert probe.commanded_voltage == 0.0
    with pytest.raises(DeviceError):
        guarded.read(1)


@given(position=st.floats(-0.02, 0.02), force=st.floats(-30.0, 30.0), count=st.integers(1, 4))
def test_samples_pass_exactly_if_they_keep_all_limits(position, force, count):
    probe, guarded = started(force_limit=8.0, travel_limit=0.006)
    probe.position, probe.force = position, force
    lives = 1e-9 * ((count - 1) % 2)
    if abs(position + lives) <= 0.006 and abs(force) <= 8.0:
        samples = guarded.read(count)
        assert (samples.position[-1], samples.force[-1]) == (position + lives, force)
    else:
        with pytest.raises(LimitExceeded):
            guarded.read(count)
    guarded.stop()


@pytest.mark.parametrize("quantity", ["position", "force"])
def test_an_infinite_sample_is_beyond_every_limit(quantity):
    probe, guarded = started()
    setattr(probe, quantity, -np.inf)
    with pytest.raises(LimitExceeded):
        guarded.read(1)
    assert probe.commanded_voltage == 0.0


@pytest.mark.parametrize("split", [1, 2])
def test_a_force_that_rises_too_fast_is_named_also_across_two_reads(split):
    probe, guarded = started(force_rate_limit=1000.0)
    probe.force = 0.2
    guarded.read(split)
    probe.force = 0.69  # 980 N/s
    guarded.read(3)
    probe.force = 0.1  # -1180 N/s
    with pytest.raises(LimitExceeded, match=r"rate of the force was -1180 N/s, beyond its limit"):
        guarded.read(3)
    assert probe.commanded_voltage == 0.0


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        ({"command_limit": 2.0}, "2.001 V, above the command limit of 2 V: lower it"),
        ({"current_limit": 0.5}, "2.001 V is 0.5 A in the coil, above the current limit of 0.5 A"),
    ],
)
def test_an_excitation_beyond_a_limit_never_reaches_the_device(limits, said):
    probe = FakeProbe()
    guarded = GuardedDevice(probe, Limits(**WIDE | limits), AMPERES_PER_VOLT, Interlock())
    with pytest.raises(LimitExceeded) as raised:
        guarded.start(Sine(amplitude=2.001))
    assert said in str(raised.value)
    assert probe.told == []
    guarded.start(Sine(amplitude=2.0))
    assert probe.commanded_voltage == 2.0
    guarded.stop()


@pytest.mark.parametrize(
    ("limits", "said"),
    [({"command_limit": 1.5}, "command was"), ({"current_limit": 0.375}, "coil current was")],
)
def test_a_device_that_commands_more_than_it_was_told_is_stopped(limits, said):
    probe, guarded = started(**limits)
    probe.gain = 1.49
    guarded.read(200)
    probe.gain = 1.6
    with pytest.raises(LimitExceeded, match=said):
        guarded.read(200)
    assert probe.commanded_voltage == 0.0


def test_a_coil_that_heats_is_stopped_at_its_root_mean_square_and_cools_in_between():
    # 1 V is 0.25 A, or 0.1768 A root mean square.
    _, guarded = started(rms_current_limit=0.18, heating_time=1.0)
    guarded.read(10_000)
    guarded.stop()
    probe, guarded = started(rms_current_limit=0.17, heating_time=0.2)
    guarded.read(200)  # a tenth of a second is too short to heat it
    with pytest.raises(LimitExceeded, match="root mean square of the coil current"):
        guarded.read(2000)
    assert probe.commanded_voltage == 0.0


def test_a_coil_that_was_just_stopped_is_still_hot():
    limits = Limits(**WIDE | {"rms_current_limit": 0.17, "heating_time": 100.0})
    monitor = LimitMonitor(limits, 5e-4, AMPERES_PER_VOLT)
    still = np.zeros(100)

    def seconds_until_hot() -> float:
        monitor.begin()
        for n in range(10_000):
            moving = Samples(1e-6 * (np.arange(100) % 2), still, np.full(100, 1.0))
            try:
                monitor.judge(moving)
            except LimitExceeded:
                return 0.05 * n
        raise AssertionError("never too hot")

    assert seconds_until_hot() == pytest.approx(-100.0 * np.log(1.0 - 0.17**2 / 0.25**2), abs=0.1)
    assert seconds_until_hot() < 1.0


def test_an_encoder_that_stands_still_while_the_command_moves_is_stuck():
    monitor = LimitMonitor(Limits(**WIDE | {"stuck_limit": 0.3}), 5e-4, AMPERES_PER_VOLT)
    still, silent = np.full(10, 1e-4), np.zeros(10)
    monitor.judge(Samples(still, silent, np.linspace(0.0, 0.29, 10)))
    moving = still + 1e-7 * np.arange(10)
    monitor.judge(Samples(moving, silent, np.linspace(0.3, 0.9, 10)))
    still = np.full(10, moving[-1])
    with pytest.raises(LimitExceeded, match=r"encoder stayed at 0\.0001009 m while the command"):
        monitor.judge(Samples(still, silent, np.linspace(0.9, 0.5, 10)))


def test_an_encoder_may_stand_still_under_a_command_that_does():
    monitor = LimitMonitor(Limits(**WIDE | {"stuck_limit": 0.3}), 5e-4, AMPERES_PER_VOLT)
    for _ in range(1000):
        monitor.judge(Samples(np.zeros(10), np.zeros(10), np.full(10, 0.8)))


@pytest.mark.parametrize("force", [20.0, -20.0, 21.0])
def test_a_force_at_the_end_of_what_can_be_measured_is_saturated(force):
    monitor = LimitMonitor(Limits(**WIDE), 5e-4, AMPERES_PER_VOLT, (-20.0, 20.0))
    values = np.full(10, 0.999 * force * 20.0 / abs(force))
    monitor.judge(Samples(1e-6 * np.arange(10.0), values, np.zeros(10)))
    values[4] = force
    with pytest.raises(LimitExceeded, match="saturated") as raised:
        monitor.judge(Samples(1e-6 * np.arange(10.0), values, np.zeros(10)))
    assert raised.value.samples.force[4] == force


@pytest.mark.parametrize("quantity", ["position", "force"])
def test_a_sample_not_known_is_handed_on_but_not_for_long(quantity):
    probe, guarded = started(stale_limit=0.1)
    setattr(probe, quantity, np.nan)
    for _ in range(200):  # 1 sample each, 0.1 s
        assert np.isnan(getattr(guarded.read(1), quantity)).all()
    with pytest.raises(LimitExceeded, match=r"unknown for 0\.101 s"):
        guarded.read(1)
    assert probe.commanded_voltage == 0.0


@pytest.mark.parametrize("name", Limits.model_fields)
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_a_limit_that_would_limit_nothing_is_refused(name, value):
    with pytest.raises(ValidationError):
        Limits(**{name: value})
    with pytest.raises(ValidationError):
        Limits(**{name: 1.001 * bound(Limits.model_fields[name], "le")})
