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

_COMPRESSED = 15  # miCOMPRESSED, of the format's version 5
_HEADER = 128  # bytes


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
    """Count what the compressed variables of a file of version 5 expand to."""
    total = 0
    with path.open("rb") as file:
        order = "<" if file.read(_HEADER)[126:128] == b"IM" else ">"
        while len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            if kind != _COMPRESSED:
                file.seek(size, 1)
                continue
            expand = zlib.decompressobj()
            piece = file.read(size)
            try:
                while piece and not expand.eof:
                    total += len(expand.decompress(piece, 2**20))
                    check_size(path, total)
                    piece = expand.unconsumed_tail
            except zlib.error as error:
                raise RecordingError(f"{path} is not a MATLAB file: {error}") from error
