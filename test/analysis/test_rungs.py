"""What can be done with a comparison: the next rung, other values, looks at its error."""

import os

import numpy as np
import pytest

import tissue_probe as tp
from tissue_probe.analysis.passing import from_bytes, to_bytes

EFFECT = "hertz_contact"
OWN = """
import sympy as sp
from tissue_probe.physics.effects.effect import ELASTIC_DEPTH, Effect, Parameter
GAIN = Parameter(sp.Symbol("third_gain", real=True), "N/m^3", 1e7, -1e12, 1e12)
THIRD = Effect("third", "stiffening", "a cubic of one's own", (GAIN,),
               force=GAIN.symbol * ELASTIC_DEPTH**3)
"""


@pytest.fixture(scope="module")
def challenge():
    return tp.make_challenge(25, [EFFECT], "sine10", "tolerant")


@pytest.fixture(scope="module")
def compared(challenge):
    return tp.compare(challenge.first, rig="compliant_probe", starts="at-rest")


@pytest.fixture(scope="module")
def next_rung(compared):
    return compared.plus(EFFECT)


def test_the_next_rung_is_that_of_improve(challenge, next_rung):
    improved = tp.improve(challenge.first, add=[EFFECT], rig="compliant_probe", starts="at-rest")
    assert next_rung.rmse == pytest.approx(improved.found.ladder.final.rmse, rel=1e-3)
    assert next_rung.fit.composition.names == (EFFECT,)


def test_a_rung_that_a_ranking_knows_is_found_from_there(challenge, compared, next_rung):
    ranked = tp.diagnose(challenge.first, rig="compliant_probe", starts="at-rest")
    again = compared.plus(EFFECT, ranked.beside(EFFECT))
    assert again.rmse == pytest.approx(next_rung.rmse, rel=1e-3)
    assert again.parameters.to_dict()[0]["value"] == pytest.approx(
        next_rung.parameters.to_dict()[0]["value"], rel=1e-2
    )
    with pytest.raises(tp.TissueProbeError, match="does not have it"):
        ranked.beside("nothing")


def test_an_effect_that_is_there_or_unknown_is_refused(next_rung):
    with pytest.raises(tp.TissueProbeError, match="has it already"):
        next_rung.plus(EFFECT)
    with pytest.raises(tp.TissueProbeError, match="no such effect"):
        next_rung.plus("nothing")


def test_the_prediction_at_the_values_found_is_that_of_the_fit(next_rung):
    np.testing.assert_allclose(next_rung.predict({}, 0), next_rung.fit.predicted[0], atol=1e-9)


