"""Tissue that softens as it is worked: named, with its values, and known again on a second record.

By formulas of this file, on a rig that leads the tip.
"""

import numpy as np
import pytest

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.other_runs import carry_model
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import RIGID_PROBE

STILL = Instrument(RIGID_PROBE, RIGID_PROBE.known | {"tip_mass": (0.0, 0.0)})
LIBRARY = {
    name: EFFECTS[name]
    for name in ("preconditioning", "damage_by_depth", "stiffness_ramp", "standard_linear_solid")
}
FRESH, LOST, SETTLING, NOISE = 450.0, 0.4, 0.03, 2e-3
TIMES = np.arange(0.0, 4.0, 1e-3)


def worked(before=0.0, rate=2.0 * np.pi * 3.0, seed=3):
    """Return a record of tissue that was worked over a way ``before`` [m], and the way after it."""
    depth = 1e-3 * (1.0 - np.cos(rate * TIMES))
    speed = 1e-3 * rate * np.sin(rate * TIMES)
    way = before + np.concatenate([[0.0], np.cumsum(np.abs(np.diff(depth)))])
    left = 1.0 - LOST * (1.0 - np.exp(-way / SETTLING))
    noise = NOISE * np.random.default_rng(seed).standard_normal(TIMES.size)
    return Measurement(depth, FRESH * left * depth + 4.0 * speed + noise, 1e-3), way[-1]


def test_softening_by_the_way_is_named_with_its_values():
    found = diagnose(Composition("rigid_probe"), [worked()[0]], STILL, LIBRARY)
    assert (found.verdict, found.effects) == ("missing", ("preconditioning",))
    fitted, deviations = found.ladder.final.named(), found.ladder.final.deviations()
    truth = {
        "stiffer_at_the_start": LOST / (1.0 - LOST),
        "settling_path": SETTLING,
        "stiffness": FRESH * (1.0 - LOST),
    }
    for name, value in truth.items():
        assert abs(fitted[name] - value) < 4.0 * deviations[name]
        assert deviations[name] < 0.1 * value


def test_a_second_recording_goes_on_where_the_first_has_worked_the_tissue():
    first, way = worked()
    second, _ = worked(way / 3.0, 2.0 * np.pi * 4.0, seed=4)
    found = diagnose(Composition("rigid_probe"), [first], STILL, LIBRARY, validation=[second])
    assert (found.verdict, found.effects) == ("missing", ("preconditioning",))
    final = found.ladder.final
    assert found.validated[final.composition.names] == pytest.approx(NOISE, rel=0.05)
    moved = carry_model(final.composition, final.named(), [second], STILL)
    left = LOST / (1.0 - LOST) * np.exp(-way / 3.0 / SETTLING)
    assert moved.named()["stiffer_at_the_start"] == pytest.approx(left, rel=0.05)
