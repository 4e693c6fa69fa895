"""The device on a DAQ, over a real socket, against a server that speaks the vendor's protocol."""

from __future__ import annotations

import dataclasses
import time

import grpc
import numpy as np
import pytest
import yaml
from nidaqmx.error_codes import DAQmxErrors
from nidaqmx.errors import RpcError

from daq_server import CDAQ, USB_6002, X_SERIES, Board, DaqServer, Stepped
from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration
from tissue_probe.devices.device import DeviceError
from tissue_probe.devices.interlock import Interlock
from tissue_probe.devices.limits import LimitExceeded, Limits
from tissue_probe.devices.nidaqmx.decoder import SampleClock
from tissue_probe.devices.nidaqmx.errors import convert_errors
from tissue_probe.devices.nidaqmx.probe import NiDaqmxProbe
from tissue_probe.devices.nidaqmx.settings import NiDaqmxSettings
from tissue_probe.devices.safety import GuardedDevice, Tripped
from tissue_probe.estimation import Estimator, EstimatorSettings
from tissue_probe.excitation import Chirp, Multisine, Sine, SteppedSweep
from tissue_probe.signals import FloatArray, SampleBlock

CALIBRATION = Calibration.load(stock_configuration("calibration.yaml"))
DRIVE = Sine(frequency=10.0, amplitude=0.85)
PATIENCE = 10.0
#: Half a step of the drive next to a zero: what a dry buffer may hold [V].
HELD = 0.5 * DRIVE.amplitude * 2.0 * np.pi * DRIVE.frequency * 5e-4


class Bench:
    """A DAQ, its server, and probes on it; where they share a clock, nothing asks the machine's."""

    def __init__(
        self,
        model,
        calibration: Calibration = CALIBRATION,
        shared: Stepped | None = None,
        **board: object,
    ) -> None:
        self.calibration, self.clock = calibration, shared
        self._probes = {"clock": shared} if shared else {}
        board |= {"clock": shared, "wait": shared.wait} if shared else {}
        self.board = Board(model, calibration, **board)
        self.server = DaqServer(self.board)
        self.probes: list[NiDaqmxProbe] = []

    def probe(self, **settings: object) -> NiDaqmxProbe:
        # A busy machine may be late by a second.
        common = {"server": self.server.address, "timeout": 1.0, "expiry": 2.0}
        chosen = NiDaqmxSettings(**common | settings)
        self.probes.append(NiDaqmxProbe(chosen, self.calibration, **self._probes))
        return self.probes[-1]

    def wait_until_coil_rests(self, largest: float) -> None:
        """Wait until the coil has been within ``largest`` [V] of zero for a tenth of a second."""
        end = time.monotonic() + PATIENCE
        since = time.monotonic()
        while time.monotonic() - since < 0.1:
            if abs(self.server.coil_voltage) > largest:
                since = time.monotonic()
            assert time.monotonic() < end, "the coil is driven on"
            time.sleep(0.002)

    def close(self) -> None:
        self.board.faults.clear()
        for probe in self.probes:
            probe.close()
        self.server.die()


@pytest.fixture
def live_bench():
    """Make DAQs in the machine's time, or in that of a clock that is given."""
    made: list[Bench] = []

    def make(model=X_SERIES, **more: object) -> Bench:
        made.append(Bench(model, **more))
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.fixture
def bench(live_bench):
    """Make DAQs whose time passes only where they wait: no machine is too slow for them."""
    return lambda model=X_SERIES, **more: live_bench(model, shared=Stepped(), **more)