def test_the_prediction_follows_a_value_as_a_simulation_does(compared):
    """By the impedance of Kelvin-Voigt tissue a tenth more stiffness is about that much more force.

    Of a slow motion, about its end, where the start is forgotten.
    """
    values = compared.fit.named()
    stiffer = compared.predict({"stiffness": 1.1 * values["stiffness"]}, 0)
    w = 2j * np.pi * 10.0
    tip = values["tip_mass"] * w**2
    cell = values["load_cell_stiffness"] + w * values["load_cell_damping"]

    def size(stiffness):
        tissue = stiffness + w * values["damping"] + tip
        return abs(tissue * cell / (tissue + cell))

    late = slice(stiffer.size // 2, None)
    grown = np.std(stiffer[late]) / np.std(compared.fit.predicted[0][late])
    expected = size(1.1 * values["stiffness"]) / size(values["stiffness"])
    assert grown == pytest.approx(expected, rel=0.02)


def test_values_out_of_bounds_or_unknown_are_refused(compared):
    with pytest.raises(tp.TissueProbeError, match="`values` stiffness=-5: it lies from 0"):
        compared.predict({"stiffness": -5.0})
    with pytest.raises(tp.TissueProbeError, match="no such value"):
        compared.predict({"softness": 1.0})


def test_a_look_along_an_axis_means_the_samples_there(compared):
    view = compared.view()
    assert view.between("time", 0.5, 1.0).sum() == pytest.approx(0.5 / view.sample_period, abs=1)
    deep = view.between("indentation", 5e-4, 1.0)
    assert (view.indentation[deep] >= 5e-4).all()
    assert (view.indentation[~deep] < 5e-4).all()
    through = view.between("phase", 90.0, -90.0)
    assert (np.abs(view.phase[through]) >= 90.0).all()


def test_of_a_band_those_samples_are_meant_that_hold_half_of_its_energy(compared):
    view = compared.view()
    chosen = view.between("frequency", 15.0, 40.0)
    assert 0 < chosen.sum() < chosen.size / 2 + 1
    with pytest.raises(tp.TissueProbeError, match="`axis`"):
        view.along("colour")


def test_the_spectrum_of_all_samples_holds_the_error(compared):
    view = compared.view()
    frequencies, density = view.spectrum()
    power = np.sum(density) * (frequencies[1] - frequencies[0])
    assert power == pytest.approx(np.var(view.residual), rel=0.25)


def test_each_effect_is_told_as_soon_as_it_is_fitted(challenge):
    read, write = os.pipe()
    diagnosis = tp.diagnose(
        challenge.first,
        rig="compliant_probe",
        starts="at-rest",
        found=lambda effect, fit: os.write(write, f"{effect} {fit.rmse}\n".encode()),
    )
    os.close(write)
    with open(read) as pipe:
        told = [line.split() for line in pipe]
    best: dict[str, float] = {}
    for effect, rmse in told:
        best[effect] = min(float(rmse), best.get(effect, np.inf))
    rows = {row["effect"]: row["rmse"] for row in diagnosis.ranking}
    assert set(rows) <= set(best)
    # Some are found better later on, none worse.
    assert best[EFFECT] >= 0.999 * rows[EFFECT]


def test_a_result_that_was_passed_on_is_the_same(next_rung):
    passed = from_bytes(to_bytes(next_rung))
    assert passed.text == next_rung.text
    np.testing.assert_array_equal(passed.predict({}), next_rung.predict({}))
    assert passed.plus("force_bias").fit.composition.names == (EFFECT, "force_bias")


def test_effects_of_ones_own_are_passed_on_with_their_file_and_without(challenge, tmp_path):
    file = tmp_path / "own.py"
    file.write_text(OWN)
    rung = tp.compare(
        challenge.first, rig="compliant_probe", effects=[file], starts="at-rest"
    ).plus("third")
    for named in ([file], []):
        passed = from_bytes(to_bytes(rung), named)
        assert passed.fit.composition.names == ("third",)
        np.testing.assert_array_equal(passed.predict({}), rung.predict({}))


def test_an_effect_with_a_local_function_is_passed_on_to_who_names_its_file(challenge, tmp_path):
    file = tmp_path / "own.py"
    file.write_text(OWN.replace("force=", "starts=lambda extent: [{}], force="))
    rung = tp.compare(
        challenge.first, rig="compliant_probe", effects=[file], starts="at-rest"
    ).plus("third")
    assert from_bytes(to_bytes(rung), [file]).fit.composition.names == ("third",)
    with pytest.raises(KeyError, match="third"):
        from_bytes(to_bytes(rung))


def test_a_preview_shows_names_units_and_values(tmp_path):
    path = tmp_path / "machine.csv"
    rows = [f"{n / 100:.2f};{n / 50:.2f};{n * n:.1f};note" for n in range(500)]
    path.write_text("\n".join(["Zeit [s];Weg [mm];Last [mN];Text", *rows]) + "\n")
    shown = tp.preview(path)
    assert shown.kind == "table"
    assert [(each.name, each.unit) for each in shown.columns[:3]] == [
        ("Zeit [s]", "s"), ("Weg [mm]", "mm"), ("Last [mN]", "mN"),
    ]  # fmt: skip
    force = shown.columns[2]
    assert (force.count, force.first[:3]) == (500, ("0.0", "1.0", "4.0"))
    assert min(force.sketch) == 0.0
    assert max(force.sketch) == 499.0**2
    assert shown.columns[3].count == 0
