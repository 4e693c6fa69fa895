"""Hidden effects are named: one of each family, and none where none is.

Seeds below 1000; ``python -m benchmarks diagnosis``, which measures the whole, uses larger ones.
The marks are the challenge's own.
"""

from __future__ import annotations

import numpy as np
import pytest
from hidden import first_of

from tissue_probe.challenge import Challenge, make_challenge
from tissue_probe.challenge import SimulatedRecord as Record
from tissue_probe.challenge.grading import GradedDiagnosis
from tissue_probe.challenge.instrument import FORCE_NOISE
from tissue_probe.challenge.simulator import PINK_NOISE
from tissue_probe.diagnosis import diagnosis
from tissue_probe.diagnosis.answer import answer
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.other_runs import carry_model
from tissue_probe.diagnosis.second_recording import weigh_by_model
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]

#: One effect of each family, with an excitation that shows it and a seed.
HIDDEN = (
    ("standard_linear_solid", "sine10", 901),
    ("cubic_stiffening", "sine10", 902),
    ("coulomb_friction", "sine10", 903),
    ("added_mass", "sine10", 904),
    ("mains_hum", "sine10", 905),
    ("stiffness_ramp", "chirp60", 907),
    ("contact_loss", "sine10", 910),
    ("backlash", "sine10", 911),
    ("force_gain", "sine10", 912),
    ("force_bias", "sine10", 913),
    ("tissue_motion", "sine10", 914),
    ("force_lag", "sine10", 906),
    ("encoder_interpolation", "sine10", 915),
)


def diagnosed(challenge: Challenge, instrument: Instrument) -> diagnosis.Diagnosis:
    return diagnosis.diagnose(Composition(), [measured(challenge.recording)], instrument, EFFECTS)


def measured(record: Record) -> Measurement:
    return Measurement(record.position, record.force, record.sample_period, at_rest=True)


def second_error(challenge: Challenge, fit, instrument: Instrument) -> float:
    second = weigh_by_model(fit, [measured(challenge.second)], instrument)
    moved = carry_model(fit.composition, fit.named(), second, instrument)
    assert moved is not None
    return moved.rmse


@pytest.mark.parametrize(("effect", "excitation", "seed"), first_of(HIDDEN, 3))
def test_a_hidden_effect_is_named_and_explains_a_second_recording(effect, excitation, seed):
    challenge, instrument = make_challenge(seed, (effect,), excitation), Instrument().exact()
    assert challenge.answer.ratio > 1.2, "the challenge hides nothing to be found"
    found = diagnosed(challenge, instrument)
    said = GradedDiagnosis.parse(answer(found).model_dump())
    assert effect in said.claimed, said.ranking[:3]
    base, final = found.ladder.base, found.ladder.final
    assert second_error(challenge, final, instrument) <= 1.1 * FORCE_NOISE
    assert second_error(challenge, base, instrument) > 1.15 * FORCE_NOISE


@pytest.mark.parametrize(("rig", "seed"), [("exact", 908), ("tolerant", 909)])
def test_nothing_is_found_where_nothing_is_hidden(rig, seed):
    challenge = make_challenge(seed, (), "sine10", rig)
    instrument = Instrument().exact() if rig == "exact" else Instrument()
    found = diagnosed(challenge, instrument)
    assert found.verdict == "adequate"
    assert found.effects == ()
    noise = np.hypot(FORCE_NOISE, PINK_NOISE if rig == "tolerant" else 0.0)
    assert second_error(challenge, found.ladder.base, instrument) <= 1.1 * noise
