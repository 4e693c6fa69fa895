"""A record says the same whatever it is measured in: lengths, forces and times of any size.

Forces are closed forms of this file, or of ``specimen``'s own integration.
"""

import numpy as np
import pytest
from specimen import Specimen, multisine

import tissue_probe as tp
from tissue_probe.analysis.question import question
from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.noise import Noise
from tissue_probe.diagnosis.sizing import report_size, size_of
from tissue_probe.physics import library
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effect_scale import over, resize_effect
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.effects.effect import TIP_VELOCITY
from tissue_probe.physics.model_file import load
from tissue_probe.physics.scale import USUAL, Scale, UnitError

POWERS = [Scale(length=1e3), Scale(force=1e-3, time=1e3), Scale(1e-6, 1e-9, 1e-3)]
#: What may be missing, one of each kind whose law or search refers to a size.
MISSING = (
    "cubic_stiffening", "exponential_stiffening", "hertz_contact", "contact_loss",
    "coulomb_friction", "standard_linear_solid", "springpot", "channel_delay", "force_bias",
)  # fmt: skip
MASS, CELL = 0.02, {"tip_mass": "kg", "load_cell_stiffness": "N/m", "load_cell_damping": "N s/m"}
CUBIC = 2e8


def noise(share, force):
    return share * np.ptp(force) * np.random.default_rng(0).standard_normal(force.size)


def held_firmly():
    """Return times, positions and forces of a tip with a mass on tissue that stiffens."""
    time = np.arange(0.0, 4.0, 2e-3)
    rates = 2.0 * np.pi * np.array([0.5, 1.7, 3.1])
    angles = np.outer(time, rates)
    u = 1e-3 * np.sin(angles).sum(axis=1)
    speed = 1e-3 * (np.cos(angles) * rates).sum(axis=1)
    acceleration = -1e-3 * (np.sin(angles) * rates**2).sum(axis=1)
    force = 500.0 * u + 3.0 * speed + MASS * acceleration + CUBIC * u**3
    return time, u, force + noise(1e-3, force)


def on_a_load_cell():
    """Return the same of the paper's probe, whose load cell yields."""
    specimen = Specimen(cubic=2e9, noise=2e-3)
    position, _, _, force = specimen.measure(multisine(range(2, 40, 3)), duration=1.5)
    return specimen.sample_period * np.arange(position.size), position, force


def out_of_the_air():
    """Return the same of a tip that touches on its way, a ball on an elastic half space."""
    time = np.arange(0.0, 6.0, 1e-2)
    u = 4e-3 * (1.0 - np.abs((time % 3.0) / 1.5 - 1.0))
    depth = np.maximum(u - 1.1e-3, 0.0)
    force = 400.0 * 1e-3 * (depth / 1e-3) ** 1.5
    return time, u, force + noise(2e-3, force)


RECORDS = {
    "rigid_probe": (held_firmly, ("cubic_stiffening",)),
    "compliant_probe": (on_a_load_cell, ("cubic_stiffening",)),
    "touch": (out_of_the_air, ("hertz_contact",)),
}


def diagnosed(record, scale=USUAL):
    """Diagnose a record in other units; of its rig nothing is said but that it has no mass."""
    time, position, force = RECORDS[record][0]()
    measured = Measurement(
        position * scale.length, force * scale.force, (time[1] - time[0]) * scale.time
    )
    rig = "compliant_probe" if record == "compliant_probe" else "rigid_probe"
    asked = question(rig=rig, constants={"tip_mass": 0.0} if record == "touch" else {})
    library = {name: EFFECTS[name] for name in MISSING}
    return diagnose(asked.composition, [measured], asked.instrument, library)


@pytest.fixture(scope="module")
def usual():
    return {record: diagnosed(record) for record in RECORDS}


