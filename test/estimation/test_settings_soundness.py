"""Settings that are accepted never make a filter lose its numbers; what would is refused."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from measured import START

from benchmarks import filters
from tissue_probe.estimation import ESTIMATORS, Estimator, EstimatorSettings
from tissue_probe.settings import SettingsError, build
from tissue_probe.signals import SampleBlock

#: The step is the model's, and all filters have one model: one of them stands for all with
#: Euler's, since each is compiled anew.
DISCRETISED = [
    *((name, "exact") for name in ESTIMATORS),
    ("ekf", "euler"),
    *(
        pytest.param(name, "euler", marks=pytest.mark.battery)
        for name in ("ukf", "afekf", "afukf", "robust_ekf")
    ),
]


@pytest.mark.parametrize(("name", "discretisation"), DISCRETISED)
@settings(max_examples=20, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2**32))
def test_no_accepted_settings_and_no_samples_spoil_a_filter(name, discretisation, seed):
    drawn, blocks = filters.sequence(seed)
    chosen = drawn.model_copy(update={"discretisation": discretisation})
    shown, _ = filters.examine(name, chosen, blocks)
    assert shown == []


REFUSED = {
    "tip_mass is 1e-08 kg and damping_maximum 500 N s/m: the tip would move at": {"tip_mass": 1e-8},
    "give a greater tip_mass or a smaller load_cell_damping": {
        "tip_mass": 1e-3,
        "load_cell_damping": 9e3,
    },
    "give a greater tip_mass or a smaller load_cell_stiffness": {
        "tip_mass": 1e-3,
        "load_cell_stiffness": 1e8,
        "damping_maximum": 10.0,
    },
    "stiffness_prior is 50000 N/m, outside of stiffness_minimum, -2000, to": {
        "stiffness_prior": 5e4
    },
    "damping_prior is -30 N s/m, outside of damping_minimum, -20, to": {"damping_prior": -30.0},
}


@pytest.mark.parametrize("said", REFUSED)
def test_settings_that_do_not_go_together_are_refused_by_what_to_change(said):
    with pytest.raises(SettingsError, match=said):
        build(EstimatorSettings, REFUSED[said])


def test_a_light_tip_is_accepted_where_its_tissue_is_said_to_be_soft():
    build(EstimatorSettings, {"tip_mass": 1e-4, "damping_maximum": 10.0, "damping_prior_sd": 3.0})


def test_no_sample_period_makes_a_filter_hang():
    """A step is divided into so many parts and no more, though the filter knows nothing then."""
    still = np.zeros(20)
    block = SampleBlock(START, 0, 1e3, still, still, still)
    assert np.all(np.isfinite(Estimator("ekf", EstimatorSettings()).process(block).stiffness))
