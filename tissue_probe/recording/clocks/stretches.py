"""Cutting a recording into stretches of known samples, as they are fitted.

Contents: samples missing within a block, and dwells at sites.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tissue_probe.recording.clocks.even_grid import BRIDGED, interpolate
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import NANOSECONDS, BoolArray, FloatArray, Recording, SampleBlock

ROUNDED_SHARE = 1e-3
"""Stamps and periods are rounded: a time so little after a sample is that of the sample [periods].
"""


@dataclass(frozen=True, slots=True)
class Stretch(SampleBlock):
    """Samples without a hole: finite throughout.

    Parameters
    ----------
    measured : array of bool, shape (n,)
        Which of them are as they were measured; missing values of the others are filled in.
    """

    measured: BoolArray


def dwell_blocks(recording: Recording, site: int | None) -> tuple[SampleBlock, ...]:
    """Return the samples taken while the probe dwelt at a site.

    Parameters
    ----------
    recording : Recording
        At least one sample.
    site : int, optional
        Number of the site; without it, that of the only one, and the whole recording if it
        announces none.

    Raises
    ------
    RecordingError
        If there are several sites and none is chosen, or none of that number.
    """
    dwells = [(found.site, found.stamp, end) for found, end in recording.dwells()]
    numbers = sorted({number for number, _, _ in dwells})
    if site is None and not numbers:
        return recording.blocks
    if site is None and len(numbers) > 1:
        raise RecordingError(
            f"the recording palpates {len(numbers)} sites, each of its own tissue: choose one with "
            f"`site`, from {numbers[0]} to {numbers[-1]}"
        )
    chosen = numbers[0] if site is None else site
    parts = (
        _between(block, begin, end)
        for number, begin, end in dwells
        if number == chosen
        for block in recording.blocks
    )
    blocks = tuple(part for part in parts if part is not None)
    if not blocks:
        raise RecordingError(
            f"the recording has no samples at site {chosen}; it palpates "
            f"{', '.join(map(str, numbers)) or 'no sites'}"
        )
    return blocks


def _between(block: SampleBlock, begin: int, end: int) -> SampleBlock | None:
    period = block.sample_period * NANOSECONDS
    first, stop = (
        int(np.clip(np.ceil((time - block.stamp) / period - ROUNDED_SHARE), 0, len(block)))
        for time in (begin, end)
    )
    return block[first:stop] if first < stop else None


def cut_known(block: SampleBlock) -> tuple[list[Stretch], int]:
    """Cut a block where position or force is not known for more than 3 samples in a row.

    Fewer are filled in by a cubic spline; how many is returned beside the stretches, each of
    which is finite throughout.

    Parameters
    ----------
    block : SampleBlock
        Values that are not known are NaN or infinite.
    """
    known = np.isfinite(block.position) & np.isfinite(block.force)
    stretches, filled = [], 0
    for first, stop in _long_enough(known):
        stretch = block[first:stop]
        missing = ~known[first:stop]
        filled += int(np.count_nonzero(missing))
        stretches.append(_fill_missing(stretch, missing))
    return stretches, filled


def unknown_runs(block: SampleBlock, stretches: Sequence[SampleBlock]) -> list[tuple[int, int]]:
    """Return (first, stop) of each run of a block's samples that none of its stretches holds."""
    held = [(each.sequence - block.sequence, len(each)) for each in stretches]
    bounds = [0, *(bound for first, count in held for bound in (first, first + count)), len(block)]
    runs = zip(bounds[::2], bounds[1::2], strict=True)
    return [(first, stop) for first, stop in runs if first < stop]


def _long_enough(known: np.ndarray) -> Iterator[tuple[int, int]]:
    """Yield where stretches begin and end whose holes are all short."""
    places = np.flatnonzero(known)
    cuts = np.flatnonzero(np.diff(places) > BRIDGED + 1) + 1
    for first, stop in pairwise([0, *cuts, places.size]):
        if first < stop:
            yield int(places[first]), int(places[stop - 1]) + 1


def _fill_missing(block: SampleBlock, missing: BoolArray) -> Stretch:
    return Stretch(
        block.stamp,
        block.sequence,
        block.sample_period,
        _bridge_gaps(block.position),
        _bridge_gaps(block.force),
        block.command,
        measured=~missing,
    )


def _bridge_gaps(column: FloatArray) -> FloatArray:
    known = np.isfinite(column)
    if known.all():
        return column
    number = np.arange(column.size, dtype=np.float64)
    return np.where(known, column, interpolate(number, column, number, reach=BRIDGED + 1.5))
