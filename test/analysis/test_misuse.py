"""A misuse of the Python interface is refused in a sentence of the one family of errors."""

import datetime
import inspect
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
import polars as pl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import tissue_probe as tp

TIME = np.arange(400) / 1000.0
DEPTH = 1e-3 * (1.0 + np.sin(20 * np.pi * TIME))
FORCE = 450.0 * DEPTH + 3.0 * np.gradient(DEPTH, TIME)
FORCE = FORCE + np.random.default_rng(0).normal(0.0, 2e-3, TIME.size)
TABLE = {"t": TIME, "u": DEPTH, "F": FORCE}
STATED = {"rig": "rigid_probe", "constants": {"tip_mass": 0.0}}
READ = {"force_polarity": "compression"}

X, Y = (each.ravel() for each in np.meshgrid(np.arange(4) / 100.0, np.arange(4) / 100.0))
SITES = {"x": X, "y": Y, "k": 450.0 + X, "k_sd": np.full(X.size, 5.0)}
CORNERS = {"x": [0.0, 0.03, 0.03, 0.0], "y": [0.0, 0.0, 0.03, 0.03]}
SINE = {"kind": "sine", "frequency": 10.0, "amplitude": 1e-3}

MEASURED = tp.read(TABLE, **READ)
COMPARED = tp.compare(MEASURED, **STATED)
FELT = tp.identify_contact(MEASURED, delay=0.0, constants={"tip_mass": 0.0})

#: A right call of every public function, as quick as one is.
RIGHT = {
    "Measurements": {"parts": MEASURED.parts},
    "compare": {"measured": MEASURED, **STATED},
    "diagnose": {"measured": MEASURED, **STATED},
    "design_admittance": {"contacts": FELT, "mass": 2.0, "stiffness": 50.0, "delay": 0.01},
    "effects": {"files": ()},
    "estimate": {"measured": MEASURED},
    "estimators": {},
    "identify_contact": {"measured": "none.csv"},
    "identify_sensor": {"source": "none.csv"},
    "improve": {"measured": MEASURED, **STATED},
    "load_model": {"path": "none.yaml"},
    "make_challenge": {"seed": 1, "excitation": "sine10"},
    "map": {"measured": SITES, "within": CORNERS},
    "modulus": {"model": COMPARED.model, "indenter": "flat", "radius": 1e-3},
    "mujoco_contact": {"contact": FELT, "model": "none.xml", "tip": "tip", "tissue": "tissue"},
    "mujoco_joint": {"model": COMPARED.model, "class_name": "axis"},
    "preview": {"path": "none.csv"},
    "promises": {"measured": MEASURED, **STATED},
    "read": READ,
    "row": {"path": "none.csv", "task": "compare"},
    "simulate": {"model": COMPARED.model, "excitation": SINE, "duration": 0.1},
    "study": {"plan": "none.yaml"},
}
#: Those that take a search, so that no call of them is let through.
SLOW = ("diagnose", "improve", "promises", "make_challenge")

#: What no parameter of any function takes.
NEVER = {
    "an object": object(),
    "a set": {"rigid_probe"},
    "a class": int,
    "bytes": b"rigid_probe",
    "a complex number": 1j,
    "not a number": float("nan"),
    "not a number of NumPy": np.float64("nan"),
    "a missing value": pd.NA,
    "a missing time": pd.NaT,
    "a matrix": np.zeros((3, 3)),
    "a list of nothing": [None],
    "names that are numbers": {1: 2},
}
#: What may be right for one parameter, and is wrong for most.
MAYBE = st.one_of(
    st.sampled_from(
        [*NEVER.values(), 10**400, "", "a\0b", "\ud800", "Tensoin", "x" * 5000, Path("none")]
    ),
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    st.lists(st.one_of(st.floats(), st.text(max_size=3)), max_size=4),
    st.dictionaries(st.text(max_size=4), st.one_of(st.floats(), st.text(max_size=3)), max_size=2),
    st.datetimes(),
    st.decimals(),
)


def called(name, **changes):
    if name == "read":
        return tp.read(changes.pop("sources", TABLE), **{**READ, **changes})
    return getattr(tp, name)(**{**RIGHT[name], **changes})


def public_parameters(names):
    return [
        (name, parameter)
        for name in sorted(names)
        for parameter in inspect.signature(getattr(tp, name)).parameters
    ]


def methods():
    """Methods of results with their parameters, and what is right for the others."""
    view = COMPARED.view()
    estimated, mapped = tp.estimate(MEASURED), tp.map(SITES)
    yield from (
        (COMPARED.plus, "effect", {}),
        (COMPARED.predict, "values", {}),
        (COMPARED.predict, "index", {"values": {}}),
        (COMPARED.view, "index", {}),
        (view.along, "axis", {}),
        (view.spectrum, "samples", {}),
        (view.between, "axis", {"low": 0.0, "high": 1.0}),
        (view.between, "low", {"axis": "time", "high": 1.0}),
        (view.between, "high", {"axis": "frequency", "low": 1.0}),
        (COMPARED.model.save, "path", {}),
        (FELT.save, "path", {}),
        (tp.design_admittance(FELT, mass=2.0, stiffness=50.0, delay=0.01).save, "path", {}),
        (estimated.save, "path", {}),
        (mapped.report, "path", {}),
        (mapped.save_csv, "path", {}),
        (mapped.save_ply, "path", {}),
    )


