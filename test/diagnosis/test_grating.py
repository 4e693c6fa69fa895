"""An encoder's error repeats with the place; noise does not."""

import numpy as np
import pytest

from tissue_probe.diagnosis.inspection.grating import REPEATS, repeats

TIME = np.arange(0.0, 2.0, 5e-4)


@pytest.mark.parametrize("length", [1.0, 1e3, 1e-6])
@pytest.mark.parametrize("period", [8e-6, 20e-6, 1e-4])
def test_an_error_of_the_grating_is_told_from_noise_of_its_size(period, length):
    place = 1e-3 * np.sin(2.0 * np.pi * 9.7 * TIME)
    noise = 2e-7 * np.random.default_rng(0).standard_normal(TIME.size)
    error = 1e-6 * np.sin(2.0 * np.pi * place / period + 0.3)
    told = [length * (place + each) for each in (error + noise, 3.0 * noise)]
    assert repeats(told[0], length * place, length) > REPEATS
    assert repeats(told[1], length * place, length) < 0.2 * REPEATS


def test_a_ramp_and_a_hold_repeat_nothing():
    place = 4e-3 * np.minimum(TIME / 0.1, 1.0)
    noise = 2e-8 * np.random.default_rng(0).standard_normal(TIME.size)
    assert repeats(place + noise, place) < REPEATS
