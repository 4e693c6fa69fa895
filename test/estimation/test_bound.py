"""The bound on what an excitation can tell."""

import numpy as np
import pytest

from benchmarks.estimators_bound import cramer_rao_bound as independent_bound
from benchmarks.estimators_simulator import Experiment
from tissue_probe.estimation import EstimatorSettings
from tissue_probe.estimation.bound import cramer_rao_bound

SETTINGS = EstimatorSettings(encoder_resolution=0.0)


def coil(**experiment):
    return Experiment(force_noise=0.0, encoder_resolution=0.0, **experiment).run()[0]


@pytest.mark.parametrize("frequency", [2.0, 10.0, 30.0])
def test_it_agrees_with_finite_differences_of_another_simulator(frequency):
    experiment = Experiment(frequency=frequency, duration=0.2, encoder_resolution=0.0)
    bound = cramer_rao_bound(
        coil(frequency=frequency, duration=0.2), 5e-4, 450.0, 5.0, SETTINGS, force_offset=False
    )
    expected = independent_bound(experiment)
    assert [bound.stiffness[-1], bound.damping[-1]] == pytest.approx(list(expected), rel=0.01)


def test_it_falls_with_time_and_begins_at_infinity():
    bound = cramer_rao_bound(coil(duration=0.3), 5e-4, 450.0, 5.0, SETTINGS)
    for deviation in (bound.stiffness, bound.damping):
        assert deviation[0] == np.inf
        known = deviation[np.isfinite(deviation)]
        assert known.size > 580
        assert np.all(np.diff(known) < 1e-9 * known[0])


def test_a_resting_coil_tells_nothing():
    bound = cramer_rao_bound(np.zeros(100), 5e-4, 450.0, 5.0, SETTINGS)
    assert np.all(np.isinf(bound.stiffness))
    assert np.all(np.isinf(bound.damping))


def test_an_unknown_constant_force_costs_information_at_first_only():
    position = coil(duration=0.3)
    free = cramer_rao_bound(position, 5e-4, 450.0, 5.0, SETTINGS, force_offset=False)
    unknown = cramer_rao_bound(position, 5e-4, 450.0, 5.0, SETTINGS, force_offset=True)
    assert unknown.stiffness[40] > 2 * free.stiffness[40]
    assert unknown.stiffness[-1] == pytest.approx(free.stiffness[-1], rel=0.05)
