"""The Python interface: what a notebook calls, and how its results show themselves."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import polars as pl
import pytest

import tissue_probe as tp

PERIOD, COUNT = 5e-4, 4000
MASS, CELL_STIFFNESS, CELL_DAMPING, STIFFNESS, DAMPING = 0.04, 9700.0, 0.8, 450.0, 5.0


@pytest.fixture(scope="module")
def columns():
    """A sine of 10 Hz in Kelvin-Voigt tissue, by the impedances of the paper's eq. 1.

    The load cell shows the force in its spring.
    """
    time = np.arange(COUNT) * PERIOD
    w = 2j * np.pi * 10.0
    tissue = STIFFNESS + w * DAMPING + MASS * w**2
    cell = CELL_STIFFNESS + w * CELL_DAMPING
    force = np.imag(1e-3 * tissue * CELL_STIFFNESS / (tissue + cell) * np.exp(w * time))
    noise = 5e-3 * np.random.default_rng(3).standard_normal(COUNT)
    return {"t": time, "u": 1e-3 * np.sin(2 * np.pi * 10.0 * time), "F": force + noise}


@pytest.fixture(scope="module")
def measured(columns):
    return tp.read(columns, force_polarity="compression")


@pytest.fixture(scope="module")
def diagnosed(measured):
    return tp.diagnose(measured, rig="compliant_probe", starts="moving")


def lines(result):
    return repr(result).splitlines()


@pytest.mark.parametrize(
    "table",
    [dict, pd.DataFrame, pl.DataFrame, lambda c: pd.DataFrame(c).to_records(index=False)],
    ids=["arrays", "pandas", "polars", "structured array"],
)
def test_tables_in_memory_are_read_as_files_are(columns, table, tmp_path):
    path = tmp_path / "data.csv"
    pd.DataFrame(columns).to_csv(path, index=False)
    from_file = tp.read(path, force_polarity="compression")
    in_memory = tp.read(table(columns), force_polarity="compression")
    np.testing.assert_array_equal(in_memory.position, from_file.position)
    np.testing.assert_array_equal(in_memory.force, from_file.force)
    np.testing.assert_allclose(in_memory.time, from_file.time, atol=1e-12)


def test_reading_leaves_the_users_arrays_as_they_are(columns):
    before = {name: values.copy() for name, values in columns.items()}
    given = {"t_ms": 1e3 * columns["t"], "u_mm": columns["u"], "F": columns["F"]}
    tp.read(given, force_polarity="tension")
    for name, values in before.items():
        np.testing.assert_array_equal(columns[name], values)


def test_units_and_polarity_are_parameters(columns):
    given = {"t_ms": 1e3 * columns["t"], "u_mm": 1e3 * columns["u"], "F_mN": -1e3 * columns["F"]}
    read = tp.read(given, force_polarity="tension")
    np.testing.assert_allclose(read.position, columns["u"], rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(read.force, columns["F"], rtol=1e-12, atol=1e-18)


@pytest.mark.parametrize(
    ("given", "options", "sentence"),
    [
        ([1.0, 2.0], {}, "give the path of a file, a data frame, or arrays by name"),
        ({"t": np.zeros((2, 2)), "u": [1, 2], "F": [1, 2]}, {}, "one value a row"),
        (
            {"u": [1.0], "F": [1.0]},
            {"sample_rate": -1.0},
            "is -1.0; give a number above 0",
        ),
    ],
)
def test_errors_are_of_one_family_and_name_the_parameter(given, options, sentence):
    with pytest.raises(tp.TissueProbeError, match=sentence):
        tp.read(given, force_polarity="compression", **{"sample_rate": None, **options})


@pytest.mark.parametrize(
    "call", [tp.read, tp.preview, tp.compare, tp.diagnose, tp.estimate, tp.map, tp.load_model]
)
@pytest.mark.parametrize("name", ["none.csv", "none.mcap"])
def test_a_file_that_is_not_there_is_of_the_family_of_errors_and_of_pythons_own(call, name):
    with pytest.raises(tp.TissueProbeError, match=f"{name}: No such file") as raised:
        call(name)
    assert isinstance(raised.value, FileNotFoundError)


def test_a_choice_that_is_not_known_is_refused_with_the_known_ones(measured):
    with pytest.raises(tp.TissueProbeError, match="`rig` is 'stiff'; give one of compliant_probe"):
        tp.compare(measured, rig="stiff")
    with pytest.raises(tp.TissueProbeError, match="`starts` is 'rest'; give one of auto"):
        tp.compare(measured, rig="compliant_probe", starts="rest")
    with pytest.raises(tp.TissueProbeError, match=r"`constant` weight: .* give one of tip_mass"):
        tp.compare(measured, constants={"weight": 1.0})
    with pytest.raises(tp.TissueProbeError, match="`add` magic: no such effect"):
        tp.diagnose(measured, add=["magic"])


def test_a_comparison_has_values_with_intervals_and_shows_itself(measured):
    compared = tp.compare(measured, rig="compliant_probe", starts="moving")
    found = {row["name"]: row for row in compared.parameters.to_dict()}
    assert found["stiffness"]["low"] < STIFFNESS < found["stiffness"]["high"]
    assert found["damping"]["low"] < DAMPING < found["damping"]["high"]
    assert compared.rmse == pytest.approx(5e-3, rel=0.1)
    assert len(lines(compared)) <= 40
    assert "<table>" in compared._repr_html_()
    frame = compared.to_frame().set_index("name")
    assert frame.loc["stiffness", "value"] == found["stiffness"]["value"]
    assert compared.plot().axes


def test_a_diagnosis_shows_itself_as_text_table_frame_and_json(diagnosed):
    assert diagnosed.verdict == "adequate"
    assert diagnosed.effects == ()
    head, first, *_ = lines(diagnosed)
    assert head.startswith("Asked: rig compliant_probe, ")
    assert first.startswith("Adequate")
    assert len(lines(diagnosed)) <= 40
    assert "<table>" in diagnosed._repr_html_()
    told = diagnosed.to_dict()
    assert json.loads(json.dumps(told)) == told
    frame = diagnosed.ranking.to_frame()
    assert list(frame["effect"]) == [each["effect"] for each in told["ranking"]]
    assert len(diagnosed.ladder) == 1


def test_a_diagnosis_tells_what_is_under_way_and_can_be_ended(measured):
    class Enough(Exception):
        pass

    told = []

    def progress(doing):
        told.append(doing)
        if len(told) == 2:
            raise Enough

    with pytest.raises(Enough):
        tp.diagnose(measured, rig="compliant_probe", starts="moving", progress=progress)
    assert told[0] == "the model that is asked about is fitted"
    assert "effects is added to it" in told[1]


def test_a_model_is_kept_and_held_on_what_it_predicts(diagnosed, tmp_path):
    path = tmp_path / "model.yaml"
    diagnosed.model.save(path)
    drive = {"kind": "sine", "frequency": 5.0, "amplitude": 1e-3}
    again = tp.simulate(path, drive, duration=1.0, noise=5e-3, seed=4)
    compared = tp.compare(again, model=path, starts="at-rest")
    assert compared.rmse == pytest.approx(5e-3, rel=0.1)
    assert "values held, as in" in lines(compared)[0]


def test_report_and_pictures_are_written(diagnosed, tmp_path):
    diagnosed.save(tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"model.yaml", "story.png", "ladder.png", "compare.png", "report.html"}


def test_an_estimate_has_its_deviation_and_is_saved_as_the_command_line_does(measured, tmp_path):
    found = tp.estimate(measured, "robust_ekf")
    assert abs(found.stiffness - STIFFNESS) < 4.0 * found.stiffness_deviation
    assert abs(found.damping - DAMPING) < 4.0 * found.damping_deviation
    assert found.to_dict()["status"] == "converged"
    found.save(tmp_path / "estimates.csv")
    saved = pd.read_csv(tmp_path / "estimates.csv")
    np.testing.assert_allclose(saved["stiffness"], found.to_frame()["stiffness"])


def test_a_challenge_hides_what_it_says():
    made = tp.make_challenge(5, ["hertz_contact"])
    assert made.answer.effects == ("hertz_contact",)
    assert len(made.first) == len(made.second) > 0
    assert tp.make_challenge(5, ["hertz_contact"]).first.force == pytest.approx(made.first.force)


def test_a_first_look_ranks_what_is_hidden_first_and_fits_nothing():
    made = tp.make_challenge(7, ["cubic_stiffening"], excitation="chirp60")
    told = tp.promises(made.first, rig="compliant_probe", starts="at-rest")
    rows = told.ranking.to_dict()
    assert rows[0]["family"] == "stiffening"
    left = [row["promised_rmse"] for row in rows]
    assert left == sorted(left)
    assert left[0] < 0.6 * left[-1]
    assert "no effect was fitted" in repr(told)


def test_two_effects_with_the_same_unknowns_are_refused_in_a_sentence(measured):
    both = ["generalized_maxwell", "quasi_linear_relaxation"]
    with pytest.raises(tp.TissueProbeError, match="a form of the law of generalized_maxwell"):
        tp.diagnose(measured, rig="compliant_probe", add=both)


def test_effects_and_estimators_are_listed():
    assert {"hertz_contact", "mains_hum"} <= {each["name"] for each in tp.effects()}
    assert {"ekf", "robust_ekf"} <= {each["name"] for each in tp.estimators()}


def test_what_is_public_is_there_and_importing_it_costs_nothing():
    command = [sys.executable, "-c", "import sys, tissue_probe\nprint(*sys.modules)"]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)
    assert not {"numpy", "scipy", "numba", "pydantic", "matplotlib"} & set(ran.stdout.split())
    for name in tp.__all__:
        assert getattr(tp, name)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        tp.nothing  # noqa: B018
    assert Path(tp.__file__).name == "__init__.py"
