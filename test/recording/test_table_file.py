"""Columns of any instrument are read in SI, or it is said what has to be stated."""

import h5py
import numpy as np
import pyarrow
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from pyarrow import parquet
from scipy.io import savemat

from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.columns.open_columns import open_columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Layout

TIME = np.arange(400) * 1e-3
POSITION = 1e-3 * np.sin(2.0 * np.pi * 10.0 * TIME)
FORCE = 450.0 * POSITION


def write(path, columns):
    """Write columns in the format that the path's end names; ``.v73.mat`` is HDF5."""
    if path.suffix == ".csv":
        rows = np.column_stack(list(columns.values()))
        header = ",".join(columns)
        np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.17g")
    elif path.suffix == ".parquet":
        parquet.write_table(pyarrow.table(columns), path)
    elif path.name.endswith(".v73.mat"):
        with h5py.File(path, "w", userblock_size=512) as file:
            for name, values in columns.items():
                file[name.replace(".", "/")] = np.atleast_2d(values)
        with path.open("r+b") as file:
            file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    else:
        savemat(path, {name: values[:, None] for name, values in columns.items()})
    return path


def read(path, **layout):
    recording, _ = read_any(path, Layout(**layout))
    return recording


FILES = ["x.csv", "x.parquet", "x.mat", "x.v73.mat"]


@pytest.mark.parametrize("name", FILES)
def test_the_suites_own_columns_need_no_statement(name, tmp_path):
    for names in (("t", "u", "F"), ("time", "position", "force")):
        path = write(tmp_path / name, dict(zip(names, (TIME, POSITION, FORCE), strict=True)))
        (block,) = read(path).blocks
        assert_array_equal(block.position, POSITION)
        assert_array_equal(block.force, FORCE)
        assert block.sample_period == pytest.approx(1e-3)
        assert np.isnan(block.command).all()


@pytest.mark.parametrize("name", FILES)
def test_foreign_columns_are_read_in_the_units_and_polarity_stated(name, tmp_path):
    path = write(tmp_path / name, {"T": TIME, "depth": 1e3 * POSITION, "load": -1e3 * FORCE})
    stated = {"time": "T", "position": "depth", "force": "load"}
    units = {"position_unit": "mm", "force_unit": "mN", "force_polarity": "tension"}
    (block,) = read(path, **stated, **units).blocks
    assert_allclose(block.position, POSITION, rtol=1e-14)
    assert_allclose(block.force, FORCE, rtol=1e-14)


@pytest.mark.parametrize(
    ("names", "sizes"),
    [
        (("t_ms", "u_mm", "F_gf"), (1e3, 1e3, 1 / 9.80665e-3)),
        (("time (us)", "position (um)", "force [kN]"), (1e6, 1e6, 1e-3)),
        (("t_s", "u_µm", "F_mN"), (1.0, 1e6, 1e3)),
    ],
)
def test_a_unit_in_the_columns_name_counts(names, sizes, tmp_path):
    columns = (TIME * sizes[0], POSITION * sizes[1], FORCE * sizes[2])
    path = write(tmp_path / "x.parquet", dict(zip(names, columns, strict=True)))
    (block,) = read(path, force_polarity="compression").blocks
    assert block.sample_period == pytest.approx(1e-3)
    assert_allclose(block.position, POSITION, rtol=1e-12)
    assert_allclose(block.force, FORCE, rtol=1e-12)


def test_a_size_in_newtons_reads_volts(tmp_path):
    path = write(tmp_path / "x.csv", {"t": TIME, "u": POSITION, "volts": FORCE / 35.15})
    stated = {"force": "volts", "force_unit": "35.15", "force_polarity": "compression"}
    assert_allclose(read(path, **stated).force, FORCE, rtol=1e-14)


def test_heights_are_turned_into_indentation(tmp_path):
    path = write(tmp_path / "x.csv", {"t": TIME, "u": -POSITION, "F": FORCE})
    assert_array_equal(read(path, position_polarity="out").position, POSITION)


def test_a_rate_stands_for_the_times(tmp_path):
    path = write(tmp_path / "x.csv", {"u": POSITION, "F": FORCE})
    (block,) = read(path, sample_rate=2000.0).blocks
    assert (block.stamp, block.sequence, block.sample_period) == (0, 0, 5e-4)


