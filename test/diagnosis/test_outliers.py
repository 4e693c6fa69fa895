"""Disturbances of a few samples, which no model follows."""

from dataclasses import replace

import numpy as np
import pytest
from hidden import EXACT, challenge, first_of, library, measurement
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.fitting.outliers import outliers, without_outliers
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.noise import Noise
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS


def disturbed(force, *, at, rows, height):
    """Rows of samples thrown off, each at once and as far."""
    thrown = force.copy()
    for first, length in zip(at, rows, strict=True):
        thrown[first : first + length] += height
    return thrown


@pytest.mark.parametrize("height", first_of([0.05, -0.3, 2.0], 1))
@pytest.mark.parametrize("name", ["hunt_crossley", "force_lag", "stiffness_step"])
def test_rows_of_disturbed_samples_hide_no_effect(name, height):
    made = challenge(700100, name, excitation="chirp60")
    at, rows = (900, 2500, 4100, 5200, 6600), (1, 2, 3, 5, 8)
    force = disturbed(made.recording.force, at=at, rows=rows, height=height)
    spoilt = replace(made, recording=replace(made.recording, force=force))
    effects = library(name, "cubic_stiffening", "force_bias", "standard_linear_solid")
    found = diagnose(Composition(), [measurement(spoilt.recording)], EXACT, effects)
    assert (found.verdict, found.effects) == ("missing", (name,))
    told = {finding.name for finding in found.findings}
    assert told
    assert told <= {"spikes", "outliers"}
    marked = np.zeros(force.size, dtype=bool)
    for finding in found.findings:
        for first, stop in finding.spans:
            marked[first:stop] = True
    off = np.abs(force - made.recording.force) > 0.0
    assert np.count_nonzero(marked & ~off) <= 16
    assert np.count_nonzero(off & ~marked) <= 2
    assert found.ladder.base.samples == force.size - np.count_nonzero(marked)


def test_disturbances_of_the_validating_recording_are_left_out_too():
    made = challenge(700100, "hunt_crossley", excitation="chirp60")
    force = disturbed(made.second.force, at=(900, 3100), rows=(3, 1), height=0.1)
    other = measurement(replace(made.second, force=force))
    effects = library("hunt_crossley", "force_bias")
    found = diagnose(Composition(), [measurement(made.recording)], EXACT, effects, [other])
    assert found.carries_over
    assert found.heldout(found.ladder.final) < 1.05 * other.noise.own


@given(
    at=st.lists(st.integers(100, 1900), max_size=4),
    length=st.integers(1, 8),
    height=st.floats(12.0, 60.0),
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=40, deadline=None)
def test_what_stands_alone_in_white_noise_is_all_that_is_left_out(at, length, height, seed):
    noise = np.clip(np.random.default_rng(seed).standard_normal(2000), -2.0, 2.0)
    at = [first for first in at if all(abs(first - b) > 60 or first == b for b in at)]
    thrown = disturbed(noise, at=sorted(set(at)), rows=[length] * len(set(at)), height=height)
    seen = Measurement(np.zeros(2000), thrown, 5e-4, noise=Noise(1.0))
    left = outliers(thrown, seen)
    near = {first + i for first in at for i in range(-3, length + 3)}
    assert set(np.flatnonzero(left)) <= near  # noise may be as far off there
    assert np.count_nonzero(left) >= 0.9 * length * len(set(at))


@pytest.mark.parametrize("excitation", first_of(["chirp60", "sine10", "msine60", "stepped30"], 1))
@pytest.mark.parametrize("name", ["backlash", "stribeck_friction", "contact_loss", "adhesion"])
def test_what_a_model_lacks_is_no_outlier_however_sharp(name, excitation):
    made = challenge(700200, name, excitation=excitation)
    base = fit_base(Composition(), [measurement(made.recording)], EXACT)
    others = fit_candidates(base, library("coulomb_friction", "cubic_stiffening").values(), EXACT)
    for fit in (base, *others, *fit_candidates(base, [EFFECTS[name]], EXACT)):
        assert without_outliers(fit) is None


def test_outliers_beside_samples_that_are_left_out_already_are_found():
    random = np.random.default_rng(5)
    residual = 1e-3 * random.standard_normal(2000)
    residual[[700, 702, 1200, 1213]] += 0.5
    used = np.ones(2000, dtype=bool)
    used[[702, 1213]] = False
    measured = Measurement(np.zeros(2000), residual, 1e-3, noise=Noise(1e-3), used=used)
    assert np.flatnonzero(outliers(residual, measured)).tolist() == [700, 1200]
