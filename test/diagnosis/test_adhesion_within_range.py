"""A tissue that holds the tip the less, the farther it is lifted off: named, with its values.

By formulas of this file, on a rig that leads the tip.
"""

import numpy as np
import pytest

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import RIGID_PROBE

STILL = Instrument(
    RIGID_PROBE,
    RIGID_PROBE.known | {"tip_mass": (0.0, 0.0), "contact_position": (0.0, 0.0)},
)
LIBRARY = {
    name: EFFECTS[name]
    for name in ("adhesion_within_range", "adhesion", "contact_loss", "bilinear_spring")
}
STIFFNESS, DAMPING, PULL, RANGE, NOISE = 450.0, 2.0, 0.15, 3e-4, 2e-3
LAWS = {
    "a bridge that thins evenly": (lambda gap: np.maximum(1.0 - gap, 0.0), 1.0),
    "threads that go one by one": (lambda gap: np.exp(-gap), np.log(100.0)),
}


def lifted(law):
    """Press in and lift off 3 times a second, the deeper the longer: no pull on the way in."""
    held, torn_at = LAWS[law]
    times = np.arange(0.0, 4.0, 1e-3)
    rate = 2.0 * np.pi * 3.0
    depth = 1.2e-3 * np.sin(rate * times) * (1.0 + 0.1 * times)
    speed = np.gradient(depth, times)
    tissue, bridged, force = STIFFNESS * depth + DAMPING * speed, True, np.zeros(times.size)
    for place, (x, pull) in enumerate(zip(depth, tissue, strict=True)):
        bridged = x > -torn_at * RANGE if bridged else x > 0.0
        if bridged:
            force[place] = max(pull, -PULL * held(max(-x, 0.0) / RANGE))
    noise = NOISE * np.random.default_rng(5).standard_normal(times.size)
    return Measurement(depth, force + noise, 1e-3, at_rest=False)


@pytest.mark.parametrize("law", LAWS)
def test_a_pull_that_falls_with_the_gap_is_named_with_its_values(law):
    found = diagnose(Composition("rigid_probe"), [lifted(law)], STILL, LIBRARY)
    assert (found.verdict, found.effects) == ("missing", ("adhesion_within_range",))
    fitted = found.ladder.final.named()
    assert fitted["bond_force"] == pytest.approx(PULL, rel=0.05)
    assert fitted["adhesion_range"] == pytest.approx(RANGE, rel=0.05)
    assert fitted["stiffness"] == pytest.approx(STIFFNESS, rel=0.01)