@pytest.mark.parametrize("record", RECORDS)
@pytest.mark.parametrize("scale", POWERS, ids=str)
def test_a_record_in_other_units_gives_the_same_verdict_ranking_and_values(record, scale, usual):
    expected, found = usual[record], diagnosed(record, scale)
    assert expected.effects == RECORDS[record][1]
    assert (found.verdict, found.effects) == (expected.verdict, expected.effects)
    fit, same = found.ladder.final, expected.ladder.final
    factors = np.array([scale.of(entry.unit) for entry in same.entries])
    known = np.sqrt(np.diag(same.covariance))
    assert np.all(np.abs(fit.values / factors - same.values) <= 0.05 * known + 1e-9 * same.values)
    deviations = np.sqrt(np.diag(fit.covariance)) / factors
    np.testing.assert_allclose(deviations, known, rtol=0.02)
    assert ranked(found) == ranked(expected)


def ranked(result):
    """Return the effects that take something off the residual, in their order."""
    ladder = result.ladder
    told = [fit for fit in ladder.ranking if fit.ratio < 0.98 * ladder.base.ratio]
    return [fit.composition.names[-1] for fit in told]


def relaxing(stiffness, depth, seed=0):
    """Return a ramp and hold, pressing that relaxes by as much as stays; forces with noise."""
    time = np.arange(0.0, 20.0, 0.02)
    pressed = np.minimum(time, 1.0)
    branch = 2.0 * (np.exp(-0.5 * (time - pressed)) - np.exp(-0.5 * time))
    force = stiffness * depth * (pressed + branch)
    random = np.random.default_rng(seed)
    return time, depth * pressed, force + 2e-3 * np.ptp(force) * random.standard_normal(time.size)


@pytest.mark.parametrize(
    ("stiffness", "depth"), [(0.06, 1e-6), (1e6, 5e-4)], ids=["cantilever", "wall"]
)
def test_a_cantilever_and_a_wall_relax_as_tissue_does(stiffness, depth, tmp_path):
    time, u, force = relaxing(stiffness, depth)
    recording = tp.read({"t_s": time, "u_m": u, "F_N": force}, force_polarity="compression")
    constants = {"tip_mass": 0.0}
    found = tp.diagnose(recording, rig="rigid_probe", constants=constants, starts="at-rest")
    assert (found.verdict, found.effects) == ("missing", ("standard_linear_solid",))
    values, deviations = found.model.values, found.model.deviations
    for name, truth in (
        ("stiffness", stiffness), ("relaxing_stiffness", stiffness), ("relaxation_rate", 0.5)
    ):  # fmt: skip
        assert abs(values[name] - truth) < 4.0 * deviations[name]
        assert deviations[name] < 0.05 * truth
    found.model.save(tmp_path / "model.yaml")
    again = load(tmp_path / "model.yaml")
    assert again.composition == found.model.composition
    compared = tp.compare(recording, model=again, starts="at-rest")
    # A comparison has the samples beside the corner, too.
    assert compared.rmse == pytest.approx(found.found.ladder.final.rmse, rel=1e-2)


@pytest.mark.parametrize("name", EFFECTS)
def test_a_law_turned_to_another_size_and_back_is_the_same_law(name):
    scale = Scale(1e-6, 1e-3, 1e3)
    for form in EFFECTS[name].every_form:
        turned = over(resize_effect(form, scale), scale)
        for one, other in zip(turned.parameters, form.parameters, strict=True):
            bounds = [(each.default, each.lower, each.upper) for each in (one, other)]
            np.testing.assert_allclose(*bounds, rtol=1e-12)
        at = {entry.symbol: 1.3 * entry.default or 0.7 for entry in form.parameters}
        for part in ("force", "drag", "contact", "output"):
            one, other = (getattr(each, part) for each in (turned, form))
            symbols = sorted((one - other).free_symbols - at.keys(), key=str)
            point = at | {symbol: 1e-3 * (k + 1) for k, symbol in enumerate(symbols)}
            assert float((one - other).subs(point)) == pytest.approx(0.0, abs=1e-9)


