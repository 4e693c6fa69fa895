"""Effects in the two channels: scale, offset, hum, timing, encoder, converter.

Contents: what each sets of an ``InstrumentErrors``.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.challenge.change import Change, HiddenEffect, Situation, sign

Random = np.random.Generator


def _force_gain(strength: float, at: Situation, random: Random) -> Change:
    return Change(instrument={"gain": sign(random) * strength})


def _force_bias(strength: float, at: Situation, random: Random) -> Change:
    return Change(instrument={"bias": sign(random) * strength})


def _force_drift(strength: float, at: Situation, random: Random) -> Change:
    """Move at a constant rate, or towards another zero, as a load cell that creeps or warms up."""
    moved = sign(random) * strength
    if random.random() < 0.5:
        return Change(instrument={"drift": moved / at.duration})
    time = random.uniform(0.05, 0.25) * at.duration
    return Change(instrument={"settling": moved, "settling_time": time})


def _mains_hum(strength: float, at: Situation, random: Random) -> Change:
    frequency, phase = float(random.choice((50.0, 60.0))), random.uniform(0.0, 2.0 * np.pi)
    return Change(instrument={"hum": strength, "hum_frequency": frequency, "hum_phase": phase})


def _force_lag(strength: float, at: Situation, random: Random) -> Change:
    return Change(instrument={"lag": strength})


def _channel_delay(strength: float, at: Situation, random: Random) -> Change:
    return Change(instrument={"delay": strength})


def _encoder_quantization(strength: float, at: Situation, random: Random) -> Change:
    return Change(instrument={"encoder_step": strength})


def _encoder_interpolation(strength: float, at: Situation, random: Random) -> Change:
    """Error of an interpolated grating of 20 um, once a period (Heydemann, 1981)."""
    return Change(
        instrument={
            "ripple": strength,
            "grating": 20e-6,
            "ripple_phase": random.uniform(0.0, 2.0 * np.pi),
        }
    )


def _adc_saturation(strength: float, at: Situation, random: Random) -> Change:
    return Change(instrument={"clipped": strength})


def _stuck_samples(strength: float, at: Situation, random: Random) -> Change:
    times = np.sort(random.uniform(0.05, 0.95, random.integers(3, 9)))
    return Change(instrument={"stuck": round(strength), "stuck_times": tuple(times.tolist())})


INSTRUMENTAL: dict[str, HiddenEffect] = {
    "force_gain": HiddenEffect("scale", _force_gain, 2e-3, 0.1, 0.4),
    "force_bias": HiddenEffect("offset", _force_bias, 1e-3, 0.03, 0.5),
    "force_drift": HiddenEffect("offset", _force_drift, 1e-3, 0.05, 1.0),
    "mains_hum": HiddenEffect("hum", _mains_hum, 2e-3, 0.02, 0.5),
    "force_lag": HiddenEffect("timing", _force_lag, 1e-5, 1e-3, 2e-2),
    "channel_delay": HiddenEffect("timing", _channel_delay, 1e-5, 1e-3, 1e-2),
    "encoder_quantization": HiddenEffect("encoder", _encoder_quantization, 5e-7, 1e-5, 1e-4),
    "encoder_interpolation": HiddenEffect("encoder", _encoder_interpolation, 5e-8, 1e-6, 3e-6),
}
"""Effects of the library that lie in the channels, by name."""

SPOILING_EFFECTS: dict[str, HiddenEffect] = {
    "adc_saturation": HiddenEffect("converter", _adc_saturation, 5e-3, 0.15, 0.4),
    "stuck_samples": HiddenEffect("converter", _stuck_samples, 5.0, 20.0, 50.0),
}
"""Faults of the converter by name: answers of a diagnosis that are no models."""
