"""Motions as they were measured: what is followed of a record, and what came before it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.challenge.case import Case
from tissue_probe.challenge.coil import Coil
from tissue_probe.challenge.instrument import InstrumentErrors
from tissue_probe.challenge.record import follow
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.trajectory import DURATIONS, Trajectory

FINE = 80_000
PHASES = tuple(np.random.default_rng(3).uniform(0.0, 6.28, 60).tolist())
FROM_REST = {"sine10": True, "sine10ss": False}  # of the others it is seen


def case(kind, preload=2e-3):
    coil = Trajectory(kind, 1e-3, DURATIONS[kind], phases=PHASES, coil=Coil(3e-3, 2e-3, 1e-6, 5))
    specimen = Specimen(stiffness=1500.0, damping=5.0)
    return Case(specimen, InstrumentErrors(encoder_step=1e-12), coil).press_in(preload)


def read(trajectory, rate=2_000, step=1e-7):
    """Return times and what an encoder reads of a motion's record."""
    u = trajectory.sample_motion(rate)[0][trajectory.before(rate) : -1]
    return np.arange(u.size) / rate, np.round(u / step) * step


def clean_force(case):
    return case.measure(np.zeros(case.samples))[1]


@pytest.mark.parametrize("preload", [0.0, 2e-3])
@pytest.mark.parametrize("kind", DURATIONS)
def test_a_named_motion_that_was_measured_gives_the_named_ones_force(kind, preload):
    named = case(kind, preload)
    motion = follow(*read(named.trajectory), kind, FROM_REST.get(kind))
    followed = Case(named.specimen, named.instrument, Trajectory.follow_motion(motion))
    force = clean_force(followed.press_in(motion.preload))
    off = force - clean_force(named)
    assert np.sqrt(np.mean(off[200:] ** 2)) < 5e-3 / 10.0
    # Before a steady sine other jitter came.
    assert np.abs(off).max() < (5e-3 if kind == "sine10ss" else 2e-3)


@pytest.mark.parametrize("kind", ["stepped30", "chirp60", "msine60"])
def test_what_begins_slowly_is_taken_to_begin_at_rest(kind):
    assert follow(*read(case(kind).trajectory), kind).at_rest


