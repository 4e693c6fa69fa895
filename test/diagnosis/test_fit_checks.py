"""What a fit tells of the measurements' worth: a tip that touches nothing, or a stop; units."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hidden import challenge, measurement
from shaken import PERIOD, TIMES, push, shaken
from shaken import Specimen as Shaken
from specimen import Specimen, chirp, sine

from tissue_probe.diagnosis.fit_checks import check_fit
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidates import fit_base
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.rigs import FORCE_DRIVEN, RIGID_PROBE
from tissue_probe.quantities import POSITION

NOTHING = Specimen(stiffness=0.0, damping=0.0)
SOFT = Specimen(stiffness=100.0, damping=1.0)
STIFF_CELL = Instrument(RIGID_PROBE)


def fitted(specimen, motion=None, metre=1.0, newton=1.0, instrument=None):
    """Fit what a specimen gives, its position and force in units of so many metres and newtons."""
    position, _, _, force = specimen.measure(motion or sine())
    seen = Measurement(position / metre, force / newton, 5e-4, at_rest=True)
    instrument = instrument or Instrument()
    return fit_base(Composition(instrument.rig), [seen], instrument)


def names(fit, final=None):
    return [finding.name for finding in check_fit(fit, final or fit)]


@pytest.mark.parametrize("motion", [sine(), chirp(duration=2.0)], ids=["sine", "chirp"])
@pytest.mark.parametrize("instrument", [Instrument(), Instrument().exact()])
def test_a_tip_in_free_air_is_told(motion, instrument):
    (finding,) = check_fit(*2 * (fitted(NOTHING, motion, instrument=instrument),))
    assert finding.name == "no_contact"
    assert not finding.fatal
    assert finding.sentence.startswith("No contact: the tip seems to touch nothing, stiffness ")


@pytest.mark.parametrize("motion", [sine(), sine(60.0), chirp(duration=2.0)])
def test_a_soft_tissue_is_touched(motion):
    assert names(fitted(SOFT, motion)) == []


@pytest.mark.parametrize("motion", [sine(), chirp(duration=2.0)], ids=["sine", "chirp"])
def test_a_mass_that_is_not_known_does_not_hide_the_contact(motion):
    assert names(fitted(Specimen(), motion, instrument=STIFF_CELL)) == []


def test_what_is_known_of_the_tissue_is_no_lack_of_contact():
    known = Instrument(constants=Instrument().constants | {"stiffness": (0.0, 0.0)})
    assert names(fitted(NOTHING, instrument=known)) == []


@pytest.mark.parametrize(
    "units",
    [{"metre": 1e-2}, {"metre": 1e-3}, {"newton": 1e3}, {"newton": 9.80665}, {"newton": 1e-3}],
    ids=["cm", "mm", "kN", "kgf", "mN"],
)
def test_units_that_no_model_follows_are_told(units):
    fit = fitted(Specimen(), chirp(duration=2.0), **units)
    (finding,) = check_fit(fit, fit)
    assert finding.name == "not_followed"
    for word in ("`position_unit`", "`force_unit`", "polarity", "in time"):
        assert word in finding.sentence


@pytest.mark.parametrize(
    "specimen",
    [Specimen(coulomb=0.3), Specimen(cubic=3e8), Specimen(contact_loss=True)],
    ids=["friction", "stiffening", "contact lost"],
)
@pytest.mark.parametrize("motion", [sine(), chirp(duration=2.0)], ids=["sine", "chirp"])
def test_an_effect_that_is_missing_is_no_wrong_unit(specimen, motion):
    fit = fitted(specimen, motion)
    assert fit.ratio > 5.0
    assert names(fit) == []


@pytest.mark.parametrize("motion", [sine(), chirp(duration=2.0)], ids=["sine", "chirp"])
@pytest.mark.parametrize("instrument", [Instrument(), Instrument().exact()])
def test_a_rigid_stop_under_the_probe_is_no_tissue(motion, instrument):
    fit = fitted(Specimen(stiffness=1e6, damping=10.0), motion, instrument=instrument)
    (finding,) = check_fit(fit, fit)
    assert finding.name == "no_tissue"
    assert "the tip hardly moves" in finding.sentence
    for word in ("rigid stop", "`force_unit`", "load_cell_stiffness", "`rig` rigid_probe"):
        assert word in finding.sentence


def test_a_force_in_millinewtons_is_no_tissue_of_a_rigid_probe():
    fit = fitted(Specimen(), chirp(duration=2.0), newton=1e-3, instrument=STIFF_CELL)
    (finding,) = check_fit(fit, fit)
    assert finding.name == "no_tissue"
    for word in ("N/m is suspicious", "`force_unit`", "`force_polarity`", "rigid stop"):
        assert word in finding.sentence


def test_a_stiff_tissue_is_one():
    assert names(fitted(Specimen(stiffness=5000.0, damping=30.0))) == []


def test_a_stiffness_that_is_known_may_be_any():
    known = Instrument(RIGID_PROBE, RIGID_PROBE.known | {"stiffness": (8e5, 0.0)})
    fit = fitted(Specimen(), chirp(duration=2.0), newton=1e-3, instrument=known)
    assert "no_tissue" not in names(fit)


def test_a_stiffness_is_suspicious_only_if_an_effect_leaves_it_so():
    stiff = fitted(Specimen(stiffness=1e6, damping=10.0))
    assert names(stiff, fitted(Specimen())) == []


def test_what_an_effect_explains_is_no_wrong_unit():
    right = fitted(Specimen())
    wrong = fitted(Specimen(), chirp(duration=2.0), newton=9.80665)
    assert names(wrong, right) == []


def test_a_position_that_a_force_drives_may_wander():
    instrument = Instrument(FORCE_DRIVEN)
    seen = Measurement(shaken(Shaken()), push(TIMES), PERIOD, at_rest=True, output=POSITION)
    fit = fit_base(Composition("force_driven"), [seen], instrument)
    assert names(fit) == []
    assert names(replace(fit, residuals=(seen.position + 0.1 * TIMES**2,))) == []


def test_a_force_that_no_spring_of_the_load_cell_lets_through_has_other_units():
    """Millinewtons taken for newtons: no tissue is felt as stiffer than the spring before it."""
    made = challenge(706001, rig="tolerant").recording
    seen = measurement(replace(made, force=1e3 * made.force))
    fit = fit_base(Composition(), [seen], Instrument())
    (finding,) = check_fit(fit, fit)
    assert finding.name == "suspicious_units"
    assert "`force_unit`" in finding.sentence
    assert "suspicious_units" not in names(fitted(SOFT))
    assert "suspicious_units" not in names(fitted(NOTHING, sine(60.0)))
