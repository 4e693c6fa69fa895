"""Each revision of the samples, after which the search began anew, is told by its name."""

from dataclasses import replace

import numpy as np
import pytest
from hidden import EXACT, TOLERANT, challenge, library, measurement

from tissue_probe.diagnosis.answer import answer
from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.fitting.measurement import Measurement
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
