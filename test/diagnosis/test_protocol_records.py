"""Records as laboratories make them: ramps and holds, a touch in the record, commands, few samples.

All forces and motions are closed forms or SciPy's; none is the project's.
"""

import numpy as np
import pytest
from scipy.signal import lsim

import tissue_probe as tp
from tissue_probe.diagnosis.cleaning import clean_measurements, from_touch
from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.evidence.adequacy import leaves_only_noise
from tissue_probe.diagnosis.input_course import with_input
from tissue_probe.diagnosis.inspection.inspection import inspect
from tissue_probe.diagnosis.inspection.touch import first_touch
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.response import Between
from tissue_probe.quantities import POSITION

RIGID_PROBE, DRIVEN = Composition("rigid_probe"), Composition("force_driven")
STILL = Instrument(RIGID_PROBE.rig, RIGID_PROBE.rig.known | {"tip_mass": (0.0, 0.0)})
MOVED = Instrument(DRIVEN.rig)


def relaxation(seed=0, ramp=0.1, hold=20.0, rate=50.0, noise=3e-3):
    """Return a ramp to 4 mm from the first sample, a hold, and the force of a relaxing solid."""
    time = np.arange(0.0, hold, 1.0 / rate)
    speed, slow, k, k1 = 4e-3 / ramp, 0.5, 100.0, 300.0
    pressed = np.minimum(time, ramp)
    branch = speed / slow * (np.exp(-slow * (time - pressed)) - np.exp(-slow * time))
    force = k * speed * pressed + k1 * branch
    return speed * pressed, force + noise * np.random.default_rng(seed).standard_normal(time.size)


@pytest.mark.parametrize("noise", [0.0, 2e-6])
def test_a_ramp_and_a_long_hold_are_motion_and_of_the_right_sign(noise):
    position, force = relaxation()
    position = position + noise * np.random.default_rng(1).standard_normal(position.size)
    assert not inspect(position, force, 0.02).fatal


@pytest.mark.parametrize("noise", [0.0, 2e-6])
def test_the_same_with_the_wrong_sign_is_refused(noise):
    position, force = relaxation()
    position = position + noise * np.random.default_rng(1).standard_normal(position.size)
    assert inspect(position, -force, 0.02)["wrong_polarity"].fatal


def test_a_relaxing_solid_explains_a_ramp_and_hold_from_the_first_sample():
    (clean,), _ = clean_measurements([Measurement(*relaxation(), 0.02, at_rest=True)])
    base = fit_base(RIGID_PROBE, [clean], STILL)
    (found,) = fit_candidates(base, [EFFECTS["standard_linear_solid"]], STILL)
    assert leaves_only_noise(found)
    assert found.named()["relaxation_rate"] == pytest.approx(0.5, rel=0.05)


@pytest.mark.parametrize("samples", [100, 400, 2000])
def test_clean_records_are_explained_however_few_samples_they_have(samples):
    right, count = 0, 25
    for seed in range(count):
        random = np.random.default_rng(seed)
        phase = 2.0 * np.pi * 4.0 * np.arange(samples) / samples
        period = 4.0 / samples
        position, speed = 3e-3 * np.sin(phase), 3e-3 * 2.0 * np.pi * np.cos(phase)
        force = 200.0 * position + 30.0 * speed + 0.01 * random.standard_normal(samples)
        (clean,), _ = clean_measurements([Measurement(position, force, period)])
        right += leaves_only_noise(fit_base(RIGID_PROBE, [clean], STILL))
    assert right >= count - 2


def touching(seed=0, noise=1e-3, exponent=1.5, surface=1.8e-3, stiffness=4000.0):
    """Return a tip that comes from the air, presses a sphere in and draws it out again."""
    time = np.arange(0.0, 4.0, 2e-3)
    position = 2e-3 * (1.0 - np.abs(time / 2.0 - 1.0)) * 2.0
    force = stiffness * np.maximum(position - surface, 0.0) ** exponent
    return position, force + noise * np.random.default_rng(seed).standard_normal(time.size)


