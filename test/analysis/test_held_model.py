"""A model whose values are held is simulated as finely as its error asks, as the fit of it was."""

import numpy as np
import pytest

import tissue_probe as tp

PERIOD, STEPS, NOISE = 1.0 / 610.0, 16, 2e-5
LINES = np.arange(5.0, 110.0, 0.75)


def stiffening(seed, size):
    """Drive a light oscillator that stiffens, near nine samples a period; mass 5.4 mg, 68 Hz."""
    random = np.random.default_rng(seed)
    phases = random.uniform(0.0, 2.0 * np.pi, LINES.size)
    times = PERIOD / (2 * STEPS) * np.arange(2 * STEPS * 1199 + 1)
    waves = np.exp(2j * np.pi * np.outer(times, LINES)) @ np.exp(1j * phases)
    force = waves.imag * size / LINES.size**0.5
    position = moved(force.tolist(), PERIOD / STEPS)
    position += NOISE * random.standard_normal(position.size)
    every = slice(None, None, 2 * STEPS)
    columns = {"t": PERIOD * np.arange(1200), "u": position, "F": force[every]}
    return tp.read(columns, force_polarity="compression")


def moved(force, step):
    """Return positions at the samples, by Runge and Kutta's rule from rest."""

    def rate(push, x, v):
        return v, (push - x * (0.99 + 3.96 * x * x) - 2.2e-4 * v) / 5.377e-6

    x = v = 0.0
    found = [x]
    for place in range(0, len(force) - 1, 2):
        begin, middle, end = force[place : place + 3]
        a, b = rate(begin, x, v)
        c, d = rate(middle, x + step / 2 * a, v + step / 2 * b)
        e, f = rate(middle, x + step / 2 * c, v + step / 2 * d)
        g, h = rate(end, x + step * e, v + step * f)
        x, v = x + step / 6 * (a + 2 * c + 2 * e + g), v + step / 6 * (b + 2 * d + 2 * f + h)
        if (place + 2) % (2 * STEPS) == 0:
            found.append(x)
    return np.array(found)


@pytest.fixture(scope="module")
def improved():
    asked = {"constants": {"contact_position": 0.0}, "starts": "at-rest"}
    return tp.diagnose(stiffening(1, 0.02), rig="force_driven", add=["cubic_stiffening"], **asked)


@pytest.mark.parametrize("seed", [2, 3])
def test_held_values_leave_as_little_on_another_record_as_noise(improved, seed):
    asked = {"model": improved.model, "starts": "at-rest", "workers": 1}
    found = tp.compare(stiffening(seed, 0.015), **asked)
    assert found.fit.rmse == pytest.approx(NOISE, rel=0.1)
