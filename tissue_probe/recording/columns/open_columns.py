"""Opening a file of columns by its content, not by its name.

Contents: telling containers apart.

Each container's library is imported only when such a file comes: together they take seconds.
"""

from __future__ import annotations

import zipfile
from pathlib import Path

from tissue_probe.errors import check_file
from tissue_probe.recording.columns.source import Columns
from tissue_probe.recording.errors import RecordingError

_HDF5 = b"\x89HDF\r\n\x1a\n"
_OLE = b"\xd0\xcf\x11\xe0"  # .xls


def open_columns(path: str | Path) -> Columns:
    """Open a file of columns: text, spreadsheet, TDMS, MATLAB, HDF5, NumPy or Parquet.

    Raises
    ------
    RecordingError
        If it is none of these, or cannot be read.
    NoFileError
        If there is no such file.
    """
    path = Path(path)
    check_file(path)
    with path.open("rb") as file:
        head = file.read(128)
    if not head:
        raise RecordingError(f"{path} is empty: nothing was recorded; record again")
    if head.startswith(b"PAR1"):
        from tissue_probe.recording.columns.parquet_file import open_parquet

        return open_parquet(path)
    if head.startswith(b"TDSm"):
        from tissue_probe.recording.columns.tdms_file import open_tdms

        return open_tdms(path)
    if head.startswith(b"\x93NUMPY"):
        from tissue_probe.recording.columns.numpy_file import open_npy

        return open_npy(path)
    if head.startswith(b"MATLAB 7.3") or head.startswith(b"MATLAB 5"):
        from tissue_probe.recording.columns.matlab_file import open_matlab

        return open_matlab(path)
    if head.startswith(_HDF5):
        from tissue_probe.recording.columns.hdf5_file import open_hdf5

        return open_hdf5(path)
    if head.startswith(b"PK\x03\x04"):
        return _open_zip(path)
    if head.startswith(_OLE):
        from tissue_probe.recording.columns.spreadsheet_file import open_spreadsheet

        return open_spreadsheet(path, None)
    return _open_text(path)


def _open_zip(path: Path) -> Columns:
    try:
        with zipfile.ZipFile(path) as members:
            names = members.namelist()
            if names and all(name.endswith(".npy") for name in names):
                from tissue_probe.recording.columns.numpy_file import open_npz

                return open_npz(path, members)
            if "[Content_Types].xml" in names or "content.xml" in names:
                from tissue_probe.recording.columns.spreadsheet_file import open_spreadsheet

                return open_spreadsheet(path, members)
    except (zipfile.BadZipFile, EOFError, NotImplementedError, RuntimeError) as error:
        raise RecordingError(f"{path} is a damaged archive: {error}") from error
    raise RecordingError(f"{path} is an archive, but no spreadsheet nor .npz: give the file in it")


_FILE_KINDS = {
    ".parquet": "a Parquet file",
    ".mat": "a MATLAB file",
    ".tdms": "a TDMS file",
    ".xlsx": "a spreadsheet",
    ".xls": "a spreadsheet",
    ".ods": "a spreadsheet",
    ".npz": "a NumPy file",
    ".npy": "a NumPy file",
    ".h5": "an HDF5 file",
    ".hdf5": "an HDF5 file",
}


def _open_text(path: Path) -> Columns:
    from tissue_probe.recording.columns.text_file import open_text

    try:
        return open_text(path)
    except RecordingError as error:
        if path.suffix.lower() == ".mat":  # version 4 begins with no mark
            from tissue_probe.recording.columns.matlab_file import open_matlab

            return open_matlab(path)
        called = _FILE_KINDS.get(path.suffix.lower())
        if called:
            raise RecordingError(f"{path} is not {called}: its content is another") from error
        raise
