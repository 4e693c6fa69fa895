"""A rig driven by a force: what is missing is told from the position that answers."""

from dataclasses import replace

import numpy as np
import pytest
from hidden import first_of
from shaken import ENCODER, PERIOD, TIMES, Specimen, push, shaken

from tissue_probe.diagnosis.answer import answer
from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.noise import UNKNOWN_NOISE
from tissue_probe.diagnosis.ranking.candidates import fit_base
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import FORCE_DRIVEN
from tissue_probe.quantities import POSITION

#: The kernels of every effect are compiled where no earlier run has done so.
pytestmark = pytest.mark.timeout(900)

RIG = Composition("force_driven")
FREE = Instrument(FORCE_DRIVEN)
WEIGHED = Instrument(FORCE_DRIVEN, FORCE_DRIVEN.known | {"tip_mass": (0.08, 0.0008)})
#: The position is another's: its zero may be anywhere.
ANYWHERE = replace(FREE, any_zero=True)
SOFTER = {"preload": 0.6}


def taken(position, force, **more):
    return Measurement(position, force, PERIOD, at_rest=True, output=POSITION, **more)


@pytest.fixture(scope="module")
def plain():
    return shaken(Specimen())


def test_mass_stiffness_and_damping_are_found_without_being_known(plain):
    fit = fit_base(RIG, [taken(plain, push(TIMES))], FREE)
    found = fit.named()
    assert found["tip_mass"] == pytest.approx(0.08, rel=1e-3)
    assert found["stiffness"] == pytest.approx(600.0, rel=1e-3)
    assert found["damping"] == pytest.approx(6.0, rel=1e-2)
    assert fit.rmse == pytest.approx(ENCODER, rel=0.05)
    assert fit.ratio == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("size", [0.01, 1000.0])
def test_a_light_and_a_heavy_armature_are_found_alike(plain, size):
    """Force and mass in proportion: the motion is the same."""
    fit = fit_base(RIG, [taken(plain, size * push(TIMES))], FREE)
    assert fit.named()["tip_mass"] == pytest.approx(size * 0.08, rel=1e-3)


def test_where_nothing_is_hidden_nothing_is_found(plain):
    found = diagnose(RIG, [taken(plain, push(TIMES))], FREE, EFFECTS)
    assert (found.verdict, found.effects, found.suggestion) == ("adequate", (), None)


@pytest.mark.parametrize(
    ("effect", "specimen", "drive", "parameter", "value"),
    first_of(
        [
            ("cubic_stiffening", Specimen(cubic=1e7), {}, "cubic_stiffness", 1e7),
            ("standard_linear_solid", Specimen(relaxing=60.0), {}, "relaxation_rate", 40.0),
            ("coulomb_friction", Specimen(friction=0.02), {}, "coulomb_force", 0.02),
            ("contact_loss", Specimen(leaves=True), SOFTER, "stiffness", 600.0),
        ],
        2,
    ),
)
def test_what_is_hidden_is_named_first(effect, specimen, drive, parameter, value):
    position = shaken(specimen, **drive)
    found = diagnose(RIG, [taken(position, push(TIMES, **drive))], FREE, EFFECTS)
    assert found.effects == (effect,)
    assert found.verdict == "missing"
    assert found.ladder.final.named()[parameter] == pytest.approx(value, rel=0.02)
    assert found.ladder.final.ratio < 1.07


def test_a_constant_that_is_no_force_is_told_from_a_touch_within_its_tolerance(plain):
    biased = diagnose(RIG, [taken(plain, push(TIMES) + 0.3)], FREE, EFFECTS)
    assert biased.effects == ("force_bias",)
    assert biased.ladder.final.named()["force_bias"] == pytest.approx(0.3, abs=0.03)
    slight = diagnose(RIG, [taken(plain, push(TIMES) + 0.006)], FREE, EFFECTS)
    assert slight.verdict == "adequate"
    assert "force_bias" in slight.unseen


@pytest.mark.parametrize("zero", [0.0, 0.013, -0.7])
def test_a_position_whose_zero_nobody_knows_may_lie_anywhere(plain, zero):
    found = diagnose(RIG, [taken(plain + zero, push(TIMES))], ANYWHERE, EFFECTS)
    assert found.verdict == "adequate"
    assert found.ladder.final.named()["contact_position"] == pytest.approx(zero, abs=1e-6)
    assert found.ladder.final.named()["stiffness"] == pytest.approx(600.0, rel=2e-3)


