"""Estimates and samples as tables, in CSV or Parquet.

Contents: the tables' columns.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import (
    NANOSECONDS,
    FloatArray,
    IntArray,
    Recording,
    Status,
    TissueEstimates,
)

if TYPE_CHECKING:
    import pyarrow

# pyarrow is imported where it is used: it takes longer to load than most commands to run


def write_estimates(path: str | Path, estimates: TissueEstimates, origin: int) -> None:
    """Write estimates, one row each, every digit kept.

    Columns: time [s], stiffness [N/m], damping [N s/m], stiffness_variance [N^2/m^2],
    damping_variance [N^2 s^2/m^2], covariance_trace, innovation [N],
    normalized_innovation_squared [-], status (the name of the ``Status`` in lower case), model.

    Parameters
    ----------
    path : path
        Ends in ``.csv`` or ``.parquet``; a file of that name is overwritten.
    estimates : TissueEstimates
        Rows in their order.
    origin : int
        Where the column ``time`` is zero [ns]: the first sample's stamp for a recorded
        run; 0 for samples from a table, which gives the times that the table has.

    Raises
    ------
    RecordingError
        If the name ends otherwise.
    OSError
        If the file cannot be written.
    """
    _write(Path(path), estimate_columns(estimates, origin))


def estimate_columns(estimates: TissueEstimates, origin: int) -> dict[str, np.ndarray]:
    """Return the columns that ``write_estimates`` writes, by name."""
    names = np.array([status.name.lower() for status in sorted(Status)])
    return {
        "time": _seconds(estimates.stamp, origin),
        "stiffness": estimates.stiffness,
        "damping": estimates.damping,
        "stiffness_variance": estimates.stiffness_variance,
        "damping_variance": estimates.damping_variance,
        "covariance_trace": estimates.covariance_trace,
        "innovation": estimates.innovation,
        "normalized_innovation_squared": estimates.normalized_innovation_squared,
        "status": names[estimates.status],
        "model": np.asarray(estimates.model, object),
    }


def write_samples(path: str | Path, recording: Recording, origin: int) -> None:
    """Write a recording's samples, one row each, every digit kept.

    Columns: time [s], position [m], force [N], command [V], sequence [-], site (the number of
    the site where the probe dwells; empty where it does not), and if it dwells at any, where that
    is: site_x, site_y, site_z [m].

    Parameters
    ----------
    path, origin
        As in ``write_estimates``, and with the same errors.
    recording : Recording
        At least one sample.
    """
    columns = {
        "time": _seconds(recording.stamps, origin),
        "position": recording.position,
        "force": recording.force,
        "command": recording.command,
        "sequence": np.concatenate(
            [block.sequence + np.arange(len(block)) for block in recording.blocks]
        ),
        **_sites(recording),
    }
    _write(Path(path), columns)


def _seconds(stamps: IntArray, origin: int) -> FloatArray:
    return (stamps - origin) / NANOSECONDS


def _sites(recording: Recording) -> dict[str, pyarrow.Array]:
    """Return the number of the site at each sample, and if there are any, its place."""
    import pyarrow

    stamps = recording.stamps
    sites = np.zeros(stamps.size, dtype=np.int64)
    dwells = np.zeros(stamps.size, dtype=bool)
    places = np.full((stamps.size, 3), np.nan)
    for site, end in recording.dwells():
        during = (stamps >= site.stamp) & (stamps < end)
        sites[during] = site.site
        places[during] = site.position
        dwells |= during
    columns = {"site": pyarrow.array(sites, mask=~dwells)}
    if dwells.any():
        for axis, column in zip("xyz", places.T, strict=True):
            columns[f"site_{axis}"] = pyarrow.array(column, mask=~dwells)
    return columns


def _write(path: Path, columns: Mapping[str, np.ndarray | pyarrow.Array]) -> None:
    import pyarrow
    from pyarrow import csv, parquet

    if path.suffix not in (".csv", ".parquet"):
        raise RecordingError(f"{path} ends in '{path.suffix}'; tables are .csv or .parquet")
    with path.open("wb") as file:
        if path.suffix == ".csv":
            csv.write_csv(pyarrow.table(columns), file, csv.WriteOptions(quoting_header="none"))
        else:
            parquet.write_table(pyarrow.table(columns), file)