def test_structures_of_matlab_have_dotted_names(tmp_path):
    old = tmp_path / "x.mat"
    savemat(old, {"run": {"t": TIME, "u": POSITION, "F": FORCE}, "gain": 3.0, "who": "me"})
    new = write(tmp_path / "y.v73.mat", {"run.t": TIME, "run.u": POSITION, "run.F": FORCE})
    for path in (old, new):
        assert sorted(open_columns(path).names) == ["run.F", "run.t", "run.u"]
        names = {"time": "run.t", "position": "run.u", "force": "run.F"}
        stated = {"position_unit": "m", "force_unit": "N", "force_polarity": "tension"}
        assert_array_equal(read(path, **names, **stated).force, -FORCE)


def test_jittering_times_are_resampled_and_it_is_said(tmp_path):
    time = TIME + 1e-4 * np.random.default_rng(5).uniform(-1.0, 1.0, TIME.size)
    position = 1e-3 * np.sin(2.0 * np.pi * 10.0 * time)
    path = write(tmp_path / "x.csv", {"t": time, "u": position, "F": 450.0 * position})
    recording, notes = read_any(path, Layout())
    (block,) = recording.blocks
    even = block.stamp / 1e9 + block.sample_period * np.arange(len(block))
    assert_allclose(block.position, 1e-3 * np.sin(2.0 * np.pi * 10.0 * even), atol=2e-8)
    assert "resampled" in notes[0]


@pytest.mark.parametrize(
    ("names", "layout", "said"),
    [
        (("t", "x", "F"), {}, "the position: give `position`; its columns are "),
        (("a", "u", "F"), {}, "give `time` (or `sample_rate` where there is none)"),
        (("t", "u", "F"), {"position": "w"}, "has no column w; its columns are "),
        (
            ("t", "x", "load"),
            {"position": "x", "force": "load"},
            "state `position_unit` (m, cm, mm, um, nm, in or a number), `force_unit` (N, mN, uN, "
            "nN, kN, gf, kgf, lbf or a number), `force_polarity` (compression or tension",
        ),
        (("t", "u", "F_mN"), {}, "everything; state `force_polarity`"),
        (("t", "u", "F"), {"position_unit": "ell"}, "unit 'ell' is not known; give m, cm, mm"),
        (("t", "u", "F"), {"force_unit": "-1"}, "unit '-1' is not known"),
    ],
)
@pytest.mark.parametrize("file", FILES)
def test_what_has_to_be_stated_is_asked_for(names, layout, said, file, tmp_path):
    path = write(tmp_path / file, dict(zip(names, (TIME, POSITION, FORCE), strict=True)))
    with pytest.raises(ValueError) as raised:  # noqa: PT011
        read(path, **layout)
    assert said in str(raised.value)


@pytest.mark.parametrize("name", ["x.csv", "x.parquet", "x.mat"])
def test_a_file_that_is_not_what_it_is_called_is_refused(name, tmp_path):
    (tmp_path / name).write_bytes(b"\xff\xfe nothing that anybody reads" * 20)
    with pytest.raises(RecordingError, match="is not a"):
        read(tmp_path / name)


def test_columns_of_different_lengths_are_refused(tmp_path):
    savemat(tmp_path / "x.mat", {"t": TIME, "u": POSITION[:-1], "F": FORCE})
    with pytest.raises(RecordingError, match="t has 400, u has 399, F has 400 values"):
        read(tmp_path / "x.mat")


def test_words_in_a_column_are_refused(tmp_path):
    columns = {"t": TIME, "u": POSITION, "F": ["heavy"] * TIME.size}
    with pytest.raises(RecordingError, match="column F has no numbers"):
        read(write(tmp_path / "x.parquet", columns))


@pytest.mark.parametrize("wrong", [{"sample_rate": 0.0}, {"sample_rate": 1.0, "time": "t"}])
def test_a_layout_that_cannot_be_is_refused(wrong):
    with pytest.raises(ValueError, match="`sample_rate`"):
        Layout(**wrong)
