"""Reading samples from CSV: time, position and force in columns, in SI units.

What belongs here: regularly sampled measurements of any instrument, as a ``Recording``.
What does not: files in other units or with jittering times (``table_file``), bags (``reader``).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np

from tissue_probe.recording.columns import read_columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import NANOSECONDS, FloatArray, IntArray, Recording, SampleBlock

JITTER = 0.25
"""Largest deviation of a step in time from a whole number of periods [periods].

It lets pass times that were rounded when written; the samples are taken as evenly spaced.
"""


def read_csv(
    path: str | Path,
    position: str = "u",
    force: str = "F",
    time: str = "t",
    polarity: Literal["compression", "tension"] = "compression",
    sample_period: float | None = None,
) -> Recording:
    """Read a measurement from a CSV file with a header line.

    Stamps are the file's times in ns, sequence numbers begin at 0. Where samples are missing (a
    step in time of two or more periods), a new block begins, its sequence number further on by
    as many. An empty cell of position or force, or ``nan``, is a sample not known (NaN).

    Parameters
    ----------
    path : path
        UTF-8, cells separated by commas, decimal points.
    position, force, time : str
        Names of the columns of displacement [m], positive into the tissue, force [N], and
        time [s].
    polarity : {"compression", "tension"}
        Which forces are positive in the file; those returned are positive in compression.
    sample_period : float, optional
        Time between two rows [s]. If given, the rows are taken as consecutive samples, the first at
        time 0, and no time column is read.

    Raises
    ------
    RecordingError
        If the file is not text, a column is missing or a cell no number, there are no rows, the
        time stands still or steps back, or its steps are not whole numbers of one period.
    ValueError
        If the polarity is another word, or the period not positive.
    """
    signs = {"compression": 1.0, "tension": -1.0}
    if polarity not in signs:
        raise ValueError(f"force polarity is '{polarity}'; it is 'compression' or 'tension'")
    if sample_period is not None and not 0.0 < sample_period < float("inf"):
        raise ValueError(f"sample_period is {sample_period} s; it must be positive")
    if sample_period is None:
        u, f, t = read_columns(path, [position, force, time])
        start, period, sequence = _regular(Path(path), t)
    else:
        u, f = read_columns(path, [position, force])
        start, period, sequence = 0.0, sample_period, np.arange(u.size)
    return Recording(tuple(_blocks(start, period, sequence, u, signs[polarity] * f)))


def _regular(path: Path, time: FloatArray) -> tuple[float, float, IntArray]:
    """Return the first time, the period [s], and the number of each sample."""
    if time.size < 2:
        raise RecordingError(f"{path} has one row; give at least two, or the sample period")
    _refuse(path, time, ~np.isfinite(time), "no time")
    steps = np.diff(time)
    _refuse(path, time, _after(steps <= 0.0), "a time not later than that before")
    period = _mean_period(steps)
    periods = steps / period
    counts = np.rint(periods).astype(np.int64)
    _refuse(
        path,
        time,
        _after((np.abs(periods - counts) > JITTER) | (counts == 0)),
        f"a step in time that is no whole number of periods of {period:g} s",
    )
    return time[0], period, np.concatenate([[0], np.cumsum(counts)])


def _mean_period(steps: FloatArray) -> float:
    """Average the steps of one period: times are often rounded, so that no single step is exact."""
    median = np.quantile(steps, 0.5, method="lower")  # one of the steps, no mean of two
    return float(np.mean(steps[np.rint(steps / median) == 1.0]))


def _after(steps: np.ndarray) -> np.ndarray:
    """Mark the sample at which each marked step ends."""
    return np.concatenate([[False], steps])


def _refuse(path: Path, time: FloatArray, wrong: np.ndarray, what: str) -> None:
    if wrong.any():
        row = int(np.argmax(wrong))
        raise RecordingError(
            f"{path}, row {row + 1} below the header (t = {time[row]:g} s): {what}; "
            "correct it, or give the sample period and leave the times out"
        )


def _blocks(
    start: float, period: float, sequence: IntArray, position: FloatArray, force: FloatArray
) -> Iterator[SampleBlock]:
    bounds = [0, *(np.flatnonzero(np.diff(sequence) > 1) + 1), sequence.size]
    for first, stop in pairwise(bounds):
        yield SampleBlock(
            stamp=round(start * NANOSECONDS) + round(sequence[first] * period * NANOSECONDS),
            sequence=int(sequence[first]),
            sample_period=period,
            position=position[first:stop],
            force=force[first:stop],
            command=np.full(stop - first, np.nan),
        )