def read_seconds(probe, seconds: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    blocks = [probe.read(10) for _ in range(round(seconds / probe.sample_period / 10.0))]
    return tuple(
        np.concatenate([getattr(block, name) for block in blocks])
        for name in ("position", "force", "command")
    )


def test_force_and_position_are_those_of_the_tissue_behind_the_channels(bench):
    probe = bench(stiffness=700.0, damping=6.0).probe()
    probe.start(DRIVE)
    block = SampleBlock(0, 0, probe.sample_period, *read_seconds(probe, 1.5))
    found = Estimator("robust_ekf", EstimatorSettings()).process(block)
    assert found.stiffness[-1] == pytest.approx(700.0, rel=0.01)
    assert found.damping[-1] == pytest.approx(6.0, rel=0.05)


def test_polarity_and_scale_are_the_calibrations(bench):
    turned = CALIBRATION.changed(
        force_polarity="tension", force_offset_volts=0.3, position_per_count=-5e-8
    )
    straight, other = bench().probe(), bench(calibration=turned).probe()
    runs = []
    for probe in (straight, other):
        probe.start(DRIVE)
        runs.append(read_seconds(probe, 0.3))
    np.testing.assert_allclose(runs[0][0], runs[1][0], atol=1.01e-7)
    np.testing.assert_allclose(runs[0][1], runs[1][1], atol=2.0 * 20.0 / 2**16)


@pytest.mark.parametrize("model", [X_SERIES, CDAQ])
def test_command_and_measurement_begin_together_every_time(bench, model):
    probe = bench(model).probe()
    firsts = []
    for _ in range(3):
        probe.start(Sine(frequency=50.0, amplitude=2.0))
        firsts.append(read_seconds(probe, 0.05)[0])
        probe.stop()
    assert np.ptp(firsts[0]) > 20e-6
    for first in firsts[1:]:
        np.testing.assert_allclose(first, firsts[0], atol=1e-9)


@pytest.mark.parametrize(
    ("excitation", "model", "written"),
    [
        (DRIVE, CDAQ, "regenerates"),
        (Multisine(amplitude=0.5), CDAQ, "regenerates"),
        (Sine(frequency=np.pi), CDAQ, "is streamed"),
        (DRIVE, X_SERIES, "is streamed"),
        (Chirp(amplitude=0.5), X_SERIES, "is streamed"),
        (SteppedSweep(amplitude=0.5), X_SERIES, "is streamed"),
    ],
)
def test_what_repeats_is_regenerated_by_a_daq_that_can_end_it(bench, excitation, model, written):
    made = bench(model)
    probe = made.probe()
    probe.start(excitation)
    _, _, command = read_seconds(probe, 1.5)
    np.testing.assert_allclose(command, excitation(np.arange(3000) * 5e-4), atol=1e-9)
    assert made.board.generation.regenerates == (written == "regenerates")


@pytest.mark.parametrize("model", [X_SERIES, CDAQ])
def test_the_coil_goes_to_zero_by_itself_when_the_driver_falls_silent(bench, model):
    made = bench(model)
    probe = made.probe(expiry=0.2)
    probe.start(DRIVE)
    read_seconds(probe, 0.3)
    assert not made.board.expired
    # From here on nobody reads. Half a step next to a zero is what a dry buffer may hold.
    made.clock.wait(2.0)
    for _ in range(200):
        assert abs(made.server.coil_voltage) <= (0.0 if model is CDAQ else HELD)
        made.clock.wait(5e-4)
    assert made.board.expired or made.board.generation.ran_dry


def test_an_expired_watchdog_does_not_hinder_the_next_start(bench):
    made = bench(CDAQ)
    probe = made.probe(expiry=0.05)
    probe.start(DRIVE)
    made.clock.wait(0.06)
    assert made.server.coil_voltage == 0.0
    assert made.board.expired
    probe.start(DRIVE)
    assert np.ptp(read_seconds(probe, 0.1)[0]) > 0.0


def test_a_slow_swing_is_refused_where_no_watchdog_would_end_it(bench):
    slow = Sine(frequency=0.1)
    with pytest.raises(DeviceError, match="no watchdog"):
        bench(X_SERIES).probe().start(slow)
    probe = bench(CDAQ).probe()
    probe.start(slow)
    probe.read(10)


def test_a_driver_that_died_leaves_nothing_that_its_successor_could_not_clear(bench):
    made = bench()
    made.probe().start(DRIVE)  # and is never stopped
    successor = made.probe()
    assert made.server.coil_voltage == 0.0
    successor.start(DRIVE)
    assert successor.read(10).force.size == 10


def test_the_coil_is_at_zero_within_a_block_of_the_stop(bench):
    made = bench()
    probe = made.probe()
    probe.start(DRIVE)
    for _ in range(10):
        read_seconds(probe, 0.02)
        begin = made.clock()
        probe.stop()
        assert made.server.coil_voltage == 0.0
        assert made.clock() - begin < 10 * probe.sample_period
        probe.start(DRIVE)


def test_the_description_tells_what_ends_the_output(bench):
    told = yaml.safe_load(bench(X_SERIES).probe().description)
    assert told["daq"] == "PCIe-6321"
    assert "buffer runs dry" in told["coil_driven_after_death"]
    told = yaml.safe_load(bench(CDAQ).probe().description)
    assert "watchdog" in told["coil_driven_after_death"]


def test_a_daq_without_quadrature_counter_is_refused_with_the_way_out(bench):
    with pytest.raises(DeviceError, match=r"no quadrature counter.*hctl2032"):
        bench(USB_6002).probe()


def test_the_decoder_on_static_lines_is_refused_at_2_khz_with_the_rate_it_reaches(bench):
    with pytest.raises(DeviceError, match=r"can be read 89 times a second.*, not 2000: give"):
        bench(USB_6002).probe(encoder="hctl2032")


def test_the_decoder_follows_the_probe_at_a_rate_that_it_can_hold(bench):
    probe = bench(USB_6002).probe(encoder="hctl2032", sample_rate=80.0)
    probe.start(Sine(frequency=0.8, amplitude=0.85))
    position, force, command = (
        np.concatenate(each)
        for each in zip(
            *[(b.position, b.force, b.command) for b in (probe.read(5) for _ in range(40))],
            strict=True,
        )
    )
    assert np.ptp(position) == pytest.approx(1.7e-3, rel=0.35)
    # Quasi-static: position follows force and command.
    assert np.corrcoef(position[4:], force[4:])[0, 1] > 0.98
    assert np.corrcoef(position[4:], command[3:-1])[0, 1] > 0.9


def test_a_decoder_that_becomes_too_slow_is_told_and_no_stale_position_delivered(bench):
    made = bench(USB_6002)
    probe = made.probe(encoder="hctl2032", sample_rate=80.0)
    probe.start(Sine(frequency=0.5))
    probe.read(3)
    made.board.model = dataclasses.replace(USB_6002, digital_time=2e-3)
    with pytest.raises(DeviceError, match="HCTL-2032 was read too late"):
        probe.read(3)


def test_between_readings_of_the_decoder_the_position_is_that_of_the_coil(bench):
    """The paper's own DAQ: 1 ms for each of the nine operations of a reading."""
    made = bench(USB_6002, stiffness=700.0, damping=6.0)
    probe = made.probe(encoder="hctl2032_interpolated")
    probe.start(Sine(frequency=1.0, amplitude=0.85))
    block = SampleBlock(0, 0, probe.sample_period, *read_seconds(probe, 3.0))
    assert block.sample_period == 0.0005
    settings = EstimatorSettings(encoder_resolution=2e-6)
    found = Estimator("robust_ekf", settings).process(block)
    assert found.stiffness[-1] == pytest.approx(700.0, rel=0.02)
    # Later than its instant by half an operation: k for each second.
    assert found.damping[-1] == pytest.approx(6.0 - 700.0 * 0.5e-3, rel=0.01)


def test_readings_are_placed_in_time_by_the_samples_that_arrived_soonest():
    """Samples arrive up to 20 ms late, and the DAQ's clock is 50 ppm fast."""
    random, clock = np.random.default_rng(3), SampleClock(5e-4)
    rate, begin = 2000.0 * (1.0 + 5e-5), 5000.0
    for now in begin + np.arange(0.025, 60.0, 0.025):
        clock.see(int(rate * (now - random.uniform(0.0, 0.02) - begin)) + 1, now)
    assert clock.samples_at(now) == pytest.approx(rate * (now - begin), abs=2.0)


def test_an_excitation_that_the_decoder_cannot_follow_is_refused_with_one_that_it_can(bench):
    probe = bench(USB_6002).probe(encoder="hctl2032_interpolated")
    # Nine operations of 1 ms a reading, eight readings a period: 13.9 Hz.
    with pytest.raises(DeviceError, match="too seldom for 14 Hz: drive the coil at 13 Hz or"):
        probe.start(Sine(frequency=14.0))
    probe.start(Sine(frequency=13.0))


def test_where_readings_are_too_rare_to_follow_the_coil_its_position_is_unknown(bench):
    made = bench(USB_6002)
    probe = made.probe(encoder="hctl2032_interpolated")
    probe.start(Sine(frequency=1.0))
    assert np.isfinite(read_seconds(probe, 0.2)[0]).any()
    made.board.model = dataclasses.replace(USB_6002, digital_time=0.02)
    position, force, _ = read_seconds(probe, 0.6)
    assert np.isnan(position[-100:]).all()
    assert np.isfinite(force).all()


@pytest.mark.parametrize("skew", [2, -3])
def test_a_delay_that_the_calibration_knows_is_taken_out(bench, skew):
    found = {}
    for known in (True, False):
        calibration = CALIBRATION.changed(force_delay=5e-4 * skew * known)
        probe = bench(calibration=calibration, skew=skew).probe()
        probe.start(Sine(frequency=25.0, amplitude=2.0))
        block = SampleBlock(0, 0, probe.sample_period, *read_seconds(probe, 0.8))
        found[known] = Estimator("robust_ekf", EstimatorSettings()).process(block)
    assert found[True].stiffness[-1] == pytest.approx(450.0, rel=0.02)
    assert found[True].damping[-1] == pytest.approx(5.0, rel=0.05)
    assert abs(found[False].damping[-1] - 5.0) > 0.1 * 5.0


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"device": "Dev2"}, "no DAQ of this name: check nidaqmx.device"),
        ({"force_channel": "bi0"}, "no such channel: check the names"),
        ({"server": "127.0.0.1:1"}, "gRPC device server does not answer: is it running"),
    ],
)
def test_what_is_wired_wrongly_is_told_in_one_sentence(bench, settings, said):
    with pytest.raises(DeviceError) as raised:
        bench().probe(**settings)
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_rate_beyond_the_daqs_is_refused(bench):
    with pytest.raises(DeviceError, match="USB-6002, plays and measures at most 5000 samples"):
        bench(USB_6002).probe(sample_rate=8000.0)


