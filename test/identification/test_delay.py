"""The delay between the channels, to microseconds."""

from __future__ import annotations

import numpy as np
import pytest
from steady_motion import BETA0, K0, MASS, PERIOD, steady

from tissue_probe.identification.delay import force_delay

TOOL = (PERIOD, MASS, K0, BETA0)
LINES = {9.7: 5e-4, 15.3: 3e-4, 23.1: 2e-4}


@pytest.mark.parametrize("delay", [-3e-4, 0.0, 1e-4, 1e-3])
@pytest.mark.parametrize("lines", [LINES, {10.0: 1e-3}])
def test_the_delay_is_found(delay, lines):
    found = force_delay(*steady(lines, 10.0, delay=delay, noise=0.005), *TOOL)
    assert found.seconds == pytest.approx(delay, abs=1.5e-5)
    assert found.interval[0] <= found.seconds <= found.interval[1]


def test_the_interval_holds_the_truth_as_often_as_it_says():
    hits = 0
    for seed in range(100):
        found = force_delay(*steady(LINES, 10.0, delay=1e-4, noise=0.005, seed=seed), *TOOL)
        hits += found.interval[0] <= 1e-4 <= found.interval[1]
    assert 88 <= hits <= 100


@pytest.mark.parametrize(
    ("signals", "said"),
    [
        (steady(LINES, 4.0), "too short: record 5 s"),
        (steady(LINES, 10.0, stiffness=440.0, damping=5.0), "not that of a tip in free air"),
        (np.zeros((2, 20_000)), "not that of a tip in free air"),
        (np.full((2, 20_000), np.nan), "too many samples are missing"),
    ],
)
def test_what_is_no_free_air_run_is_refused(signals, said):
    with pytest.raises(ValueError, match=said):
        force_delay(*signals, *TOOL)