def test_the_touch_is_found_where_a_record_begins_in_the_air():
    position, force = touching()
    found = first_touch(position, force, 1e-3)
    assert found.position == pytest.approx(1.8e-3, abs=0.2e-3)


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0])
def test_none_is_found_where_the_tip_touches_from_the_first_sample_on(exponent):
    position, force = touching(
        surface=0.0, exponent=exponent, stiffness=400.0 / 2e-3 ** (exponent - 1)
    )
    assert first_touch(position, force, 1e-3) is None


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("zero", [lambda t: 0.1 * t, lambda t: 0.3 * np.exp(-t / 0.5)])
def test_the_touch_is_found_where_the_zero_drifts_or_settles_by_many_times_the_noise(zero, seed):
    position, force = touching(seed, stiffness=4e4)
    force += zero(2e-3 * np.arange(force.size))
    found = first_touch(position, force, 1e-3)
    assert found.position == pytest.approx(1.8e-3, abs=0.1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_the_touch_is_found_before_cycles_that_stay_in_contact(seed):
    """Their peaks are alike, and the noise of the position chooses the highest."""
    random = np.random.default_rng(seed)
    peaks = np.tile([4.6e-3, 3.5e-3], 3)
    position = np.interp(np.arange(2320), 100 + 220 * np.arange(7), [0.0, *peaks])
    force = 0.05 + 350.0 * np.maximum(position - 3.1e-3, 0.0)
    force += 2e-3 * random.standard_normal(force.size)
    found = first_touch(position + 5e-7 * random.standard_normal(force.size), force, 2e-3)
    assert found.position == pytest.approx(3.1e-3, abs=5e-5)
    assert found.zero == pytest.approx(0.05, abs=1e-3)


def test_the_touch_is_found_in_a_simulation_without_noise():
    position, force = touching(noise=0.0)
    found = first_touch(position, force, 0.0)
    assert found.position == pytest.approx(1.8e-3, abs=1e-4)
    assert found.zero == 0.0


def test_the_air_tells_the_zero_and_so_the_place_of_the_touch():
    position, force = touching(exponent=1.0, stiffness=400.0)
    (clean,), _ = clean_measurements([Measurement(position, force + 0.05, 2e-3)])
    (pressed,), instrument, (told,) = from_touch([clean], STILL)
    fit = fit_base(RIGID_PROBE, [pressed.without(pressed.position < 1.85e-3)], instrument)
    assert fit.named()["contact_position"] == pytest.approx(1.8e-3, abs=2e-6)
    assert "0.05 N, is taken off" in told.sentence


@pytest.mark.parametrize("seed", range(3))
def test_a_zero_that_drifts_without_end_is_no_touch(seed):
    position, _ = touching(seed)
    time = 2e-3 * np.arange(position.size)
    force = 0.05 * time**2 + 1e-3 * np.random.default_rng(seed).standard_normal(time.size)
    assert first_touch(position, force, 1e-3) is None


@pytest.mark.parametrize("seed", [0, 499])
def test_a_pressed_tip_that_begins_to_swing_touches_nothing(seed):
    """Its force swings by newtons about its course, and goes by the speed, not by the way."""
    random, time = np.random.default_rng(seed), np.arange(600) / 2000.0
    waves = np.sin(2.0 * np.pi * np.outer(time, np.arange(1, 61)) + random.uniform(0.0, 6.28, 60))
    position = 2.2e-3 + 1e-4 * waves.sum(axis=1) * np.minimum(time / 0.02, 1.0) ** 2
    force = 300.0 * position + 3.4 * np.gradient(position, time)
    assert first_touch(position, force + 5e-3 * random.standard_normal(600), 5e-3) is None


def test_a_force_that_grows_while_the_tip_rests_is_no_touch():
    position = np.concatenate([np.linspace(0.0, 1e-6, 40), np.full(200, 1e-6)])
    force = np.where(np.arange(240) < 60, 0.0, 0.1)
    assert first_touch(position, force, 1e-3) is None


def test_the_touch_point_is_fitted_and_the_law_of_contact_found():
    given = Measurement(*touching(), 2e-3)
    found = diagnose(
        RIGID_PROBE,
        [given],
        STILL,
        {name: EFFECTS[name] for name in ("hertz_contact", "force_drift")},
    )
    assert (found.verdict, found.effects) == ("missing", ("hertz_contact",))
    final = found.ladder.final
    assert final.named()["contact_exponent"] == pytest.approx(1.5, abs=0.1)
    assert final.named()["contact_position"] == pytest.approx(1.8e-3, abs=3e-5)
    assert any(finding.name == "touch" for finding in found.findings)


def test_the_samples_before_the_touch_are_left_out():
    clean, _ = clean_measurements([Measurement(*touching(), 2e-3)])
    (kept,), instrument, (told,) = from_touch(clean, STILL)
    assert kept.begins == pytest.approx(2e-3 * (2000 - kept.position.size))
    assert np.isinf(instrument.constants["contact_position"][1])
    assert "touches at about" in told.sentence


MASS, STIFFNESS, DAMPING = 0.05, 200.0, 1.0


def pushed(force, period, held):
    """Return the position of a mass on Kelvin-Voigt tissue, by SciPy."""
    system = (
        [[0.0, 1.0], [-STIFFNESS / MASS, -DAMPING / MASS]],
        [[0.0], [1.0 / MASS]],
        [[1.0, 0.0]],
        0,
    )
    times = np.arange(force.size) * period
    return lsim(system, force, times, interp=not held)[1]


def of_a_command(seed=0, noise=1e-6):
    force = np.where(np.arange(4000) < 200, 0.0, 1.0)
    position = pushed(force, 1e-3, held=True)
    position = position + noise * np.random.default_rng(seed).standard_normal(force.size)
    return Measurement(position, force, 1e-3, at_rest=True, output=POSITION)


def test_a_force_that_a_converter_holds_is_told_and_the_values_are_right():
    clean, findings = clean_measurements([of_a_command()])
    assert not findings  # a command that rests is not stuck
    held, (told,) = with_input(DRIVEN, clean, MOVED)
    assert held[0].between is Between.held
    assert "command" in told.sentence
    fit = fit_base(DRIVEN, held, MOVED)
    for name, true in (("tip_mass", MASS), ("stiffness", STIFFNESS), ("damping", DAMPING)):
        assert abs(fit.named()[name] - true) < 3.0 * fit.deviations()[name]
    assert leaves_only_noise(fit)


def test_a_force_that_goes_on_straight_between_its_samples_is_told_and_the_values_are_right():
    """Square waves, of which a spline overshoots every jump."""
    random = np.random.default_rng(4)
    force = np.where(np.arange(3000) // 170 % 2 == 1, 1.0, 0.0)
    position = pushed(force, 2e-3, held=False) + 1e-6 * random.standard_normal(force.size)
    record = Measurement(position, force, 2e-3, at_rest=True, output=POSITION)
    clean, _ = clean_measurements([record])
    straight, (told,) = with_input(DRIVEN, clean, MOVED)
    assert straight[0].between is Between.straight
    assert "straight lines" in told.sentence
    fit = fit_base(DRIVEN, straight, MOVED)
    for name, true in (("tip_mass", MASS), ("stiffness", STIFFNESS), ("damping", DAMPING)):
        assert abs(fit.named()[name] - true) < 3.0 * fit.deviations()[name]
    assert leaves_only_noise(fit)


def test_a_step_before_a_long_rest_is_motion_and_has_the_right_sign():
    random = np.random.default_rng(5)
    position = np.where(np.arange(20_000) < 1, 0.0, 5e-3) + 3e-5 * random.standard_normal(20_000)
    force = 300.0 * np.where(np.arange(20_000) < 1, 0.0, 5e-3) + 1e-3 * random.standard_normal(
        20_000
    )
    assert not [each for each in inspect(position, force, 1e-2).findings if each.fatal]


def test_a_measured_force_is_not_taken_for_a_command():
    random = np.random.default_rng(2)
    time = np.arange(3000) * 1e-3
    force = np.sin(2 * np.pi * 2.0 * time) + 0.3 * np.sin(2 * np.pi * 7.0 * time)
    position = pushed(force, 1e-3, held=False) + 1e-6 * random.standard_normal(time.size)
    noisy = force + 2e-3 * random.standard_normal(time.size)
    clean, _ = clean_measurements([Measurement(position, noisy, 1e-3, output=POSITION)])
    same, told = with_input(DRIVEN, clean, MOVED)
    assert same[0].between is None
    assert not told


def rough_push(held):
    """Return a noisy record of a tip that is driven by slow noise of a converter, or smooth one."""
    random, period = np.random.default_rng(5), 2e-3
    spectrum = np.zeros(801, complex)
    spectrum[5:60] = random.standard_normal(55) + 1j * random.standard_normal(55)
    force = np.fft.irfft(spectrum, 1600)
    force *= np.minimum(np.arange(1600) / 100.0, 1.0) / np.abs(force).max()
    position = pushed(force, period, held) + 1e-5 * random.standard_normal(force.size)
    read = force + 1e-4 * random.standard_normal(force.size)
    return {"t": period * np.arange(force.size), "u": position, "F": read}


def test_a_held_force_that_was_measured_and_never_jumps_is_told_too():
    recording = tp.read(rough_push(held=True), force_polarity="compression")
    found = tp.diagnose(recording, rig="force_driven", starts="at-rest")
    assert found.verdict == "adequate"
    assert any("a converter puts out" in note for note in found.notes)
    stated = tp.compare(recording, rig="force_driven", starts="at-rest", course="held")
    assert stated.fit.named() == pytest.approx(found.found.ladder.base.named())
    smooth = tp.compare(recording, rig="force_driven", starts="at-rest", course="smooth")
    assert smooth.fit.ratio > 2.0 * stated.fit.ratio


def test_a_position_is_not_held():
    position, force = relaxation()
    table = {"t": 0.02 * np.arange(position.size), "u": position, "F": force}
    recording = tp.read(table, force_polarity="compression")
    with pytest.raises(tp.TissueProbeError, match="`course`: the position drives"):
        tp.compare(recording, rig="rigid_probe", course="held")


def test_creep_of_an_unknown_mass_is_that_of_a_relaxing_solid():
    from scipy.integrate import solve_ivp

    rate, mass, k, k1, beta, tau = 100.0, 0.2, 400.0, 300.0, 8.0, 3.0
    time = np.arange(0.0, 20.0, 1.0 / rate)
    load = np.clip((time - 0.5) / 0.05, 0.0, 1.0) * 0.6

    def slope(t, z):
        push = np.clip((t - 0.5) / 0.05, 0.0, 1.0) * 0.6
        return [z[1], (push - k * z[0] - beta * z[1] - k1 * z[2]) / mass, z[1] - z[2] / tau]

    answer = solve_ivp(
        slope, (0.0, 20.0), [0.0] * 3, t_eval=time, rtol=1e-9, atol=1e-12, max_step=0.01
    )
    random = np.random.default_rng(3)
    position = answer.y[0] + 5e-6 * random.standard_normal(time.size)
    force = load + 1e-3 * random.standard_normal(time.size)
    clean, _ = clean_measurements(
        [Measurement(position, force, 1.0 / rate, at_rest=True, output=POSITION)]
    )
    base = fit_base(DRIVEN, clean, MOVED)
    (found,) = fit_candidates(base, [EFFECTS["standard_linear_solid"]], MOVED)
    assert found.ratio < 1.15
    assert found.named()["tip_mass"] == pytest.approx(mass, rel=0.2)
    assert found.named()["relaxation_rate"] == pytest.approx(1.0 / tau, rel=0.1)


@pytest.mark.parametrize("jitter", [0.1, 0.3])
def test_clean_records_of_uneven_times_are_explained(jitter):
    right, inside, count = 0, 0, 10
    for seed in range(count):
        random = np.random.default_rng(seed)
        time = (np.arange(1500) + jitter * random.uniform(-1.0, 1.0, 1500)) * 0.01
        phase = 2.0 * np.pi * 0.8 * time
        position, speed = 2e-3 * np.sin(phase), 2e-3 * 2.0 * np.pi * 0.8 * np.cos(phase)
        force = 300.0 * position + 8.0 * speed + 0.01 * random.standard_normal(time.size)
        table = {"t": time, "u": position, "F": force}
        read = tp.read(table, force_polarity="compression")
        fit = tp.compare(read, rig="rigid_probe", constants={"tip_mass": 0.0}).fit
        right += leaves_only_noise(fit)
        for name, true in (("stiffness", 300.0), ("damping", 8.0)):
            inside += abs(fit.named()[name] - true) <= 1.96 * fit.deviations()[name]
    assert right >= count - 1
    assert inside >= 2 * count - 4


def out_of_the_air(seed, damping=2000.0, period=1e-2):
    """Return cycles out of the air into tissue that is mostly damping, and where it is touched."""
    random, lasts, fine = np.random.default_rng(seed), 3.0, 50
    time = np.arange(0.0, 3.0 * lasts, period / fine)
    phase = np.mod(time - 0.5, lasts)
    away = np.minimum(np.abs(phase - 0.5 * lasts), np.minimum(phase, lasts - phase))
    speed = np.sin(0.5 * np.pi * np.minimum(away / 0.05, 1.0))
    speed *= np.where(phase < 0.5 * lasts, 3.5e-3, -3.5e-3) * (time > 0.5)
    course = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) * period / fine])
    u, v, place = course[::fine], speed[::fine], 2.5e-3 + random.uniform(0.0, 1e-4)
    force = np.where(u > place, 1200.0 * (u - place) + damping * v, 0.0)
    force += 4e-3 * random.standard_normal(u.size)
    return Measurement(u, force, period, at_rest=True), place


@pytest.mark.parametrize("seed", [0, 1])
def test_a_touch_is_found_where_the_tissue_resists_by_damping_at_once(seed):
    measurement, place = out_of_the_air(seed)
    (clean,), _ = clean_measurements([measurement])
    (pressed,), instrument, _ = from_touch([clean], STILL)
    base = fit_base(RIGID_PROBE, [pressed], instrument)
    (found,) = fit_candidates(base, [EFFECTS["contact_loss"]], instrument)
    assert found.ratio == pytest.approx(1.0, abs=0.12)
    assert found.named()["contact_position"] == pytest.approx(place, abs=2e-6)
