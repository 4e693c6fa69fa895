"""Columns of MATLAB files, of any version."""

from __future__ import annotations

import struct
import subprocess
import sys
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from tissue_probe.recording.columns.arrays import array_column, array_columns
from tissue_probe.recording.columns.bounds import check_size
from tissue_probe.recording.columns.hdf5_file import open_hdf5
from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.recording.errors import RecordingError

_MATRIX, _COMPRESSED = 14, 15  # miMATRIX and miCOMPRESSED, of the format's version 5
_LONGEST_NAME = 2**10  # characters, with the zero that ends it; MATLAB's own are of 63
_HEADER_BYTES = 128  # bytes


def open_matlab(path: Path) -> Columns:
    """Open a MATLAB file: vectors by name, fields of structures dotted, ``matrix[:,0]``.

    Raises
    ------
    RecordingError
        If it is none, or expands to too much.
    """
    from h5py import is_hdf5

    if is_hdf5(path):  # version 7.3
        return open_hdf5(path, matlab=True)
    from scipy.io import loadmat

    _check_expanded(path)
    _check_survived(path)
    try:
        content = loadmat(path, simplify_cells=True)
    except Exception as error:  # scipy raises a dozen kinds on damaged files, none of its own
        raise RecordingError(f"{path} is not a MATLAB file: {error}") from error
    found = dict(_columns(content))

    def load(names: Sequence[str], progress: Progress) -> Loaded:
        return Loaded([array_column(found[name], name) for name in names])

    return Columns(path, tuple(found), load)


def _columns(content: Mapping[str, object], inside: str = "") -> Iterator[tuple[str, np.ndarray]]:
    """Yield the columns of variables, those of structures too."""
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _columns(value, f"{inside}{name}.")
        elif isinstance(value, list | np.ndarray) and any(isinstance(v, Mapping) for v in value):
            structs = {f"{name}({n})": v for n, v in enumerate(value, 1) if isinstance(v, Mapping)}
            yield from _columns(structs, inside)
        elif isinstance(value, np.ndarray):
            for column in array_columns(inside + name, value.shape, value.dtype):
                yield column, value


def _check_survived(path: Path) -> None:
    """Let another process read the file first: a damaged one may end SciPy's reader by a signal."""
    read = "import sys; from scipy.io import loadmat; loadmat(sys.argv[1], simplify_cells=True)"
    ended = subprocess.run([sys.executable, "-c", read, path], capture_output=True, check=False)
    if ended.returncode not in (0, 1):  # 1 is an exception's, which is told by its own words
        raise RecordingError(f"{path} is damaged: reading it ended the reader")


def _check_expanded(path: Path) -> None:
    """Refuse content that is none of MATLAB's, and count the size of expanded variables."""
    total = path.stat().st_size
    check_size(path, total)
    with path.open("rb") as file:
        head = file.read(_HEADER_BYTES)
        if not head.startswith(b"MATLAB 5"):
            _check_version_4(path, head)
            return
        order = "<" if head[126:128] == b"IM" else ">"
        while len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            if kind == _MATRIX:
                file.seek(size, 1)
                continue
            if kind != _COMPRESSED:
                raise RecordingError(f"{path} is not a MATLAB file: it holds no variables")
            expand = zlib.decompressobj()
            piece = file.read(size)
            try:
                while piece and not expand.eof:
                    total += len(expand.decompress(piece, 2**20))
                    check_size(path, total)
                    piece = expand.unconsumed_tail
            except zlib.error as error:
                raise RecordingError(f"{path} is not a MATLAB file: {error}") from error


def _check_version_4(path: Path, head: bytes) -> None:
    """Refuse a file whose first variable has no name: of zeros SciPy would read on for an hour."""
    names = [int.from_bytes(head[16:20], order) for order in ("little", "big")]
    if not any(1 < length <= _LONGEST_NAME for length in names):
        raise RecordingError(f"{path} is not a MATLAB file: it begins with no variable")
