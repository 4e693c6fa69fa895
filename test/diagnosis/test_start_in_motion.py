"""A motion that goes on before the first sample: its start is found, and so is what is hidden."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import FORCE_DRIVEN
from tissue_probe.quantities import POSITION

pytestmark = pytest.mark.timeout(900)

RIG = Composition(FORCE_DRIVEN)
FREE = Instrument(FORCE_DRIVEN)
MASS, DAMPING, STIFFNESS, CUBE, NOISE = 0.02, 0.8, 4.2e3, 9e7, 2e-6
PERIOD, COUNT = 1.0 / 600.0, 1200


def measured(seed, force_noise=0.0):
    """Return a tip under lines from 5 to 90 Hz, some seconds after they began."""
    random = np.random.default_rng(seed)
    lines = 2 * np.pi * np.arange(5.0, 90.0, 0.5)[:, np.newaxis]
    phases, size = random.uniform(0, 2 * np.pi, lines.shape), 3.0 / np.sqrt(lines.size)

    def push(time):
        return size * np.sum(np.sin(lines * time + phases), axis=0)

    def rates(time, z):
        pull = STIFFNESS * z[0] + DAMPING * z[1] + CUBE * z[0] ** 3
        return [z[1], (push(np.atleast_1d(time))[0] - pull) / MASS]

    times = 1.0 + np.arange(COUNT) * PERIOD
    solved = solve_ivp(rates, (0, times[-1]), [0.0, 0.0], "DOP853", times, rtol=1e-9, atol=1e-12)
    force = push(times)
    force = force + force_noise * np.std(force) * random.standard_normal(COUNT)
    position = solved.y[0] + NOISE * random.standard_normal(COUNT)
    return Measurement(position, force, PERIOD, output=POSITION)


@pytest.mark.battery
@pytest.mark.parametrize("seed", [0, 2])
def test_a_stiffening_resonance_that_begins_in_motion_carries_over(seed):
    found = diagnose(RIG, [measured(seed)], FREE, EFFECTS, [measured(seed + 1)])
    assert (found.verdict, found.effects) == ("missing", ("cubic_stiffening",))
    final = found.ladder.final
    assert found.heldout(final) == pytest.approx(NOISE, rel=0.1)
    assert final.named()["cubic_stiffness"] == pytest.approx(CUBE, rel=0.01)
    assert found.validation_noise == pytest.approx(NOISE, rel=0.2)


@pytest.mark.battery
@pytest.mark.parametrize("seed", [4, 6])
def test_noise_of_the_force_is_counted_on_both_recordings(seed):
    first, second = measured(seed, 0.02), measured(seed + 1, 0.02)
    found = diagnose(RIG, [first], FREE, EFFECTS, [second])
    assert (found.verdict, found.effects) == ("missing", ("cubic_stiffening",))
    final, deviations = found.ladder.final, found.ladder.final.deviations()
    assert final.ratio == pytest.approx(1.0, abs=0.06)
    for name, true in (("tip_mass", MASS), ("stiffness", STIFFNESS), ("cubic_stiffness", CUBE)):
        assert abs(final.named()[name] - true) < 3.5 * deviations[name]
    assert found.heldout(final) == pytest.approx(found.validation_noise, rel=0.25)