def test_every_public_function_is_tried():
    functions = {name for name in tp.__all__ if callable(getattr(tp, name))} - {"TissueProbeError"}
    assert functions == RIGHT.keys()


@pytest.mark.parametrize(("name", "parameter"), public_parameters(RIGHT))
def test_what_no_parameter_takes_is_refused(name, parameter):
    for wrong in NEVER.values():
        with pytest.raises(tp.TissueProbeError, match=r"\w"):
            called(name, **{parameter: wrong})


def test_what_no_method_takes_is_refused():
    for method, parameter, others in methods():
        for wrong in NEVER.values():
            with pytest.raises(tp.TissueProbeError, match=r"\w"):
                method(**{parameter: wrong, **others})


@given(st.sampled_from(public_parameters(RIGHT.keys() - set(SLOW))), MAYBE)
@settings(max_examples=250, deadline=None)
def test_any_value_is_taken_or_refused(place, given):
    name, parameter = place
    with suppress(tp.TissueProbeError):
        str(called(name, **{parameter: given}))


NUMBERS = arrays.arrays(np.float64, 12, elements=st.floats(width=64))
PARTS = st.sampled_from([slice(0, 12), slice(200, 212), slice(388, 400), slice(0, 400, 40)])


@given(column=st.sampled_from(["t", "u", "F"]), place=PARTS, values=NUMBERS)
@settings(max_examples=60, deadline=None)
def test_any_numbers_in_a_column_are_fitted_or_refused(column, place, values):
    spoilt = TABLE[column].copy()
    spoilt[place] = values[: spoilt[place].size]
    with suppress(tp.TissueProbeError):
        str(tp.compare(tp.read(TABLE | {column: spoilt}, **READ), **STATED))


@given(column=st.sampled_from(list(SITES)), values=NUMBERS)
@settings(max_examples=40, deadline=None, derandomize=True)
def test_any_numbers_of_sites_are_mapped_or_refused(column, values):
    spoilt = SITES[column].copy()
    spoilt[:12] = values
    with suppress(tp.TissueProbeError):
        str(tp.map(SITES | {column: spoilt}))


