"""Recordings of the benchmark of studies are what they are said to be; its marks tell misses."""

from __future__ import annotations

import numpy as np
import pytest

import tissue_probe as tp
from benchmarks.studies import sealed
from benchmarks.studies.recordings import ASKED, Laboratory


def test_a_recording_has_the_stiffness_that_is_said_of_it(tmp_path):
    truths = Laboratory(specimens=2, repeats=2, seconds=0.5).write(tmp_path / "data", seed=1)
    assert sorted(truths) == sorted(path.name for path in (tmp_path / "data").iterdir())
    for name, true in truths.items():
        row = tp.row(tmp_path / "data" / name, **ASKED)
        assert row["stiffness"] == pytest.approx(true, abs=5.0 * row["stiffness_sd"])


def test_each_kind_of_interval_of_a_sealed_study_is_marked():
    held = [sealed.marked(np.random.default_rng(seed)) for seed in range(8)]
    assert {name for each in held for name in each} >= {"ICC", "between", "within", "contrast"}
    assert np.mean([list(each.values()) for each in held]) > 0.8
