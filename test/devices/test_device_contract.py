"""What every device must do, whoever made it: one suite over the table ``DEVICES``."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
import yaml
from pydantic import BaseModel

from daq_server import X_SERIES, Board, DaqServer
from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration
from tissue_probe.devices.device import Device, DeviceError
from tissue_probe.devices.interlock import Interlock
from tissue_probe.devices.limits import Limits
from tissue_probe.devices.nidaqmx.probe import NiDaqmxProbe
from tissue_probe.devices.registry import DEVICES
from tissue_probe.devices.safety import GuardedDevice
from tissue_probe.excitation import Chirp, Multisine, Sine, SteppedSweep
from tissue_probe.settings import rule

CALIBRATION = Calibration.load(stock_configuration("calibration.yaml"))
DRIVE = Sine(amplitude=0.5)


@pytest.fixture(params=DEVICES)
def device_type(request):
    return DEVICES[request.param].load()


@pytest.fixture
def device_settings(device_type):
    """Settings with which a device can be made here: a DAQ is reached over a socket."""
    if device_type is not NiDaqmxProbe:
        yield device_type.Settings()
        return
    with DaqServer(Board(X_SERIES, CALIBRATION)) as server:
        yield device_type.Settings(server=server.address)


@pytest.fixture(params=[False, True], ids=["bare", "guarded"])
def device(request, device_type, device_settings):
    made = device_type(device_settings, CALIBRATION)
    device = GuardedDevice(made, Limits(), 0.28, Interlock()) if request.param else made
    yield device
    device.close()


def test_its_settings_have_defaults_and_say_their_meaning_and_unit(device_type):
    assert issubclass(device_type.Settings, BaseModel)
    device_type.Settings()
    for name, field in device_type.Settings.model_fields.items():
        assert field.description, f"{name} says nothing"
        if field.annotation is float:
            assert rule(field).endswith("]"), f"{name} has no unit"
            assert " from " in rule(field) or " above " in rule(field), f"{name} has no range"


def test_it_has_what_a_device_has(device):
    assert device.sample_period > 0.0
    assert device.samples_per_read >= 1
    assert device.commanded_voltage == 0.0
    assert device.worst_lateness >= 0.0
    assert isinstance(yaml.safe_load(device.description), dict)


@pytest.mark.parametrize("method", ["start", "read", "stop", "close"])
def test_its_methods_take_what_the_interface_says(device, method):
    wanted = inspect.signature(getattr(Device, method))
    given = inspect.signature(getattr(type(device), method))
    assert list(given.parameters) == list(wanted.parameters)


@pytest.mark.parametrize("excitation", [DRIVE, SteppedSweep(), Chirp(), Multisine()], ids=type)
def test_it_plays_every_excitation_from_its_beginning(device, excitation):
    for _ in range(2):
        device.start(excitation)
        taken = device.read(40)
        expected = excitation(np.arange(40) * device.sample_period)
        assert taken.command == pytest.approx(expected, abs=1e-12)
        device.stop()


def test_a_read_brings_as_many_finite_samples_as_asked_for(device):
    device.start(DRIVE)
    for count in (1, device.samples_per_read, 50):
        samples = device.read(count)
        for values in (samples.position, samples.force, samples.command):
            assert values.shape == (count,)
            assert np.isfinite(values).all()


def test_no_sample_is_read_twice_or_lost_between_reads(device):
    device.start(DRIVE)
    commands = np.concatenate([device.read(count).command for count in (3, 1, 20, 16)])
    assert commands == pytest.approx(DRIVE(np.arange(40) * device.sample_period), abs=1e-12)


def test_the_commanded_voltage_is_that_of_the_last_sample(device):
    device.start(DRIVE)
    last = device.read(30).command[-1]
    assert last != 0.0
    assert device.commanded_voltage == last


def test_what_was_read_is_not_changed_by_what_is_read_later(device):
    device.start(DRIVE)
    samples = device.read(10)
    kept = samples.position.copy(), samples.force.copy(), samples.command.copy()
    device.read(200)
    np.testing.assert_array_equal((samples.position, samples.force, samples.command), kept)


@pytest.mark.parametrize("ending", ["stop", "close"])
def test_the_coil_is_at_zero_after_every_ending_any_number_of_times(device, ending):
    end = getattr(device, ending)
    end()
    device.start(DRIVE)
    end()
    assert device.commanded_voltage == 0.0
    device.start(DRIVE)
    device.read(30)
    for _ in range(3):
        end()
        assert device.commanded_voltage == 0.0


def test_reading_without_a_start_or_after_a_stop_is_refused(device):
    with pytest.raises(DeviceError):
        device.read(1)
    device.start(DRIVE)
    device.read(1)
    device.stop()
    with pytest.raises(DeviceError):
        device.read(1)