def test_a_curved_spring_tells_the_zeros_of_force_and_position_apart():
    """Of a straight one they are the same: a score by the straight spring cannot tell them."""
    tried = {name: EFFECTS[name] for name in ("cubic_stiffening", "force_bias", "force_gain")}
    position = shaken(Specimen(cubic=3e7)) + 0.013
    found = diagnose(RIG, [taken(position, push(TIMES) + 0.3)], ANYWHERE, tried)
    assert set(found.effects) == {"cubic_stiffening", "force_bias"}
    assert found.verdict == "missing"
    values = found.ladder.final.named()
    assert values["contact_position"] == pytest.approx(0.013, abs=2e-5)
    assert values["force_bias"] == pytest.approx(0.3, abs=0.01)
    assert values["cubic_stiffness"] == pytest.approx(3e7, rel=0.02)


def test_a_gain_poses_as_another_mass_and_a_calibration_is_asked_for(plain):
    found = diagnose(RIG, [taken(plain, 1.08 * push(TIMES))], WEIGHED, EFFECTS)
    assert found.verdict == "ambiguous"
    assert set(found.indistinguishable) == {"added_mass", "force_gain"}
    assert not found.suggestion.excitation
    assert "known weight" in found.suggestion.calibration


def test_errors_are_in_metres(plain):
    made = answer(diagnose(RIG, [taken(plain, push(TIMES))], FREE, {}))
    assert made.output.model_dump() == {"quantity": "position", "unit": "m"}
    assert made.noise_floor == pytest.approx(ENCODER, rel=0.05)
    assert made.rmse.training.base == pytest.approx(ENCODER, rel=0.05)


@pytest.mark.parametrize("seed", first_of([5, 6, 7], 1))
def test_the_noise_of_the_force_is_not_held_against_the_model(plain, seed):
    """In the position it is slow: an effect could follow it, and chance alone makes it larger."""
    noise = 0.005 * np.random.default_rng(seed).standard_normal(TIMES.size)
    found = diagnose(RIG, [taken(plain, push(TIMES) + noise)], FREE, EFFECTS)
    base = found.ladder.base
    assert base.rmse > 5 * ENCODER
    assert base.ratio == pytest.approx(1.0, abs=0.05)
    assert (found.verdict, found.effects) == ("adequate", ())


def test_a_hidden_effect_is_found_beside_the_noise_of_the_force():
    noise = 0.005 * np.random.default_rng(5).standard_normal(TIMES.size)
    position = shaken(Specimen(friction=0.02))
    found = diagnose(RIG, [taken(position, push(TIMES) + noise)], FREE, EFFECTS)
    assert (found.verdict, found.effects) == ("missing", ("coulomb_friction",))
    assert found.ladder.final.ratio == pytest.approx(1.0, abs=0.05)


def test_a_spike_in_the_force_does_not_move_the_tip(plain):
    force = push(TIMES)
    force += 1e-4 * np.random.default_rng(6).standard_normal(force.size)
    force[[700, 2100]] += 5.0
    found = diagnose(RIG, [taken(plain, force)], FREE, {})
    assert [finding.name for finding in found.findings] == ["spikes"]
    assert found.verdict == "adequate"


def test_a_mass_that_nobody_gave_is_not_taken_for_known():
    assert np.isinf(FREE.exact().constants["tip_mass"][1])
    assert WEIGHED.exact().constants == {"tip_mass": (0.08, 0.0), "contact_position": (0.0, 0.0)}


def test_a_second_recording_is_predicted(plain):
    other = shaken(Specimen(), amplitude=0.7)
    second = taken(other, push(TIMES, amplitude=0.7))
    found = diagnose(RIG, [taken(plain, push(TIMES))], FREE, {}, [second])
    assert found.heldout(found.ladder.base) == pytest.approx(ENCODER, rel=0.05)


def test_a_wanted_effect_that_the_rig_cannot_have_is_refused_in_a_sentence(plain):
    told = "backlash cannot be fitted .* of a force_driven: it acts on a position that drives"
    measured = taken(plain, push(TIMES))
    with pytest.raises(ValueError, match=told):
        diagnose(RIG, [measured], FREE, EFFECTS, wanted=["backlash"])


def test_a_measurement_for_another_rig_is_refused(plain):
    swapped = replace(taken(plain, push(TIMES)), noise=UNKNOWN_NOISE)
    with pytest.raises(ValueError, match="compliant_probe predicts the force, and the measurement"):
        fit_base(Composition(), [swapped], Instrument())
