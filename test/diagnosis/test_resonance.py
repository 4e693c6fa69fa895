"""Where searches of effects begin: near what a model leaves."""

import numpy as np
import pytest
from hidden import first_of
from scipy.signal import lsim

import tissue_probe as tp


@pytest.mark.parametrize("frequency", first_of([6.3, 5.1, 12.7], 1))
def test_a_narrow_resonance_within_a_sweep_is_found_wherever_it_lies(frequency):
    time = np.arange(0.0, 24.0, 4e-3)
    phase = 2.0 * np.pi * (2.0 * time + 16.0 * time**2 / 24.0)
    depth, speed = (
        1e-3 * np.sin(phase),
        1e-3 * np.cos(phase) * 2.0 * np.pi * (2.0 + 32.0 * time / 24.0),
    )
    own, share, mass = 2.0 * np.pi * frequency, 0.006, 2e-3
    # A mass on a spring and a damper is dragged along: of its lag y, y'' + 2 d w y' + w^2 y = u''.
    resonance = [2.0 * share * own, own**2], [1.0, 2.0 * share * own, own**2]
    acceleration = np.gradient(speed, time, edge_order=2)
    fine = np.arange(0.0, 24.0, 5e-4)
    _, drag, _ = lsim(resonance, mass * np.interp(fine, time, acceleration), fine)
    noise = 2e-3 * np.random.default_rng(0).standard_normal(time.size)
    columns = {"t": time, "u": depth, "F": 600.0 * depth + 3.0 * speed + drag[::8] + noise}
    given = tp.read(columns, force_polarity="compression")
    found = tp.diagnose(given, rig="rigid_probe", constants={"tip_mass": (0.0, 0.0)})
    assert (found.verdict, found.effects) == ("missing", ("structural_mode",))
    named = found.found.ladder.final.named()
    assert named["modal_frequency"] == pytest.approx(frequency, rel=0.01)
    assert named["modal_mass"] == pytest.approx(mass, rel=0.1)
