"""Each revision of the samples is told by its name, and the search begins anew once for several."""

from dataclasses import replace

import numpy as np
import pytest
from hidden import EXACT, TOLERANT, challenge, library, measurement

from tissue_probe.diagnosis.answer import answer
from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition

FEW = library("cubic_stiffening", "coulomb_friction")


def diagnosed(measured, instrument=EXACT, rig="compliant_probe"):
    found = diagnose(Composition(rig), [measured], instrument, FEW)
    assert answer(found).revisions == list(found.revisions)
    return found


def test_a_search_that_was_begun_once_has_no_revision():
    made = challenge(21, "cubic_stiffening", preload=2e-3)
    found = diagnosed(measurement(made.recording))
    assert found.verdict == "missing"
    assert found.revisions == ()


def test_samples_left_out_as_outliers_are_a_revision_of_the_ladder():
    made = challenge(21, "cubic_stiffening", preload=2e-3)
    force = made.recording.force.copy()
    for first, length in ((900, 3), (2500, 5), (4100, 8)):
        force[first : first + length] += 0.05
    found = diagnosed(measurement(replace(made.recording, force=force)))
    assert found.revisions == ("outliers",)


@pytest.mark.parametrize(("noise", "revisions"), [(2e-5, ("flicker",)), (2e-3, ())])
def test_flicker_noise_that_is_not_there_is_a_revision_of_the_diagnosis(noise, revisions):
    period, random = 5e-3, np.random.default_rng(0)
    time = period * np.arange(4000)
    depth = 1e-3 * (1.0 - np.cos(2.0 * np.pi * time)) * (1.0 + 0.3 * np.sin(0.7 * time))
    force = 400.0 * depth + 3.0 * np.gradient(depth, period, edge_order=2)
    measured = Measurement(depth, force + noise * random.standard_normal(time.size), period)
    found = diagnosed(measured, TOLERANT, rig="rigid_probe")
    assert found.revisions == revisions


def test_the_search_begins_anew_once_for_all_that_its_best_model_asks_for():
    """Outliers hide behind noise that friction's jumps were taken for: both are revised."""
    period, random = 0.02, np.random.default_rng(3)
    time, rate = period * np.arange(800), 2.0 * np.pi * 2.33
    depth, speed = 1e-3 * np.sin(rate * time), 1e-3 * rate * np.cos(rate * time)
    force = 700.0 * depth + 3.0 * speed + 0.06 * np.sign(speed)
    force += 1.5e-3 * random.standard_normal(time.size)
    force[[203, 204, 511, 512]] += 0.03
    said = []
    asked = (Composition("rigid_probe"), [Measurement(depth, force, period)], EXACT, FEW)
    found = diagnose(*asked, progress=said.append)
    assert found.effects == ("coulomb_friction",)
    assert found.revisions == ("quieter", "outliers", "quieter")
    assert sum("effects is added" in each for each in said) == 2