def test_the_sample_period_is_the_one_the_daqs_clock_makes(bench):
    probe = bench().probe(sample_rate=1999.0)
    assert probe.sample_period == pytest.approx(round(80e6 / 1999.0) / 80e6, rel=1e-12)


def test_without_ni_daqmx_on_this_machine_the_way_out_is_told():
    with pytest.raises(DeviceError, match=r"NI-DAQmx is not installed.*nidaqmx\.server"):
        NiDaqmxProbe(NiDaqmxSettings(), CALIBRATION)


def gone(code: DAQmxErrors):
    def unplug(made: Bench) -> None:
        made.board.faults.gone = code

    return unplug


FAULTS = {
    "overrun": (lambda made: setattr(made.board.faults, "overrun", True), "are lost.*-200279"),
    "gone": (gone(DAQmxErrors.DEV_CANNOT_BE_ACCESSED), "the DAQ is gone.*-201003"),
    "unplugged": (
        gone(DAQmxErrors.DRIVER_DEVICE_GUID_NOT_FOUND_ROUTING),
        "the DAQ is gone.*-88705",
    ),
    "stall": (lambda made: setattr(made.board.faults, "stalled", True), "no sample came for 1 s"),
    "dead": (lambda made: made.server.die(), "gRPC device server does not answer"),
    "saturated": (
        lambda made: setattr(made.board.faults, "saturated", True),
        "load cell's input is saturated",
    ),
    "stuck": (lambda made: setattr(made.board.faults, "stuck", True), "the encoder stayed at"),
}


