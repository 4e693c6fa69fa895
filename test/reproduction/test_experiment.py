"""The simulator of the experiments, against an adaptive integrator and closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tissue_probe.reproduction.experiment import SimulatedTissue, SineExperiment

M, K0, B0 = 0.04, 9700.0, 0.8
RELAXING = SimulatedTissue(300.0, 2.0, relaxing_stiffness=400.0, relaxation_rate=60.0)
STIFF = SimulatedTissue(2000.0, 20.0)


def integrated(experiment):
    """Return the tip's displacement by DOP853, one piece of tissue after the other."""
    w, a = 2 * np.pi * experiment.frequency, experiment.amplitude
    ends = [start for start, _ in experiment.tissues[1:]] + [experiment.duration]
    state, pieces = np.zeros(3), []
    for (start, tissue), end in zip(experiment.tissues, ends, strict=True):

        def rates(t, z, tissue=tissue):
            x, v, y = z
            cell = K0 * (a * np.sin(w * t) - x) + B0 * (a * w * np.cos(w * t) - v)
            load = tissue.stiffness * x + tissue.damping * v + tissue.relaxing_stiffness * y
            return [v, (cell - load) / M, v - tissue.relaxation_rate * y]

        inside = (experiment.time >= start - 1e-9) & (experiment.time < end - 1e-9)
        times = np.r_[experiment.time[inside], end]
        solved = solve_ivp(rates, (start, end), state, "DOP853", times, rtol=1e-11, atol=1e-15)
        pieces.append(solved.y[0, :-1])
        state = solved.y[:, -1]
    return np.concatenate(pieces)


@pytest.mark.parametrize("tissues", [((0.0, RELAXING),), ((0.0, STIFF), (0.1, RELAXING))])
def test_the_motion_is_that_of_an_adaptive_integrator(tissues):
    experiment = SineExperiment(tissues, duration=0.2, frequency=30.0)
    _, tip = experiment.motion()
    assert K0 * np.abs(tip - integrated(experiment)).max() < 1e-7


@pytest.mark.parametrize("frequency", [2.0, 10.0, 30.0])
def test_a_sine_meets_the_stiffness_and_damping_that_the_tissue_states(frequency):
    experiment = SineExperiment(((0.0, RELAXING),), frequency=frequency, lead=2.0)
    coil, tip = experiment.motion()
    w = 2 * np.pi * frequency
    # Coil and tip at the frequency, from whole periods; then eq. 1 solved for k + i w beta.
    u, x = (np.mean(each * np.exp(-1j * w * experiment.time)) for each in (coil, tip))
    impedance = (K0 + 1j * w * B0) * (u - x) / x + M * w**2
    stiffness, damping = RELAXING.at(frequency)
    assert impedance.real == pytest.approx(stiffness, rel=1e-6)
    assert impedance.imag / w == pytest.approx(damping, rel=1e-6)


def test_relaxing_tissue_grows_stiffer_and_less_damped_with_frequency():
    stiffness, damping = np.transpose([RELAXING.at(f) for f in (1.0, 5.0, 15.0, 30.0)])
    assert np.all(np.diff(stiffness) > 0)
    assert np.all(np.diff(damping) < 0)


def test_measuring_later_shows_the_rest_of_the_same_motion():
    whole = SineExperiment(((0.0, STIFF), (0.1, RELAXING)), duration=0.3)
    late = replace(whole, lead=0.05, duration=0.25)
    np.testing.assert_array_equal(late.motion()[1], whole.motion()[1][100:])
    np.testing.assert_array_equal(late.truth()[0], whole.truth()[0][100:])


def test_noise_is_the_seeds_and_the_load_cells():
    quiet = SineExperiment(((0.0, STIFF),))
    coil, tip = quiet.motion()
    first, second = quiet.samples(), replace(quiet, seed=1).samples()
    assert not np.array_equal(first.force, second.force)
    assert np.std(first.force - K0 * (coil - tip)) == pytest.approx(0.005, rel=0.1)
    assert np.abs(first.position - coil).max() <= 0.51e-7
