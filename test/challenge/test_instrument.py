"""What the channels make of force and position."""

from __future__ import annotations

from itertools import groupby

import numpy as np
import pytest
from closed_forms import line

from tissue_probe.challenge.instrument import InstrumentErrors, pink_noise

RATE = 40_000
COUNT = 2_000
BEFORE = RATE // 2
TIME = np.arange(COUNT) / 2_000
SILENCE = np.zeros(COUNT)


def sine(time):
    return np.sin(2.0 * np.pi * 10.0 * time)


LOAD = sine((np.arange(RATE + BEFORE) - BEFORE) / RATE)


def read(instrument, load=LOAD, noise=SILENCE):
    return instrument.force(load, RATE, BEFORE, noise)


def test_a_sound_instrument_samples_the_force():
    np.testing.assert_allclose(read(InstrumentErrors()), sine(TIME), atol=1e-12)


def test_gain_bias_and_drift_are_linear():
    force = read(InstrumentErrors(gain=0.1, bias=0.2, drift=-0.3))
    np.testing.assert_allclose(force, 1.1 * sine(TIME) + 0.2 - 0.3 * TIME, atol=1e-12)


@pytest.mark.parametrize("frequency", [50.0, 60.0])
def test_hum_is_one_line_of_its_amplitude(frequency):
    hum = InstrumentErrors(hum=0.02, hum_frequency=frequency, hum_phase=1.0)
    force = read(hum, np.zeros_like(LOAD))
    assert abs(line(force, frequency, 2_000)) == pytest.approx(0.02, rel=1e-9)
    assert np.sum(force**2) / COUNT == pytest.approx(0.02**2 / 2.0, rel=1e-9)


@pytest.mark.parametrize("delay", [1e-4, 1.2345e-3])
def test_a_delay_shows_the_force_of_earlier(delay):
    np.testing.assert_allclose(read(InstrumentErrors(delay=delay)), sine(TIME - delay), atol=1e-9)


@pytest.mark.parametrize("lag", [1e-4, 3e-3])
def test_a_lag_is_a_first_order_low_pass(lag):
    force = read(InstrumentErrors(lag=lag))
    expected = line(sine(TIME), rate=2_000) / (1.0 + 2j * np.pi * 10.0 * lag)
    assert line(force, rate=2_000) == pytest.approx(expected, rel=1e-5)


def test_a_lag_begins_settled():
    constant = np.full_like(LOAD, 0.7)
    np.testing.assert_allclose(read(InstrumentErrors(lag=2e-3), constant), 0.7, rtol=1e-12)


def test_drift_that_settles_has_its_time_constant():
    force = read(InstrumentErrors(settling=0.1, settling_time=0.2), np.zeros_like(LOAD))
    assert force[0] == 0.0
    assert force[400] == pytest.approx(0.1 * (1.0 - np.exp(-1.0)))


def test_the_zero_jumps_once():
    force = read(InstrumentErrors(jump=0.1, jump_time=0.2), np.zeros_like(LOAD))
    np.testing.assert_array_equal(force[:400], 0.0)
    np.testing.assert_array_equal(force[400:], 0.1)


def test_bursts_come_and_go():
    force = read(InstrumentErrors(burst=0.05, burst_period=0.3), np.zeros_like(LOAD))
    assert np.mean(force == 0.0) == pytest.approx(2.0 / 3.0, abs=0.05)
    assert np.abs(force).max() == pytest.approx(0.05, rel=0.01)


def test_the_encoder_tells_whole_steps():
    u = 1e-3 * sine(TIME)
    read_position = InstrumentErrors(encoder_step=1e-5).position(u)
    steps = read_position / 1e-5
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    assert np.abs(read_position - u).max() <= 0.5e-5


def test_the_grating_errs_once_a_period():
    u = np.linspace(0.0, 20e-6, 1001)
    error = InstrumentErrors(ripple=1e-6, grating=20e-6, encoder_step=1e-12).position(u) - u
    np.testing.assert_allclose(error, 1e-6 * np.sin(2.0 * np.pi * u / 20e-6), atol=1e-11)


def test_clipped_force_stays_at_the_end_of_its_range():
    force = read(InstrumentErrors(clipped=0.1), noise=1e-3 * np.random.default_rng(0).random(COUNT))
    whole = read(InstrumentErrors(), noise=1e-3 * np.random.default_rng(0).random(COUNT))
    level = whole.max() - 0.1 * np.ptp(whole)
    np.testing.assert_array_equal(force, np.minimum(whole, level))
    assert np.sum(force == force.max()) > 100


def test_a_stuck_channel_repeats_its_value():
    stuck = InstrumentErrors(stuck=30, stuck_times=(0.25, 0.75))
    force = read(stuck, noise=1e-3 * np.random.default_rng(0).random(COUNT))
    runs = [len(list(same)) for _, same in groupby(force)]
    assert sorted(runs)[-2:] == [30, 30]
    assert sorted(runs)[-3] == 1


def test_pink_noise_has_its_rms_and_as_much_power_in_every_octave():
    noise = [pink_noise(16_384, np.random.default_rng(seed)) for seed in range(30)]
    assert np.sqrt(np.mean(np.square(noise))) == pytest.approx(1.0, rel=0.05)
    power = np.mean(np.abs(np.fft.rfft(noise)) ** 2, axis=0)
    octaves = [power[2**n : 2 ** (n + 1)].sum() for n in range(5, 12)]
    assert max(octaves) < 1.25 * min(octaves)