@pytest.mark.parametrize("model", [X_SERIES, CDAQ])
@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_has_its_sentence_and_ends_with_the_coil_at_zero(live_bench, name, model):
    fault, said = FAULTS[name]
    made = live_bench(model)
    interlock = Interlock()
    device = made.probe(expiry=1.0)
    guarded = GuardedDevice(device, Limits(stale_limit=1.0), 0.28, interlock)
    guarded.start(DRIVE)
    read_seconds(guarded, 0.2)
    fault(made)
    with pytest.raises((DeviceError, LimitExceeded), match=said):
        read_seconds(guarded, 3.0)
    assert interlock.tripped
    assert "\n" not in interlock.reason
    assert guarded.commanded_voltage == 0.0
    with pytest.raises(Tripped):
        guarded.start(DRIVE)
    # A dead server cannot be told: then what the DAQ itself does counts.
    made.wait_until_coil_rests(HELD)


def test_lateness_is_how_long_samples_wait(live_bench):
    now = [0.0]
    made = live_bench(X_SERIES, clock=lambda: now[0])
    probe = made.probe()
    assert probe.worst_lateness == 0.0
    probe.start(DRIVE)
    now[0] = 0.5
    assert probe.worst_lateness == pytest.approx(0.5, abs=0.001)
    probe.read(500)
    assert probe.worst_lateness == pytest.approx(0.25, abs=0.001)


def test_a_driver_that_fell_behind_soon_has_all_that_waited(live_bench):
    now = [0.0]
    made = live_bench(X_SERIES, clock=lambda: now[0])
    probe = made.probe()
    probe.start(DRIVE)
    now[0] = 0.4
    commands = np.concatenate([probe.read(10).command for _ in range(20)])
    assert len(made.board.acquisition) == 0
    np.testing.assert_allclose(commands, DRIVE(np.arange(200) * 5e-4), atol=1e-9)


def test_a_server_that_dies_while_it_answers_is_told_as_one_that_is_gone():
    with (
        pytest.raises(DeviceError, match="gRPC device server does not answer"),
        convert_errors("the DAQ cannot be read"),
    ):
        raise RpcError(grpc.StatusCode.CANCELLED, "CANCELLED")
