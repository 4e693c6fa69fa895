"""A second recording that is given by its path is read as the first one was."""

import numpy as np
import pytest

import tissue_probe as tp


@pytest.fixture
def files(tmp_path):
    time = np.arange(1500) / 500.0
    found = []
    for number, rate in enumerate((1.3, 2.1)):
        depth = 1e-3 * (2.0 + np.sin(2 * np.pi * rate * time))
        force = 400.0 * depth + 2.0 * np.gradient(depth, time)
        force += 4e-3 * np.random.default_rng(number).standard_normal(time.size)
        path = tmp_path / f"{number}.csv"
        table = np.column_stack([time, 1e3 * depth, -force])
        np.savetxt(path, table, delimiter=",", header="sec,way,load", comments="")
        found.append(path)
    return found


def test_what_was_told_of_the_first_file_holds_for_the_second(files):
    told = {"time": "sec", "position": "way", "position_unit": "mm", "force": "load"}
    first = tp.read(files[0], **told, force_unit="N", force_polarity="tension")
    found = tp.diagnose(first, validate=files[1], rig="rigid_probe", constants={"tip_mass": 0.0})
    assert found.verdict == "adequate"
    assert found.answer.errors.second == pytest.approx(4e-3, rel=0.1)


def test_who_gives_a_path_is_told_that_more_is_said_to_read(files):
    with pytest.raises(tp.TissueProbeError, match=r"in `tissue_probe\.read`, not here"):
        tp.diagnose(files[0], rig="rigid_probe")
