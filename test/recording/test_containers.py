"""Columns come out of the containers that laboratories use, and nothing damaged breaks a reader."""

import datetime
import io
import zipfile
import zlib
from pathlib import Path

import h5py
import numpy as np
import pyarrow
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nptdms import ChannelObject, RootObject, TdmsWriter
from numpy.testing import assert_allclose
from pyarrow import parquet
from scipy.io import savemat

from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.columns import bounds
from tissue_probe.recording.columns.open_columns import open_columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Layout

ROWS = 300
TIME = np.arange(ROWS) * 1e-3
POSITION = 1e-3 * np.sin(2.0 * np.pi * 10.0 * TIME)
FORCE = 450.0 * POSITION
MATRIX = np.column_stack([TIME, POSITION, FORCE])
SI = {"position_unit": "m", "force_unit": "N", "force_polarity": "compression"}


def sheet_rows():
    yield "<row>" + text("Operator") + text("Smith") + "</row>"
    yield "<row></row>"
    yield "<row>" + "".join(map(text, ("Time", "Extension", "Load"))) + "</row>"
    yield "<row>" + "".join(map(text, ("s", "mm", "N"))) + "</row>"
    for t, u, f in MATRIX.tolist():
        yield f"<row><c><v>{t!r}</v></c><c><v>{1e3 * u!r}</v></c><c><v>{f!r}</v></c></row>"


def text(word):
    return f'<c t="inlineStr"><is><t>{word}</t></is></c>'


MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
PACKAGE = "http://schemas.openxmlformats.org/package/2006"