def test_a_law_of_ones_own_stays_as_it_was_written(tmp_path):
    path = tmp_path / "law.py"
    path.write_text(
        "from tissue_probe.physics.effects.effect import INDENTATION, Effect, Parameter\n"
        "import sympy as sp\n"
        "HARD = sp.Symbol('hardening', real=True)\n"
        "LAW = Effect(name='own_law', family='stiffening', physics='k4 x^2 |x|',\n"
        "    parameters=(Parameter(HARD, 'N/m^3', default=1e13, lower=0.0, upper=1e16),),\n"
        "    force=HARD * INDENTATION**2 * sp.Abs(INDENTATION))\n"
    )
    time = np.arange(0.0, 4.0, 2e-3)
    u = 1e-6 * np.sin(2.0 * np.pi * time) * np.sin(0.7 * time)
    force = 0.06 * u + 1e11 * np.abs(u) ** 3
    force += noise(1e-3, force)
    recording = tp.read({"t_s": time, "u_m": u, "F_N": force}, force_polarity="compression")
    own = library.effects([path])["own_law"]
    constants = {"tip_mass": 0.0}
    base = tp.compare(recording, rig="rigid_probe", constants=constants, effects=[path])
    compared = base.plus("own_law")
    assert compared.model.composition.effects[-1].parameters == own.parameters
    assert compared.fit.ratio == pytest.approx(1.0, abs=0.05)
    assert compared.model.values["hardening"] == pytest.approx(1e11, rel=0.05)


@pytest.mark.parametrize(
    ("unit", "factor"),
    [("N s/m", 7.5), ("kg", 37.5), ("N/m^3", 0.375), ("N/m s^a", 1.5), ("1/s", 0.2), ("1", 1.0)],
)
def test_a_unit_tells_how_many_times_larger_a_number_is(unit, factor):
    assert Scale(length=2.0, force=3.0, time=5.0).of(unit) == pytest.approx(factor)


def test_a_unit_of_something_else_is_refused():
    with pytest.raises(UnitError, match="furlong"):
        USUAL.of("N/furlong")


def test_models_of_two_sizes_share_their_machine_code():
    usual, small = Composition("rigid_probe"), Composition("rigid_probe", scale=Scale(1e-3, 1e-6))
    for name in ("hertz_contact", "springpot"):
        usual, small = (
            usual.plus(EFFECTS[name]),
            small.plus(resize_effect(EFFECTS[name], small.scale)),
        )
    assert small.kernel.code == usual.kernel.code


@pytest.mark.parametrize("hold", ["first row alone", "a few rows", "a glitch"])
def test_a_record_that_holds_still_is_as_large_as_what_comes_before(hold):
    random = np.random.default_rng(0)
    force = 0.2 + 1e-9 * random.standard_normal(4000)
    force[: 1 if hold == "first row alone" else 12] = 0.0
    if hold == "a glitch":
        force[2000:2003] = 1e6
    position = 1e-3 * (1.0 - np.exp(-np.arange(4000) / 800.0))
    record = Measurement(position, force, 2e-3, noise=Noise(1e-6))
    assert size_of([record]).is_usual


def test_a_quick_ramp_and_a_long_hold_are_as_large_as_the_ramp():
    """Five samples of a ramp, 1500 of a hold with an error of a 2000th of the travel."""
    random, time = np.random.default_rng(2), 0.02 * np.arange(1500)
    travel = 4e-3 * np.clip(time / 0.1, 0.0, 1.0) + 2e-6 * random.standard_normal(time.size)
    force = 0.3 * np.exp(-0.5 * time) * (time > 0.09) + 250.0 * travel
    measured = Measurement(travel, force, 0.02)
    assert size_of([measured]).length == 1.0


def test_a_speed_that_a_law_refers_to_is_told_in_the_records_size():
    scale = Scale(length=1e-3)
    (finding,) = report_size(scale)
    assert "10 mm/s (`damping_at_10_mm_s`) to 1e-05 m/s" in finding.sentence
    law = resize_effect(EFFECTS["nonlinear_damping"].forms[0], scale)
    damping, exponent = (each.symbol for each in law.parameters)
    force = law.force.subs({TIP_VELOCITY: 1e-5, damping: 4.0, exponent: 0.5})
    assert float(force) == pytest.approx(4.0 * 1e-5, rel=1e-3)
