"""`tp.identify_contact`: right values and honest errors, and what a motion does not tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pressed import Pressed

import tissue_probe as tp
from tissue_probe.contact.contact import load
from tissue_probe.sensor.compensation import Compensation, save

KNOWN = {"delay": (4e-3, 1e-4), "constants": {"tip_mass": (0.8, 1e-3)}}
SINE = Pressed(sweep=0.0, middle=5.0)


def identified(pressed: Pressed, seed: int = 0, **known):
    return tp.identify_contact(tp.read(pressed.table(seed), force_polarity="compression"), **known)


@pytest.mark.parametrize("stiffness", [300.0, 1000.0, 3000.0])
def test_values_are_told_within_their_errors(stiffness):
    contact = identified(Pressed(stiffness), **KNOWN).contact
    assert contact.verdict == "adequate"
    assert contact.stiffness.deviation < 0.02 * stiffness
    for number, true in ((contact.stiffness, stiffness), (contact.damping, 3.0)):
        assert abs(number.value - true) < 3.0 * number.deviation


@pytest.mark.battery
@pytest.mark.parametrize("stiffness", [300.0, 3000.0])
def test_intervals_hold_the_truth_as_often_as_they_say(stiffness):
    held = []
    for seed in range(40):
        contact = identified(Pressed(stiffness), seed, **KNOWN).contact
        for number, true in ((contact.stiffness, stiffness), (contact.damping, 3.0)):
            held.append(abs(number.value - true) < 1.96 * number.deviation)
    # Of 80 intervals of 95 % fewer than 70 hold once in some hundred times.
    assert sum(held) >= 70


def test_the_error_and_the_range_in_which_it_held_are_told():
    contact = identified(Pressed(), **KNOWN).contact
    assert contact.error == pytest.approx(0.1, rel=0.1)
    assert contact.error_over_noise == pytest.approx(1.0, abs=0.1)
    assert contact.highest - contact.lowest == pytest.approx(2e-3, rel=0.02)
    assert contact.fastest == pytest.approx(2.0 * np.pi * 4.0 * 1e-3, rel=0.05)
    assert 0.5 <= contact.slow < 1.6
    assert 3.4 < contact.fast < 4.5


def test_several_recordings_each_have_their_own_zero():
    one, other = Pressed().table(1), Pressed().table(2)
    other["force"] += 2.0
    both, alone = (
        tp.identify_contact(tp.read(*tables, force_polarity="compression"), **KNOWN).contact
        for tables in ((one, other), (one,))
    )
    assert both.stiffness.value == pytest.approx(1000.0, rel=0.02)
    assert both.stiffness.deviation < 0.8 * alone.stiffness.deviation


def test_a_steady_sine_does_not_tell_mass_from_stiffness_nor_delay_from_damping():
    result = identified(SINE)
    assert result.verdict == "cannot tell"
    assert not result.contact.stiffness.told
    assert not result.contact.damping.told
    mass, delay = result.to_tell
    assert mass.startswith("stiffness and tip_mass are hardly told apart")
    assert "state `constants` tip_mass" in mass
    assert delay.startswith("damping and channel_delay are hardly told apart")
    assert "state `delay`" in delay


def test_with_mass_and_delay_known_a_steady_sine_tells_both():
    contact = identified(SINE, **KNOWN).contact
    assert contact.verdict == "adequate"
    assert abs(contact.stiffness.value - 1000.0) < 3.0 * contact.stiffness.deviation
    assert abs(contact.damping.value - 3.0) < 3.0 * contact.damping.deviation


def test_an_error_of_the_delay_is_one_of_the_damping():
    exact = replace(SINE, place_noise=0.0)
    near, far = (
        identified(exact, delay=(4e-3, deviation), constants={"tip_mass": 0.8}).contact.damping
        for deviation in (1e-5, 1e-3)
    )
    # k times the error of the delay, by the part of k that the mass leaves.
    dynamic = 1000.0 - 0.8 * (2.0 * np.pi * 5.0) ** 2
    assert far.deviation**2 - near.deviation**2 == pytest.approx((dynamic * 1e-3) ** 2, rel=0.3)


def test_damping_beneath_the_noise_is_not_told():
    result = identified(Pressed(damping=0.05, seconds=2.0), **KNOWN)
    assert result.contact.stiffness.told
    assert not result.contact.damping.told
    assert any(sentence.startswith("damping") for sentence in result.to_tell)


def test_samples_out_of_contact_are_left_out_and_told():
    result = identified(Pressed(touch=1.5e-3), **KNOWN)
    assert result.verdict == "adequate"
    (told,) = [note for note in result.notes if "out of contact" in note]
    assert "below 1.5" in told
    assert abs(result.contact.stiffness.value - 1000.0) < 3.0 * result.contact.stiffness.deviation
    assert result.contact.lowest > 1.45e-3


def test_a_tip_that_is_mostly_out_of_contact_is_refused():
    with pytest.raises(tp.TissueProbeError, match=r"out of contact in .* press deeper"):
        identified(Pressed(touch=2.6e-3), **KNOWN)


@pytest.mark.parametrize("stiffening", [2e5, -3e5])
def test_a_tissue_that_is_softer_on_one_side_is_not_taken_for_air(stiffening):
    result = identified(Pressed(stiffening=stiffening), **KNOWN)
    assert not any("left out" in note for note in result.notes)
    assert result.verdict == "missing"
    assert result.contact.error_over_noise > 1.1
    assert "tissue_probe diagnose" in result.text


def test_where_the_touch_is_stated_its_error_is_one_of_the_stiffness():
    # A preload of 2 mm known to .1 mm: 5 % of the mean force over k.
    table = Pressed(sweep=0.0).table()
    table["force"] -= 5.0
    read = tp.read(table, force_polarity="compression")
    stated = {"delay": 4e-3, "constants": {"tip_mass": 0.8, "contact_position": (0.0, 1e-6)}}
    contact = tp.identify_contact(read, **stated).contact
    free = identified(Pressed(sweep=0.0), delay=4e-3, constants={"tip_mass": 0.8}).contact
    assert contact.stiffness.deviation < 0.5 * free.stiffness.deviation
    assert contact.stiffness.value == pytest.approx(1000.0, rel=0.03)


@pytest.mark.parametrize(
    ("known", "sentence"),
    [
        ({"delay": 0.3}, r"`delay` is 0\.3 s; give .* off the times of the force"),
        ({"delay": (0.004, -1.0)}, "`delay`: its standard deviation is below 0"),
        ({"constants": {"mass": 0.8}}, "mass is no constant of rigid_probe"),
        (
            {"drift": 0.0, "constants": {"contact_position": 0.0}},
            "`drift`: contact_position says that the force's zero is right",
        ),
    ],
)
def test_contradictions_are_refused_in_a_sentence(known, sentence):
    with pytest.raises(tp.TissueProbeError, match=sentence):
        identified(Pressed(seconds=1.0), **known)


def test_the_file_is_read_back_as_it_was_written(tmp_path):
    result = identified(Pressed(), **KNOWN)
    result.save(tmp_path / "contact.yaml")
    again = load(tmp_path / "contact.yaml")
    assert again.stiffness.value == pytest.approx(result.contact.stiffness.value, rel=1e-8)
    assert again.text() == result.contact.text()


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("format: tissue_probe contact 1", "format: other", "it is no contact"),
        ("verdict: adequate", "verdict: fine", "its verdict is none of"),
        ("error_over_noise:", "other:", "its error_over_noise is no finite number"),
        ("stiffness: {value: ", "stiffness: {value: -", "its stiffness value is below 0"),
    ],
)
def test_a_damaged_file_is_refused(tmp_path, old, new, sentence):
    path = tmp_path / "contact.yaml"
    identified(Pressed(seconds=2.0), **KNOWN).save(path)
    path.write_text(path.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    with pytest.raises(tp.TissueProbeError, match=sentence):
        load(path)


def test_a_model_of_the_sensor_states_mass_delay_and_drift(tmp_path):
    sensor = Compensation(
        load=np.array([0.8, *9 * [0.0]]),
        gains=np.ones(6),
        delay=4e-3,
        bias=np.zeros(6),
        rate=np.array([0.01, 0.0, 0.01, 0.0, 0.0, 0.0]),
        drift_covariance=np.zeros((6, 2, 2)),
        unrest=np.zeros(6),
        deviation=np.zeros(6),
        noise=np.ones(6),
        noise_of_zero=np.ones(6),
        range=np.ones(3),
        stamp=0,
        cable=None,
        weights=np.empty((6, 0)),
        mass_deviation=1e-3,
        delay_deviation=1e-4,
    )
    save(tmp_path / "sensor.yaml", sensor)
    drift = (0.0, np.hypot(0.01, 0.01))
    of_file = identified(SINE, sensor=tmp_path / "sensor.yaml").contact
    assert of_file.stiffness == identified(SINE, **KNOWN, drift=drift).contact.stiffness
    # A file of an earlier version has no errors: then both are free, and the sine tells neither.
    save(
        tmp_path / "sensor.yaml",
        replace(sensor, mass_deviation=np.inf, delay_deviation=np.inf),
    )
    assert identified(SINE, sensor=tmp_path / "sensor.yaml").verdict == "cannot tell"
