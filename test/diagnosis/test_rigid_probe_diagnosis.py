"""A rigid probe: no state, a mass that is not known, few samples a second, steps instead of motion.

All forces are closed forms of this file.
"""

from dataclasses import replace

import numpy as np
import pytest

from tissue_probe.diagnosis.cleaning import clean_measurements
from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.improvement.ladder import climb_by
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.noise import Noise
from tissue_probe.diagnosis.ranking.candidates import fit_base
from tissue_probe.diagnosis.residuals.noise_floor import noise_floor
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import RIGID_PROBE
from tissue_probe.recording.clocks.lowpass import filter_block
from tissue_probe.signals import SampleBlock

RIG = Composition("rigid_probe")
FREE = Instrument(RIGID_PROBE)
STILL = Instrument(RIGID_PROBE, RIGID_PROBE.known | {"tip_mass": (0.0, 0.0)})
NO_TISSUE = Instrument(RIGID_PROBE, RIGID_PROBE.known | {"stiffness": (0.0, 0.0)})
MASS, VISCOUS, COULOMB, BIAS = 95.0, 203.0, 20.4, -3.2


def library(*names):
    return {name: EFFECTS[name] for name in names}


def drive(period=1e-3, duration=12.0, step=5e-8, noise=0.1):
    """Return a positioning drive as recorded: force on a mass with friction, rounded position."""
    time = np.arange(0.0, duration, period)
    amplitudes, rates = np.array([0.08, 0.03, 0.004]), 2 * np.pi * np.array([0.21, 0.53, 1.9])
    phases = np.outer(time, rates)
    position = np.sin(phases) @ amplitudes
    speed = np.cos(phases) @ (amplitudes * rates)
    acceleration = -np.sin(phases) @ (amplitudes * rates**2)
    force = MASS * acceleration + VISCOUS * speed + COULOMB * np.sign(speed) + BIAS
    force += noise * np.random.default_rng(1).standard_normal(time.size)
    rounded = np.round(position / step) * step
    return SampleBlock(0, 0, period, rounded, force, np.full(time.size, np.nan))


def measured(block):
    return Measurement(block.position, block.force, block.sample_period)


def probing(law, probes=80, noise=0.02, seed=0):
    """Return ten depths down to 3 mm, again and again, and the force of ``law`` at each."""
    rng = np.random.default_rng(seed)
    depth = np.tile(np.linspace(0.0, 3e-3, 10), probes) * np.repeat(rng.uniform(0.7, 1, probes), 10)
    return Measurement(depth, law(depth) + noise * rng.standard_normal(depth.size), 0.1)


def linear(depth):
    return 500.0 * depth


def convex(depth):
    return 0.5 * (depth / 1e-3) ** 2


def test_mass_and_friction_of_a_drive_are_found():
    block = filter_block(drive(), 100.0)
    ladder = climb_by(
        RIG, [measured(block)], NO_TISSUE, [EFFECTS["coulomb_friction"], EFFECTS["force_bias"]]
    )
    found = ladder.final.named()
    assert found["stiffness"] == 0.0
    assert found["tip_mass"] == pytest.approx(MASS, rel=0.01)
    assert found["damping"] == pytest.approx(VISCOUS, rel=0.01)
    assert found["coulomb_force"] == pytest.approx(COULOMB, rel=0.01)
    assert found["force_bias"] == pytest.approx(BIAS, abs=0.1)


def test_the_mass_is_found_through_the_steps_of_the_position_without_a_filter():
    (clean,), _ = clean_measurements([measured(drive())])
    for measurement in (measured(drive()), clean):
        found = fit_base(RIG, [measurement], NO_TISSUE).named()["tip_mass"]
        assert found == pytest.approx(MASS, rel=0.01)


def test_a_diagnosis_leaves_out_what_acts_on_a_spring_that_is_not_there():
    block = filter_block(drive(), 20.0)
    found = diagnose(
        RIG,
        [measured(block)],
        FREE,
        library("coulomb_friction", "load_cell_stiffness_error", "contact_loss"),
    )
    assert found.effects[0] == "coulomb_friction"
    assert {fit.composition.names[-1] for fit in found.ladder.ranking} <= {
        "coulomb_friction", "contact_loss",
    }  # fmt: skip


def test_asking_for_an_effect_on_the_missing_spring_is_answered_in_a_sentence():
    with pytest.raises(ValueError, match="cannot be fitted to these measurements of a rigid_probe"):
        diagnose(
            RIG,
            [probing(linear)],
            STILL,
            library("load_cell_stiffness_error"),
            wanted=["load_cell_stiffness_error"],
        )


@pytest.mark.parametrize("law", [linear, convex])
def test_the_noise_of_stepwise_probing_is_not_mistaken_for_its_motion(law):
    measurement = probing(law)
    assert noise_floor(measurement.force) > 2 * 0.02
    assert measurement.noise.own == pytest.approx(0.02, rel=0.1)


def test_stepwise_probing_shows_stiffening():
    found = diagnose(RIG, [probing(convex)], STILL, library("hertz_contact", "force_bias"))
    assert found.verdict == "missing"
    assert found.effects == ("hertz_contact",)
    assert found.ladder.final.named()["contact_exponent"] == pytest.approx(2.0, abs=0.05)


def test_stepwise_probing_of_a_linear_specimen_shows_none_and_no_fast_experiment_is_proposed():
    found = diagnose(RIG, [probing(linear)], STILL, library("hertz_contact", "cubic_stiffening"))
    assert (found.verdict, found.effects, found.suggestion) == ("adequate", (), None)


def test_relaxation_over_half_an_hour_has_two_branches():
    period, ramp, speed, noise = 0.5, 8.0, 0.02, 1e-3
    time = np.arange(0.0, 1800.0, period)
    force = 5.0 * speed * np.minimum(time, ramp)
    for stiffness, rate in ((2.0, 2e-3), (4.0, 0.1)):
        pressed = np.minimum(time, ramp)
        branch = stiffness * speed / rate * (1 - np.exp(-rate * pressed))
        force += branch * np.exp(-rate * (time - pressed))
    force += noise * np.random.default_rng(2).standard_normal(time.size)
    measurement = Measurement(speed * np.minimum(time, ramp), force, period, noise=Noise(noise))
    measurement = replace(measurement, at_rest=True)
    found = climb_by(RIG, [measurement], STILL, [EFFECTS["generalized_maxwell"]]).final
    rates = sorted(found.named()[f"relaxation_rate_{i}"] for i in (1, 2))
    assert found.converged
    assert rates == pytest.approx([2e-3, 0.1], rel=0.05)
