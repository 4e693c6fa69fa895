"""Steps, derivatives and composition of models, against integration that knows none of them."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tissue_probe.physics.effects.cubic_stiffening import CUBIC_STIFFENING
from tissue_probe.physics.effects.standard_linear_solid import STANDARD_LINEAR_SOLID
from tissue_probe.physics.rigs import OWN
from tissue_probe.physics.simulation import simulate

M, K0, B0 = 0.04, 9700.0, 0.8
MODELS = {
    "plain": OWN.compose(),
    "offset": OWN.compose(force_offset=True),
    "relaxing": OWN.compose([STANDARD_LINEAR_SOLID]),
    "stiffening": OWN.compose([CUBIC_STIFFENING]),
    "both": OWN.compose([STANDARD_LINEAR_SOLID, CUBIC_STIFFENING], force_offset=True),
}
VALUES = {
    "plain": [450.0, 5.0],
    "offset": [450.0, 5.0, 0.1],
    "relaxing": [450.0, 5.0, 300.0, 40.0],
    "stiffening": [450.0, 5.0, 2e8],
    "both": [450.0, 5.0, 0.1, 300.0, 40.0, 2e8],
}


def forces(name, values, coil, period, start=None):
    return simulate(name, MODELS[name], (M, K0, B0), values, coil, period, start)


def integrated(values, coil, coil_rate, times, relaxing=(0.0, 1.0), cubic=0.0):
    """Force of the probe by an eighth-order integrator, written without the package's symbols."""
    k, b, *_ = values

    def rate(t, z):
        x, v, y = z
        load = K0 * (coil(t) - x) + B0 * (coil_rate(t) - v)
        tissue = k * x + b * v + relaxing[0] * y + cubic * x**3
        return [v, (load - tissue) / M, v - relaxing[1] * y]

    fine = min(1e-4, times[1] / 4)
    solution = solve_ivp(
        rate, (0, times[-1]), [0, 0, 0], "DOP853", times, rtol=1e-12, atol=1e-16, max_step=fine
    )
    return K0 * (coil(times) - solution.y[0])


def polynomial_motion(values, period, samples=40):
    """Coil that moves as a cubic, which interpolation reproduces exactly, and tip (x, v)."""
    c = np.array([2e-4, -1e-3, 3e-2, 0.4]) * (5e-4 / period) ** np.arange(4)
    times = np.arange(samples) * period
    coil = np.polynomial.Polynomial(c)
    truth = solve_ivp(
        lambda t, z: [
            z[1],
            (K0 * (coil(t) - z[0]) + B0 * (coil.deriv()(t) - z[1]) - values[0] * z[0]
             - values[1] * z[1]) / M,
        ],
        (0, times[-1]), [0, 0], "LSODA", times, rtol=1e-12, atol=1e-18, max_step=period / 4,
    )  # fmt: skip
    return coil(times), truth.y


@pytest.mark.parametrize("period", [1e-4, 5e-4, 2e-3])
@pytest.mark.parametrize(
    "values", [(450.0, 5.0), (0.0, 0.0), (30000.0, 2.0), (-2000.0, -20.0), (3000.0, 500.0)]
)
def test_the_step_is_exact_for_any_tissue_at_any_rate(values, period):
    """One step at a time from the true state; the input is a cubic."""
    coil, truth = polynomial_motion(values, period)
    for sample in (3, 10, 39):
        window = coil[sample - 3 : sample + 1]
        result = _last_step(values, window, period, truth[:, sample - 1])
        scale = K0 * (np.abs(coil[sample]) + np.abs(truth[0, sample]))
        expected = K0 * (coil[sample] - truth[0, sample])
        assert result == pytest.approx(expected, abs=2e-9 * scale)


def _last_step(values, window, period, state):
    """Force after the last of the three steps between four positions, begun before it."""
    from tissue_probe.physics import code_cache
    from tissue_probe.physics.simulation import _source

    kernel = code_cache.module("simulate_plain", lambda: _source(MODELS["plain"]))
    z, tangent = np.array(state), np.eye(2, 4)
    kernel.step(np.array([M, K0, B0, *values]), z, tangent, *window[::-1], period)
    return K0 * (window[-1] - z[0])


@pytest.mark.parametrize("name", MODELS)
def test_sensitivities_are_the_derivatives_of_the_force(name):
    coil = 1e-3 * np.sin(60 * np.arange(200) * 5e-4)
    start = np.array([1e-4, 0.01, 1e-4])[: len(MODELS[name].states)]
    values = np.array(VALUES[name])
    exact = forces(name, values, coil, 5e-4, start).sensitivity
    unknowns = np.concatenate([start, values])
    for index, value in enumerate(unknowns):
        change = np.zeros(unknowns.size)
        change[index] = 1e-4 * abs(value)
        up, down = unknowns + change, unknowns - change
        difference = (
            forces(name, up[start.size :], coil, 5e-4, up[: start.size]).force
            - forces(name, down[start.size :], coil, 5e-4, down[: start.size]).force
        ) / (2 * change[index])
        scale = np.abs(exact[:, index]).max()
        np.testing.assert_allclose(exact[:, index], difference, atol=2e-6 * scale)


def stroke(t):
    """Coil displacement [m] that begins so smoothly that its interpolation errs by nothing."""
    return 1e-3 * np.sin(30 * np.maximum(t - 2e-3, 0)) ** 4


def stroke_rate(t):
    s = np.maximum(t - 2e-3, 0)
    return 0.12 * np.sin(30 * s) ** 3 * np.cos(30 * s)


def test_a_branch_that_relaxes_is_stepped_exactly_too():
    times = np.arange(400) * 5e-4
    values = VALUES["relaxing"]
    truth = integrated(values, stroke, stroke_rate, times, relaxing=(300.0, 40.0))
    force = forces("relaxing", values, stroke(times), 5e-4).force
    # What is left is the cubic interpolation of the coil between samples.
    assert np.abs(force - truth).max() < 2e-6 * np.abs(truth).max()


@pytest.mark.parametrize("cubic", [2e8, 2e9])
def test_a_nonlinear_step_errs_by_less_than_a_millionth_of_the_force(cubic):
    values = [450.0, 5.0, cubic]
    times, fine = np.arange(401) * 5e-4, np.arange(6401) * 5e-4 / 16
    truth = integrated(values, stroke, stroke_rate, times, cubic=cubic)
    converged = forces("stiffening", values, stroke(fine), 5e-4 / 16).force[::16]
    assert np.abs(converged - truth).max() < 2e-8 * np.abs(truth).max()
    # Under a cubic input, which is interpolated exactly, all error is the rule's.
    force = forces("stiffening", values, 4e-3 * (times / 0.2) ** 3, 5e-4).force
    sixteenth = forces("stiffening", values, 4e-3 * (fine / 0.2) ** 3, 5e-4 / 16).force[::16]
    assert np.abs(force - sixteenth).max() < 1e-6 * np.abs(sixteenth).max()


def test_the_models_know_which_of_them_are_linear():
    linear = {name: model.is_linear for name, model in MODELS.items()}
    assert linear == {
        "plain": True, "offset": True, "relaxing": True, "stiffening": False, "both": False
    }  # fmt: skip
