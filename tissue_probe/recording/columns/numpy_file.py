"""Columns of NumPy's ``.npy`` and ``.npz``."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tissue_probe.recording.columns.arrays import array_column, array_columns
from tissue_probe.recording.columns.bounds import check_zip
from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.recording.errors import RecordingError


def open_npy(path: Path) -> Columns:
    """Open a ``.npy`` file: a structured array has its fields, a matrix columns ``matrix[:,0]``.

    Raises
    ------
    RecordingError
        If it is none, or holds Python objects.
    """
    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except Exception as error:  # NumPy lets errors of zlib, ast and tokenize through
        raise RecordingError(f"{path} is not a NumPy file of numbers: {error}") from error
    return _columns(path, {"" if array.dtype.names else "matrix": array})


def open_npz(path: Path, members: zipfile.ZipFile) -> Columns:
    """Open a ``.npz`` file: vectors by their name, a matrix's columns as ``name[:,0]``.

    Raises
    ------
    RecordingError
        If it cannot be read, expands to too much, or holds Python objects.
    """
    check_zip(path, members)
    arrays = {}
    try:
        with np.load(path, allow_pickle=False) as file:
            for name in file.files:
                arrays[name] = file[name]
    except Exception as error:  # NumPy lets errors of zlib, ast and tokenize through
        raise RecordingError(f"{path} is not a NumPy file of numbers: {error}") from error
    return _columns(path, arrays)


def _columns(path: Path, arrays: dict[str, np.ndarray]) -> Columns:
    found = {
        column: array
        for name, array in arrays.items()
        for column in array_columns(name, array.shape, array.dtype)
    }

    def load(names: Sequence[str], progress: Progress) -> Loaded:
        return Loaded([array_column(found[name], name) for name in names])

    return Columns(path, tuple(found), load)
