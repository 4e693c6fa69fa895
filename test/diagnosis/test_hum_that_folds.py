"""Hum that no sample shows, or larger than the force, is no candidate."""

import numpy as np
import pytest

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import RIGID_PROBE

STILL = Instrument(RIGID_PROBE, RIGID_PROBE.known | {"tip_mass": (0.0, 0.0)})
LIBRARY = {name: EFFECTS[name] for name in ("mains_hum", "cubic_stiffening")}


def recorded(rate, seconds=40.0, added=lambda times: 0.0 * times):
    """A spring and a damper, pressed by three slow sines."""
    times = np.arange(0.0, seconds, 1.0 / rate)
    angles = 2.0 * np.pi * np.multiply.outer(times, [0.31, 0.83, 1.7])
    position = np.sin(angles) @ [1e-3, 5e-4, 2e-4]
    speed = np.cos(angles) @ (2.0 * np.pi * np.array([0.31e-3, 0.415e-3, 0.34e-3]))
    noise = 4e-3 * np.random.default_rng(3).standard_normal(times.size)
    force = 500.0 * position + 4.0 * speed + added(times) + noise
    return Measurement(position, force, 1.0 / rate)


def ranked(measurement):
    found = diagnose(Composition("rigid_probe"), [measurement], STILL, LIBRARY)
    names = [fit.composition.effects[-1].name for fit in found.ladder.ranking]
    return found, names


@pytest.mark.parametrize("rate", [10.0, 100.0, 120.0])
def test_hum_is_no_candidate_where_samples_are_too_slow_to_show_it(rate):
    """Of a slow decay, sampled at 10 Hz, hum of 50 Hz and of a hundred newtons made a part."""
    decay = recorded(rate, added=lambda times: 0.3 * np.exp(-times / 6.0))
    assert "mains_hum" not in ranked(decay)[1]


def test_hum_that_samples_show_is_named():
    hum = recorded(1000.0, 4.0, lambda times: 0.02 * np.sin(2.0 * np.pi * 50.0 * times + 0.4))
    found, names = ranked(hum)
    assert (found.verdict, found.effects) == ("missing", ("mains_hum",))
    assert "mains_hum" in names