def xlsx(path, sheets):
    """Write the parts of a workbook, as the standard has them."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr(
            "[Content_Types].xml",
            f'<Types xmlns="{PACKAGE}/content-types"><Default Extension="xml" '
            'ContentType="application/xml"/></Types>',
        )
        names = "".join(
            f'<sheet name="{name}" sheetId="{n}" r:id="r{n}"/>' for n, name in enumerate(sheets, 1)
        )
        file.writestr(
            "_rels/.rels",
            f'<Relationships xmlns="{PACKAGE}/relationships"><Relationship Id="r1" '
            f'Type="{OFFICE}/officeDocument" Target="xl/workbook.xml"/></Relationships>',
        )
        file.writestr(
            "xl/workbook.xml",
            f'<workbook xmlns="{MAIN}" xmlns:r="{OFFICE}"><sheets>{names}</sheets></workbook>',
        )
        relations = "".join(
            f'<Relationship Id="r{n}" Type="{OFFICE}/worksheet" Target="worksheets/s{n}.xml"/>'
            for n in range(1, len(sheets) + 1)
        )
        file.writestr(
            "xl/_rels/workbook.xml.rels",
            f'<Relationships xmlns="{PACKAGE}/relationships">{relations}</Relationships>',
        )
        for n, rows in enumerate(sheets.values(), 1):
            file.writestr(
                f"xl/worksheets/s{n}.xml",
                f'<worksheet xmlns="{MAIN}"><sheetData>{"".join(rows)}</sheetData></worksheet>',
            )
    return path


def ods(path, rows):
    """Write the parts of an OpenDocument spreadsheet."""
    names = ("office", "table", "text")
    spaces = " ".join(f'xmlns:{n}="urn:oasis:names:tc:opendocument:xmlns:{n}:1.0"' for n in names)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
        file.writestr("META-INF/manifest.xml", "<manifest/>")
        file.writestr(
            "content.xml",
            f"<office:document-content {spaces}><office:body><office:spreadsheet>"
            f'<table:table table:name="run">{"".join(rows)}</table:table>'
            "</office:spreadsheet></office:body></office:document-content>",
        )
    return path


def ods_rows():
    def cell(value):
        if isinstance(value, str):
            return (
                f'<table:table-cell office:value-type="string"><text:p>{value}</text:p>'
                "</table:table-cell>"
            )
        return f'<table:table-cell office:value-type="float" office:value="{value!r}"/>'

    for row in [["t", "u", "F"], *MATRIX.tolist()]:
        yield f"<table:table-row>{''.join(map(cell, row))}</table:table-row>"


def tdms(path, **properties):
    with TdmsWriter(path) as file:
        channels = [
            ChannelObject("run", name, values, {**properties, "unit_string": unit})
            for name, values, unit in (("Stroke", 1e3 * POSITION, "mm"), ("Load", FORCE, "N"))
        ]
        if not properties:
            channels.append(ChannelObject("run", "Time", TIME, {"unit_string": "s"}))
        file.write_segment([RootObject(), *channels])
    return path


def matlab73(path, content):
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in content.items():
            file[name] = values
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    return path


def hdf5(path):
    with h5py.File(path, "w") as file:
        file["run/1/t"] = TIME
        file["run/1/u"] = 1e3 * POSITION
        file["run/1/u"].attrs["units"] = "mm"
        file["run/1/F"] = FORCE
    return path


def save_npz(path, **arrays):
    np.savez_compressed(path, **arrays)
    return path


def save_npy(path, array):
    np.save(path, array)
    return path


def save_mat(path, **variables):
    savemat(path, variables)
    return path


def save_parquet(path, time):
    parquet.write_table(pyarrow.table({"t": time, "u_mm": 1e3 * POSITION, "F": FORCE}), path)
    return path


MATRIX_NAMES = {"time": "m[:,0]", "position": "m[:,1]", "force": "m[:,2]", **SI}
POLARITY = {"force_polarity": "compression"}
STARTED = datetime.datetime(2026, 3, 1, 23, 59, 59, 900_000)
KINDS = {
    "x.xlsx": (lambda p: xlsx(p, {"run": sheet_rows()}), POLARITY),
    "x.ods": (lambda p: ods(p, ods_rows()), {}),
    "x.tdms": (tdms, POLARITY),
    "wave.tdms": (lambda p: tdms(p, wf_increment=1e-3), POLARITY),
    "x.mat": (lambda p: save_mat(p, m=MATRIX), MATRIX_NAMES),
    "struct.mat": (lambda p: save_mat(p, run={"t": TIME, "u": POSITION, "F": FORCE}), SI),
    "x.v73.mat": (lambda p: matlab73(p, {"m": MATRIX.T}), MATRIX_NAMES),
    "x.h5": (hdf5, {"force_unit": "N", **POLARITY}),
    "x.npz": (lambda p: save_npz(p, t=TIME, u=POSITION, F=FORCE), {}),
    "m.npz": (lambda p: save_npz(p, m=MATRIX), MATRIX_NAMES),
    "x.npy": (
        lambda p: save_npy(p, MATRIX),
        {k: v.replace("m[", "matrix[") for k, v in MATRIX_NAMES.items()},
    ),
    "s.npy": (
        lambda p: save_npy(
            p, np.array([*map(tuple, MATRIX)], dtype=[("t", "f8"), ("u", "f8"), ("F", "f8")])
        ),
        {},
    ),
    "x.parquet": (
        lambda p: save_parquet(
            p, [STARTED + datetime.timedelta(milliseconds=n) for n in range(ROWS)]
        ),
        {},
    ),
    "seconds.parquet": (lambda p: save_parquet(p, TIME), {}),
}


@pytest.mark.parametrize("name", KINDS)
def test_every_container_gives_the_same_samples(name, tmp_path):
    write, stated = KINDS[name]
    recording, _ = read_any(write(tmp_path / name), Layout(**stated))
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
    _, notes = read_any(KINDS["x.xlsx"][0](tmp_path / "x.xlsx"), Layout(**POLARITY))
    assert "2 lines of preamble; units from the row below the names" in notes[0]


@pytest.mark.parametrize("name", ["x.xlsx", "x.npz"])
def test_an_archive_that_expands_without_end_is_refused(name, tmp_path, monkeypatch):
    monkeypatch.setattr(bounds, "LARGEST", 2**22)
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


def test_a_matlab_file_that_expands_without_end_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(bounds, "LARGEST", 2**20)
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
    for name, (write, _) in KINDS.items():
        write(folder / name)
    return folder


@pytest.mark.parametrize("name", KINDS)
@given(data=st.data())
@settings(max_examples=25, deadline=None)
def test_a_damaged_container_ends_in_a_sentence(name, data, originals, tmp_path_factory):
    content = bytearray((originals / name).read_bytes())
    places = st.one_of(st.integers(0, min(600, len(content) - 1)), st.integers(0, len(content) - 1))
    for _ in range(data.draw(st.integers(0, 6))):
        content[data.draw(places)] = data.draw(st.integers(0, 255))
    if data.draw(st.booleans()):
        content = content[: data.draw(places)]
    path = Path(tmp_path_factory.mktemp("damaged"), name)
    path.write_bytes(content)
    try:
        read_any(path, Layout(**KINDS[name][1]))
    except ValueError as error:
        assert str(error).startswith(str(path)) or "unit" in str(error)
