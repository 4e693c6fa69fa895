"""Columns come out of the containers that laboratories use, and nothing damaged breaks a reader."""

import io
import zipfile
import zlib
from contextlib import suppress
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from benchmarks.written_tables import (
    FORCE,
    KINDS,
    POLARITY,
    POSITION,
    TIME,
    ods,
    ods_rows,
    sheet_rows,
    xlsx,
)
from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.columns import bounds
from tissue_probe.recording.columns.open_columns import open_columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Layout


@pytest.mark.parametrize("name", KINDS)
def test_every_container_gives_the_same_samples(name, tmp_path):
    kind = KINDS[name]
    recording, _ = read_any(kind.write(tmp_path / name), Layout(**kind.stated))
    (block,) = recording.blocks
    assert block.sample_period == pytest.approx(1e-3, rel=1e-9)
    assert_allclose(block.position, POSITION, rtol=1e-12, atol=1e-15)
    assert_allclose(block.force, FORCE, rtol=1e-12, atol=1e-15)


def test_of_several_sheets_the_columns_are_named_with_theirs(tmp_path):
    path = xlsx(tmp_path / "x.xlsx", {"one": sheet_rows(), "two": sheet_rows()})
    assert open_columns(path).names[:2] == ("one!Time", "one!Extension")
    with pytest.raises(RecordingError, match="several columns that may be the time: one!Time"):
        read_any(path, Layout(**POLARITY))
    names = {"time": "two!Time", "position": "two!Extension", "force": "two!Load"}
    recording, _ = read_any(path, Layout(**names, **POLARITY))
    assert_allclose(recording.position, POSITION, atol=1e-15)
    mixed = {**names, "force": "one!Load"}
    with pytest.raises(RecordingError, match="are on several sheets"):
        read_any(path, Layout(**mixed, **POLARITY))


def test_what_stands_around_the_table_of_a_sheet_is_told(tmp_path):
    _, notes = read_any(KINDS["x.xlsx"].write(tmp_path / "x.xlsx"), Layout(**POLARITY))
    assert "2 lines of preamble; units from the row below the names" in notes[0]


@pytest.mark.parametrize("name", ["x.xlsx", "x.npz"])
def test_an_archive_that_expands_without_end_is_refused(name, tmp_path, monkeypatch):
    monkeypatch.setattr(bounds, "LARGEST_EXPANDED", 2**22)
    members = {"x.xlsx": "[Content_Types].xml", "x.npz": "t.npy"}
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr(members[name], b" " * 2**23)
    lying = content.getvalue().replace((2**23).to_bytes(4, "little"), (10).to_bytes(4, "little"))
    for each in (content.getvalue(), lying):
        (tmp_path / name).write_bytes(each)
        with pytest.raises(RecordingError, match="expands to more than 4 MiB"):
            open_columns(tmp_path / name)


def test_a_sheet_that_repeats_cells_without_end_is_refused(tmp_path):
    row = (
        '<table:table-row table:number-rows-repeated="1000000"><table:table-cell '
        'table:number-columns-repeated="10000" office:value-type="float" office:value="1"/>'
        "</table:table-row>"
    )
    with pytest.raises(RecordingError, match="expands to more than"):
        open_columns(ods(tmp_path / "x.ods", [*ods_rows(), row]))


@pytest.mark.parametrize("mark", [b"", b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"])
def test_a_matlab_file_of_zeros_alone_is_refused(mark, tmp_path):
    """A disk that was full leaves these; the gigabyte takes no room on the disk."""
    with (tmp_path / "x.mat").open("wb") as file:
        file.write(mark)
        file.truncate(2**30 - 2**20)
    with pytest.raises(RecordingError, match="is not a MATLAB file"):
        open_columns(tmp_path / "x.mat")


def test_a_matlab_file_that_expands_without_end_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(bounds, "LARGEST_EXPANDED", 2**20)
    packed = zlib.compress(b"\0" * 2**22)
    head = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"
    tag = (15).to_bytes(4, "little") + len(packed).to_bytes(4, "little")
    (tmp_path / "x.mat").write_bytes(head + tag + packed)
    with pytest.raises(RecordingError, match="expands to more than 1 MiB"):
        open_columns(tmp_path / "x.mat")


def test_a_dataset_that_would_fill_the_memory_is_refused(tmp_path):
    with h5py.File(tmp_path / "x.h5", "w") as file:
        for name in "tuF":
            file.create_dataset(name, (10**10,), chunks=(10**6,), dtype="f8")
    with pytest.raises(RecordingError, match="10000000000 rows, more than"):
        read_any(tmp_path / "x.h5", Layout())


@pytest.fixture(scope="module")
def originals(tmp_path_factory):
    folder = tmp_path_factory.mktemp("originals")
    for name, kind in KINDS.items():
        kind.write(folder / name)
    return folder


@pytest.mark.parametrize("name", KINDS)
@given(data=st.data())
@settings(max_examples=10, deadline=None)
def test_a_damaged_container_ends_in_a_sentence(name, data, originals, tmp_path_factory):
    content = bytearray((originals / name).read_bytes())
    places = st.one_of(st.integers(0, min(600, len(content) - 1)), st.integers(0, len(content) - 1))
    for _ in range(data.draw(st.integers(0, 6))):
        content[data.draw(places)] = data.draw(st.integers(0, 255))
    if data.draw(st.booleans()):
        content = content[: data.draw(places)]
    path = Path(tmp_path_factory.mktemp("damaged"), name)
    path.write_bytes(content)
    with suppress(ValueError):  # a sentence; what is no ValueError would be a traceback
        read_any(path, Layout(**KINDS[name].stated))


@pytest.mark.parametrize("kind", ["int16", "uint16", "int32"])
def test_counters_of_any_integer_type_are_counted_on(kind, tmp_path):
    counts = np.cumsum(np.full(TIME.size, 400))
    wrapped = counts.astype(np.uint16).astype(kind)  # as the encoder's register has it
    np.savez(tmp_path / "x.npz", t=TIME, enc=wrapped, F=FORCE)
    recording, notes = read_any(tmp_path / "x.npz", Layout(position="enc", position_unit="1e-6"))
    assert_allclose(np.diff(recording.position), 400e-6, rtol=1e-9)
    assert "counter of 16 bits" in notes[0]


def test_a_clock_of_32_bits_that_begins_again_is_counted_on(tmp_path):
    micros = (2**32 - 50_000 + 1000 * np.arange(TIME.size)).astype(np.uint32)
    np.savez(tmp_path / "x.npz", t=micros, u=POSITION, F=FORCE)
    (block,) = read_any(tmp_path / "x.npz", Layout(time_unit="us"))[0].blocks
    assert block.sample_period == pytest.approx(1e-3)
