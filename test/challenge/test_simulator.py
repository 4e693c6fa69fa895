"""Challenges as a whole: their randomness, noise, rigs, and second recordings."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

from tissue_probe.challenge import make_challenge, series
from tissue_probe.challenge.kelvin_voigt import fit_residual
from tissue_probe.challenge.mechanical import ONLY_BY_NAME
from tissue_probe.challenge.record import follow
from tissue_probe.challenge.series import SHARES, all_show, deal, make_series
from tissue_probe.challenge.simulator import LIBRARY, SIMULATED_EFFECTS, HiddenTruth
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.trajectory import DURATIONS


def rig_of(answer: HiddenTruth) -> Specimen:
    numbers = {name: answer.rig[name] for name in ("tip_mass", "load_cell_stiffness")}
    damping = answer.rig["load_cell_damping"]
    return Specimen(**numbers, load_cell_damping=damping, **answer.tissue)


def test_the_same_seed_makes_the_same_challenge():
    one, other = (make_challenge(4, ("mains_hum",), "sine10") for _ in range(2))
    for name in ("recording", "second"):
        for column in ("time", "position", "force"):
            np.testing.assert_array_equal(
                getattr(getattr(one, name), column), getattr(getattr(other, name), column)
            )
    assert one.answer == other.answer


def test_another_seed_makes_another_tissue_noise_and_strength():
    one, other = (make_challenge(seed, ("mains_hum",), "sine10").answer for seed in (4, 5))
    assert one.tissue != other.tissue
    assert one.targets != other.targets
    clean = [make_challenge(seed, (), "sine10", preload=0.0).recording.force for seed in (4, 5)]
    # The start is the same for all: the coil begins to move.
    assert abs(np.corrcoef(np.diff(clean, 2)[:, 200:])[0, 1]) < 0.1


@pytest.mark.parametrize("kind", DURATIONS)
def test_a_clean_recording_leaves_its_white_noise(kind):
    challenge = make_challenge(8, (), kind)
    for recording in (challenge.recording, challenge.second):
        left = fit_residual(recording.position, recording.force, rig_of(challenge.answer))
        assert left.std() == pytest.approx(5e-3, rel=0.04)
        assert abs(np.corrcoef(left[1:], left[:-1])[0, 1]) < 0.05
        assert recording.time.size == round(DURATIONS[kind] / recording.sample_period)
        np.testing.assert_allclose(np.diff(recording.time), 5e-4)
        steps = recording.position / 1e-7
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    assert challenge.answer.ratio < 1.01  # the encoder's steps
    assert challenge.answer.effects == ()


@pytest.fixture(scope="module")
def tolerant():
    return [make_challenge(seed, (), "sine10", "tolerant").answer for seed in range(50)]


def test_half_of_the_recordings_are_preloaded_and_tissues_span_their_range(tolerant):
    preloads = np.array([answer.excitation["preload"] for answer in tolerant])
    assert 14 <= np.sum(preloads == 0.0) <= 36
    assert np.all((preloads == 0.0) | ((preloads >= 1e-3) & (preloads <= 3e-3)))
    k, beta = np.array([list(answer.tissue.values()) for answer in tolerant]).T
    assert 150.0 <= k.min() < 300.0
    assert 1500.0 < k.max() <= 3000.0
    assert 0.5 <= beta.min() < 1.0
    assert 7.5 < beta.max() <= 15.0


def test_the_second_recording_is_of_the_same_specimen_with_another_motion():
    challenge = make_challenge(6, ("cubic_stiffening",), "sine10", preload=1e-3)
    answer = challenge.answer
    assert answer.excitation["kind"] == "sine10"
    assert answer.second_excitation["kind"] == "msine60"
    assert answer.second_excitation["preload"] == answer.excitation["preload"]
    left = fit_residual(challenge.second.position, challenge.second.force, rig_of(answer))
    assert left.std() > 1.05 * 5e-3


def test_an_exact_rig_is_the_nominal_one():
    rig = make_challenge(3, (), "sine10").answer.rig
    assert rig == {
        "name": "exact",
        "tip_mass": 0.04,
        "load_cell_stiffness": 9700.0,
        "load_cell_damping": 0.8,
        "contact_zero": 0.0,
    }


def test_a_tolerant_rig_is_off_by_its_tolerances(tolerant):
    rigs = [answer.rig for answer in tolerant]
    for name, nominal, deviation in (
        ("tip_mass", 0.04, 0.01),
        ("load_cell_stiffness", 9700.0, 0.015),
        ("load_cell_damping", 0.8, 0.20),
    ):
        values = np.array([rig[name] for rig in rigs])
        assert np.std(np.log(values / nominal)) == pytest.approx(deviation, rel=0.35)
    zeros = np.array([rig["contact_zero"] for rig in rigs])
    assert zeros.std() == pytest.approx(30e-6, rel=0.35)


def test_the_rigs_tolerances_do_not_count_as_the_effects_strength():
    for seed in range(4):
        answer = make_challenge(seed, ("force_drift",), "sine10", "tolerant").answer
        assert answer.ratio == pytest.approx(answer.targets["force_drift"], rel=0.03)
        clean = make_challenge(seed, (), "sine10", "tolerant")
        assert clean.answer.ratio < 1.01


def test_two_effects_each_leave_at_least_twice_the_noise_alone():
    for challenge in make_series("two", 6, 1, "sine10", "exact"):
        answer = challenge.answer
        assert len(set(answer.families)) == 2
        assert min(answer.ratios.values()) >= 1.9
        assert not answer.absorbed
        assert set(answer.parameters) == set(answer.effects)


def test_of_two_effects_on_a_tolerant_rig_none_hides_within_its_tolerances():
    for challenge in make_series("two", 6, 2, "sine10", "tolerant"):
        answer = challenge.answer
        assert min(answer.shown.values()) >= 1.05
        assert all(answer.shown[name] <= 1.01 * answer.ratios[name] for name in answer.effects)


def test_pairs_of_which_one_hides_within_the_tolerances_are_drawn_anew():
    made = make_challenge(343000, ("force_bias", "stiffness_ramp"), "sine10", "tolerant").answer
    hides = replace(made, ratios={"a": 3.0, "b": 3.0}, shown={"a": 1.04, "b": 2.0})
    assert not all_show(hides)
    assert all_show(replace(hides, shown={"a": 1.06, "b": 2.0}))
    assert not all_show(replace(hides, ratios={"a": 1.8, "b": 3.0}, shown={"a": 2.0, "b": 2.0}))
    assert all_show(replace(hides, effects=("a",)))


def test_what_the_rigs_tolerances_could_make_of_an_effect_is_told():
    gain = make_challenge(77, ("force_gain",), "chirp60", "tolerant").answer
    assert gain.ratios["force_gain"] > 2.0
    assert gain.shown["force_gain"] < 1.05
    hum = make_challenge(77, ("mains_hum",), "sine10", "tolerant").answer
    assert hum.shown["mains_hum"] == pytest.approx(hum.ratios["mains_hum"], rel=0.02)
    exact = make_challenge(77, ("force_gain",), "chirp60", "exact").answer
    assert exact.shown == exact.ratios


def wobble(amplitude, preload, duration=1.0):
    """A motion of two sines, as it was measured."""
    time = np.arange(round(2_000 * duration)) / 2_000
    moved = np.sin(2.0 * np.pi * 7.0 * time) + 0.5 * np.cos(2.0 * np.pi * 23.0 * time)
    return follow(time, preload + amplitude / 1.5 * moved, "wobble.csv")


def test_a_measured_motion_is_repeated_and_told():
    motion = wobble(0.7e-3, 1.5e-3)
    one, other = (make_challenge(3, ("cubic_stiffening",), motion) for _ in range(2))
    np.testing.assert_array_equal(one.recording.force, other.recording.force)
    assert one.answer == other.answer
    told, second = one.answer.excitation, one.answer.second_excitation
    assert told["source"] == "wobble.csv"
    assert (told["kind"], told["starts"]) == ("measured", "moving")
    assert told["duration"] == second["duration"] == motion.duration
    assert told["amplitude"] == second["amplitude"] == motion.amplitude
    assert told["preload"] == second["preload"] == pytest.approx(1.5e-3, rel=0.01)
    assert second["kind"] == "msine60"
    u = motion.preload + motion.amplitude * motion.course(one.recording.time)
    np.testing.assert_allclose(one.recording.position, u, atol=0.6e-7)
    json.dumps(asdict(one.answer))


@pytest.mark.parametrize("name", ["mains_hum", "springpot", "hertz_contact", "backlash"])
def test_effects_are_scaled_for_a_measured_motion(name):
    answer = make_challenge(5, (name,), wobble(0.7e-3, 20e-6), "tolerant").answer
    assert answer.ratio == pytest.approx(answer.targets[name], rel=0.1)


def test_what_a_measured_motion_cannot_show_is_absorbed():
    hidden = {"added_mass", "load_cell_stiffness_error", "coulomb_friction"}
    for name in hidden:
        answer = make_challenge(5, (name,), wobble(12e-6, 0.0)).answer
        assert answer.absorbed == (name,)


def test_of_two_effects_one_is_hidden_where_no_two_would_show(monkeypatch):
    monkeypatch.setattr(series, "all_show", lambda answer: len(answer.effects) < 2)
    monkeypatch.setattr(series, "PAIRS_TRIED", 3)
    for made in make_series("two", 2, 0, "sine10", "exact"):
        assert len(made.answer.effects) == 1


@pytest.mark.battery
def test_any_deals_every_excitation():
    made = list(make_series("none", 20, 1, "any", "exact"))
    kinds = [each.answer.excitation["kind"] for each in made]
    assert set(kinds) == set(DURATIONS)
    again = make_series("none", 3, 1, "any", "exact")
    for one, other in zip(made, again, strict=False):
        np.testing.assert_array_equal(one.recording.force, other.recording.force)


def test_an_answer_is_plain_json():
    answer = make_challenge(2, ("springpot", "stuck_samples"), "sine10", "tolerant").answer
    assert json.loads(json.dumps(asdict(answer)))["seed"] == 2


def test_a_pack_deals_every_effect_before_one_comes_twice():
    alone = [name for name, effect in LIBRARY.items() if not effect.beside]
    dealt = deal("one", 2 * len(alone), np.random.default_rng(0))
    assert sorted(dealt) == sorted([(name,) for name in alone] * 2)


def test_a_mixture_has_every_kind():
    dealt = deal("mixed", 400, np.random.default_rng(0))
    assert np.mean([len(effects) == 2 for effects in dealt]) == pytest.approx(0.15, abs=0.05)
    assert np.mean([not effects for effects in dealt]) == pytest.approx(0.1, abs=0.05)
    assert {name for effects in dealt for name in effects} >= {
        name
        for name, effect in SIMULATED_EFFECTS.items()
        if not effect.beside and name not in ONLY_BY_NAME
    }
    assert ONLY_BY_NAME.keys().isdisjoint(name for effects in dealt for name in effects)
    assert sum(SHARES.values()) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"effects": ("rust",)}, "there is no effect 'rust'; there are standard_linear_solid, "),
        ({"effects": ("mains_hum", "mains_hum")}, "can be hidden once only"),
        ({"excitation": "square"}, "there is no excitation 'square'; there are sine10, "),
        ({"rig": "bent"}, "there is no rig 'bent'; there are exact, tolerant"),
    ],
)
def test_unknown_names_are_told(arguments, said):
    with pytest.raises(ValueError, match=said):
        make_challenge(0, **arguments)