@pytest.mark.parametrize(
    "order",
    [np.arange(400)[::-1], np.random.default_rng(1).permutation(400), np.arange(400) // 2],
    ids=["backwards", "in any order", "twice each"],
)
def test_times_that_do_not_ascend_change_no_answer_in_silence(order):
    table = {name: values[order] for name, values in TABLE.items()}
    try:
        found = tp.compare(tp.read(table, **READ), **STATED)
    except tp.TissueProbeError:
        return
    assert found.fit.named()["stiffness"] == pytest.approx(450.0, rel=0.01)


@pytest.mark.parametrize(
    ("column", "sentence"),
    [
        ([True, False] * 200, "column F holds truths"),
        ([1.0, True] * 200, "column F holds truths"),
        (np.arange(400) % 2 == 0, "column F holds truths"),
        (pd.Series([True, None] * 200, dtype="boolean"), "column F holds things"),
        (FORCE + 0j, "column F holds complex numbers"),
        ([str(each) for each in FORCE], "column F holds texts, such as"),
        (pd.Series(FORCE.astype(str)).astype("category"), "column F holds texts"),
        (FORCE.reshape(1, 400), "has the shape \\(1, 400\\)"),
        (FORCE[:, None], "has the shape \\(400, 1\\)"),
        ([[1.0], [1.0, 2.0]], "one value a row"),
        ([*FORCE[1:], 10**400], "no number|one value"),
        ([*FORCE[1:], 1e300], "beyond"),
        (pl.Series([[1.0, 2.0]] * 400), "holds things that are no numbers"),
    ],
)
def test_a_column_of_no_numbers_is_refused_and_says_what_it_holds(column, sentence):
    with pytest.raises(tp.TissueProbeError, match=sentence):
        tp.read(TABLE | {"F": column}, **READ)


MISSING = np.arange(400) % 50 == 7
KNOWN = np.where(MISSING, np.nan, FORCE)
NONE = [None if missing else force for missing, force in zip(MISSING, FORCE, strict=True)]


@pytest.mark.parametrize(
    "column",
    [
        NONE,
        np.ma.array(FORCE, mask=MISSING),
        pd.Series(NONE, dtype="Float64"),
        pd.Series(NONE, dtype="double[pyarrow]"),
        pd.Series([pd.NA if each is None else each for each in NONE], dtype=object),
        pd.Series(KNOWN).astype("category"),
        pd.Series(pd.arrays.SparseArray(KNOWN)),
        pl.Series(NONE),
    ],
    ids=["None", "masked", "Float64", "arrow", "NA", "category", "sparse", "polars"],
)
def test_values_that_are_missing_are_missing_however_they_are_told(column):
    found = tp.read(TABLE | {"F": column}, **READ)
    np.testing.assert_array_equal(found.force, tp.read(TABLE | {"F": KNOWN}, **READ).force)


UTC = pd.date_range("2024-03-31T00:59:59.9", periods=400, freq="ms", tz="UTC")
BERLIN = UTC.tz_convert("Europe/Berlin")  # the clock is put forward within the record


@pytest.mark.parametrize(
    "times",
    [
        pd.Series(BERLIN),
        BERLIN,
        pd.Series(BERLIN).astype("timestamp[ns, tz=Europe/Berlin][pyarrow]"),
        pl.from_pandas(pd.DataFrame({"t": BERLIN}))["t"],
        [each.isoformat() for each in BERLIN],
        [each.to_pydatetime() for each in BERLIN],
        pd.Series([each.to_pydatetime() for each in BERLIN], dtype=object),
        UTC.tz_localize(None),
    ],
    ids=["pandas", "index", "arrow", "polars", "ISO", "datetime", "objects", "UTC"],
)
def test_times_with_a_zone_are_those_of_utc(times):
    (part,) = tp.read(TABLE | {"t": times}, **READ).parts
    first = int(UTC[0].value)
    np.testing.assert_array_equal(part.recording.stamps - first, np.arange(400) * 10**6)


def test_times_with_and_without_a_zone_are_not_mixed():
    zone = datetime.timezone(datetime.timedelta(hours=2))
    times = [each.to_pydatetime().replace(tzinfo=None) for each in UTC]
    times[200:] = [each.replace(tzinfo=zone) for each in times[200:]]
    with pytest.raises(tp.TissueProbeError, match=r"tells the time .* otherwise than its first"):
        tp.read(TABLE | {"t": times}, **READ)


def test_files_that_cannot_be_read_or_written_are_told(tmp_path):
    folder = tmp_path / "none"
    for call in (
        lambda: tp.load_model(tmp_path),
        lambda: tp.compare(MEASURED, model=tmp_path / "none.yaml"),
        lambda: tp.compare(MEASURED, effects=tmp_path / "none.py", **STATED),
        lambda: tp.read("x" * 5000),
        lambda: COMPARED.model.save(folder / "model.yaml"),
        lambda: tp.estimate(MEASURED).save(folder / "table.csv"),
        lambda: tp.estimate(MEASURED).save(tmp_path / "table.txt"),
        lambda: tp.map(SITES).save_csv(folder / "table.csv"),
        lambda: tp.map(SITES).report(folder / "map.html"),
    ):
        with pytest.raises(tp.TissueProbeError, match="none|table.txt|xxx|" + tmp_path.name):
            call()


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: tp.simulate(COMPARED.model, SINE, noise=-1.0), "`noise` is -1.0; give a number"),
        (lambda: tp.simulate(COMPARED.model, SINE, sample_rate=1e12), "samples; give values with"),
        (lambda: tp.simulate(COMPARED.model, SINE, sample_rate=1e-9), "samples; give values with"),
        (lambda: tp.simulate(COMPARED.model, SINE | {"frequency": True}), "frequency is True"),
        (lambda: tp.simulate(COMPARED.model, ["1", "2", "3", "4"]), "holds texts"),
        (lambda: tp.estimate(MEASURED, settings={"tip_mass": True}), "tip_mass is True"),
        (lambda: tp.compare(MEASURED, site=0.5, **STATED), "`site` is 0.5; give a whole number"),
        (lambda: tp.compare(MEASURED, known_rig="no", **STATED), "`known_rig` is 'no'; give True"),
        (lambda: tp.compare(MEASURED, lowpass="50", **STATED), "`lowpass` is '50'; give a number"),
        (lambda: tp.compare([], **STATED), "no recording is given"),
        (lambda: tp.compare(tp.Measurements(()), **STATED), "no recording is given"),
        (lambda: COMPARED.predict({"stiffness": "450"}), "`values` stiffness is '450'; give"),
        (lambda: COMPARED.view(-1), "`index` is -1; give a whole number from 0 to 0"),
        (lambda: tp.map(SITES, within=CORNERS, next=True), "`next` is True; give a whole number"),
        (lambda: tp.read(TABLE, position=""), "`position` is ''; give the name of a column"),
        (lambda: tp.read(TABLE, position_unit="ell"), "`position_unit`: unit 'ell' is not known"),
    ],
)
def test_a_misuse_that_python_would_let_pass_is_refused(call, sentence):
    with pytest.raises(tp.TissueProbeError, match=sentence):
        call()


def test_a_size_of_a_unit_may_be_a_number():
    found = tp.read(TABLE, position_unit=2.0, **READ)
    np.testing.assert_allclose(found.position, 2.0 * DEPTH)


def test_an_error_of_the_users_own_function_stays_what_it_is(tmp_path):
    path = tmp_path / "record.csv"
    pd.DataFrame(TABLE).to_csv(path, index=False)

    def progress(share):
        raise ConnectionResetError("the page has gone")

    with pytest.raises(ConnectionResetError):
        tp.read(path, progress=progress, **READ)