@pytest.mark.parametrize("kind", DURATIONS)
def test_what_was_cut_out_of_a_motion_is_not(kind):
    time, position = read(case(kind).trajectory)
    inside = slice(time.size // 3, None)
    assert not follow(time[inside], position[inside], kind).at_rest


@pytest.mark.parametrize("kind", DURATIONS)
def test_before_a_cut_the_coil_moves_smoothly_and_as_it_does_in_the_record(kind):
    time, position = read(case(kind).trajectory)
    inside = slice(time.size // 3, None)
    motion = Trajectory.follow_motion(follow(time[inside], position[inside], kind))
    u, rate = motion.sample_motion(FINE)
    slope = (u[2:] - u[:-2]) * FINE / 2.0
    assert np.abs(slope - rate[1:-1]).max() < 2e-5 * np.abs(rate).max()
    before = motion.before(FINE)
    acceleration = np.abs(np.diff(rate[before - FINE :]))
    assert acceleration[:FINE].max() < 1.5 * acceleration[FINE:].max()
    assert np.ptp(u[before - FINE : before]) > 0.5 * np.ptp(u[before:])
    assert u[0] == rate[0] == 0.0


def test_before_a_record_from_rest_the_coil_is_held_where_that_begins():
    time = np.arange(4000) / 2_000
    position = 1e-3 * (1.0 - np.cos(20.0 * time))
    motion = Trajectory.follow_motion(follow(time, position, "pressing", at_rest=True))
    u, rate = motion.sample_motion(FINE)
    before = motion.before(FINE)
    assert motion.preload == pytest.approx(1e-3, rel=0.05)
    assert u[before] == pytest.approx(0.0, abs=1e-8)
    assert np.abs(rate[before - 100 : before]).max() < 1e-12


def test_another_preload_moves_the_whole_motion():
    motion = Trajectory.follow_motion(follow(*read(case("chirp60").trajectory), "chirp60"))
    other = Case(Specimen(), InstrumentErrors(), motion).press_in(motion.preload + 1e-3).trajectory
    (u, _), (moved, _) = motion.sample_motion(2_000), other.sample_motion(2_000)
    np.testing.assert_allclose(moved[-8000:], u[-8000:] + 1e-3, atol=1e-12)


@settings(max_examples=25, deadline=None)
@given(
    rate=st.sampled_from([500, 1_000, 2_000, 3_333, 10_000]),
    frequency=st.floats(2.0, 60.0),
    noise=st.floats(0.0, 2e-6),
    seed=st.integers(0, 1000),
)
def test_noise_is_smoothed_and_the_motion_is_not(rate, frequency, noise, seed):
    random = np.random.default_rng(seed)
    time = np.arange(2 * rate) / rate
    true = 2e-3 + 1e-3 * np.sin(2.0 * np.pi * frequency * time + random.uniform(0.0, 6.28))
    read = true + noise * random.standard_normal(time.size)
    motion = follow(time, np.round(read / 1e-7) * 1e-7, "sine", at_rest=False)
    off = motion.preload + motion.amplitude * motion.course(time) - true
    left = np.hypot(noise, 1e-7 / np.sqrt(12.0))
    assert np.sqrt(np.mean(off**2)) < 0.95 * left + 1e-4 * 1e-3
    assert motion.highest == pytest.approx(frequency, abs=3.0, rel=0.1)
    assert motion.amplitude == pytest.approx(np.abs(true - true.mean()).max(), rel=0.01)


def test_any_sampling_rate_gives_the_same_motion():
    trajectory = case("chirp60").trajectory
    one, other = (follow(*read(trajectory, rate), "chirp60") for rate in (1_000, 10_000))
    time = np.arange(7_990) / 2_000
    u, v = (each.preload + each.amplitude * each.course(time) for each in (one, other))
    assert np.std(u - v) < 5e-8
    assert one.duration == pytest.approx(other.duration, abs=1.1e-3)


def test_a_few_missing_samples_are_bridged():
    time, position = read(case("chirp60").trajectory)
    whole = follow(time, position, "whole")
    position[[50, 400, 401, 402]] = np.nan
    kept = np.delete(np.arange(time.size), [900, 901])
    torn = follow(time[kept], position[kept], "torn")
    assert torn.duration == whole.duration
    at = np.arange(8_000) / 2_000
    off = torn.amplitude * torn.course(at) - whole.amplitude * whole.course(at)
    assert np.abs(off).max() < 1e-6


TIME = np.arange(4_000) / 2_000
SINE = 1e-3 * np.sin(62.8 * TIME)


@pytest.mark.parametrize(
    ("time", "position", "said"),
    [
        (TIME[:50], SINE[:50], "run: 50 positions are known; give 100 at least"),
        (TIME[:300], SINE[:300], "run lasts 0.15 s; give a record of 0.2 to 60 s"),
        (100.0 * TIME, SINE, "run lasts 200 s"),
        (TIME, np.full(4_000, np.nan), "run: 0 positions are known"),
        (
            TIME,
            np.where(np.abs(TIME - 1.0) < 0.1, np.nan, SINE),
            "known for 0.2.* s, 0.8995 s after",
        ),
        (TIME[::-1], SINE, "do not ascend"),
        (TIME, np.zeros(4_000), "moves by 0 um at most, which shows nothing"),
        (TIME, 1e3 * SINE, "by 1e.03 mm about .*: give u in metres"),
        (TIME, SINE + 0.05, "by 1.* mm about 50 mm; .* 10 mm deep"),
        (TIME, SINE - 2e-3, "2 mm above the tissue's surface"),
        (TIME, np.random.default_rng(0).normal(0.0, 1e-4, 4_000), "as fast as its samples"),
    ],
)
def test_what_cannot_be_followed_is_told_in_a_sentence(time, position, said):
    with pytest.raises(ValueError, match=said) as told:
        follow(time, position, "run")
    assert "\n" not in str(told.value)
