"""Columns of HDF5 files, those of MATLAB 7.3 among them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.recording.columns.arrays import NUMBER_KINDS, array_column, array_columns
from tissue_probe.recording.columns.bounds import check_rows
from tissue_probe.recording.columns.source import Columns, Loaded, Progress
from tissue_probe.recording.errors import RecordingError

if TYPE_CHECKING:
    from h5py import AttributeManager, Dataset

_WRONG = (OSError, RuntimeError, ValueError, KeyError, TypeError)


def open_hdf5(path: Path, matlab: bool = False) -> Columns:
    """Open an HDF5 file: datasets by their path, a matrix's columns as ``path[:,0]``.

    Parameters
    ----------
    path : Path
        The file.
    matlab : bool
        Whether MATLAB wrote it: then structures have dotted names, and matrices lie on their side.

    Raises
    ------
    RecordingError
        If it is none.
    """
    from h5py import Dataset, File

    places: dict[str, str] = {}
    units: dict[str, str] = {}

    def collect(place: str, found: object) -> None:
        if not isinstance(found, Dataset) or place.startswith("#") or found.shape is None:
            return
        name = place.replace("/", ".") if matlab else place
        shape = found.shape[::-1] if matlab else found.shape
        for column in array_columns(name, shape, found.dtype):
            places[column] = place
            if unit := _unit(found.attrs):
                units[column] = unit

    try:
        with File(path) as file:
            file.visititems(collect)
    except _WRONG as error:
        raise RecordingError(f"{path} is not {_name_kind(matlab)}: {error}") from error

    def load(names: Sequence[str], progress: Progress) -> Loaded:
        try:
            with File(path) as file:
                return Loaded([_column(path, file[places[name]], name, matlab) for name in names])
        except RecordingError:
            raise
        except _WRONG as error:
            raise RecordingError(f"{path} is not {_name_kind(matlab)}: {error}") from error

    return Columns(path, tuple(places), load, units)


def _unit(attributes: AttributeManager) -> str:
    """Return the unit that a dataset's attributes tell; nothing where they tell none."""
    told = next((attributes[k] for k in attributes if k.casefold() in ("units", "unit")), "")
    if isinstance(told, np.ndarray) and told.size == 1:
        told = told.ravel()[0]
    return told.decode(errors="replace") if isinstance(told, bytes) else str(told)


def _name_kind(matlab: bool) -> str:
    return "a MATLAB file" if matlab else "an HDF5 file"


def _column(path: Path, dataset: Dataset, name: str, matlab: bool) -> np.ndarray:
    check_rows(path, dataset.size)
    array = dataset[()]
    column = array_column(array.T if matlab and array.ndim > 1 else array, name)
    return column if column.dtype.kind in NUMBER_KINDS else column.astype(np.float64)
