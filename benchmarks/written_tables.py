"""Files of the kinds that laboratories have, all of one recording.

Contents: writing them.
"""

from __future__ import annotations

import datetime
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
import pyarrow
import xlwt
from nptdms import ChannelObject, RootObject, TdmsWriter
from pyarrow import parquet
from scipy.io import savemat

ROWS = 300
PERIOD = 1e-3
TIME = np.arange(ROWS) * PERIOD
POSITION = 1e-3 * np.sin(2.0 * np.pi * 10.0 * TIME)
FORCE = 450.0 * POSITION
MATRIX = np.column_stack([TIME, POSITION, FORCE])
SI = {"position_unit": "m", "force_unit": "N", "force_polarity": "compression"}


def sheet_rows():
    yield "<row>" + _text("Operator") + _text("Smith") + "</row>"
    yield "<row></row>"
    yield "<row>" + "".join(map(_text, ("Time", "Extension", "Load"))) + "</row>"
    yield "<row>" + "".join(map(_text, ("s", "mm", "N"))) + "</row>"
    for t, u, f in MATRIX.tolist():
        yield f"<row><c><v>{t!r}</v></c><c><v>{1e3 * u!r}</v></c><c><v>{f!r}</v></c></row>"


def _text(word):
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


def xls(path):
    """Write a workbook as Excel did until 2003, with a title above the table."""
    sheet = (book := xlwt.Workbook()).add_sheet("run")
    for row, values in enumerate([["Operator"], ["t", "u", "F"], *MATRIX.tolist()]):
        for column, value in enumerate(values):
            sheet.write(row, column, value)
    book.save(str(path))
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


class Kind(NamedTuple):
    """How a file is written, and what has to be stated to read it."""

    write: Callable[[Path], Path]
    stated: Mapping[str, str]


KINDS = {
    name: Kind(*each)
    for name, each in {
        "x.xlsx": (lambda p: xlsx(p, {"run": sheet_rows()}), POLARITY),
        "x.xls": (xls, {}),
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
    }.items()
}
