"""From the times at which a foreign recorder sampled to evenly spaced samples.

Contents: telling rounded times from jittering ones and from gaps, resampling.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tissue_probe.jumps import jumps
from tissue_probe.recording.columns.source import row_place
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import NANOSECONDS, FloatArray, IntArray, SampleBlock

GAP, RARE_GAP = 1.5, 5.0
"""Steps in time longer than the first are gaps, shorter ones jitter [periods]; or longer than so
many standard deviations of the steps, where these jitter more: white jitter is so in one of three
million."""

NORMAL = 1.4826
"""Standard deviation of normal errors over the median of their sizes."""

BRIDGED = 3
"""As many missing samples in a row are filled in; at more a new stretch begins."""

IRREGULAR_SHARE = 1.0 / 3.0
"""Share of steps in time off by more than half a period that makes a recording no regular one: as
many as where a usual step is off by half a period (one standard deviation)."""

WHOLE = 0.1
"""Steps as near as this to several whole periods are none of these: samples are missing [periods].
"""

ODD, FEW_ODD = 0.02, 0.01
"""Steps off by more than so many periods do not count in the period where they are so few."""

MOST_EVEN_TIMES = 32
"""Even times at the highest rate of several are at most so many times the samples: a model is
simulated at all of them."""

LASTING = 15
"""Steps of which more than half are alike where a recording goes on at another rate: a few missing
samples are none."""

NEGLIGIBLE = 1e-3
"""Jitter that is not worth resampling [periods]."""


SAMPLES_TOGETHER = 2**14
"""Samples that are looked at together: of a long recording, each column more fills the memory."""

MARGIN = 64
"""Samples on either side of a piece: a spline forgets one by a factor of 3.7, 64 to rounding."""


SPLINE = 4
"""Fewer values have no cubic spline: between them a straight line goes on."""


class Span(NamedTuple):
    """Samples without a long gap.

    Rows of the file, number of the first sample, even times [s], and if they are even as they are,
    at which of them the rows were taken.
    """

    rows: slice
    sequence: int
    times: FloatArray
    places: IntArray


@dataclass(frozen=True)
class EvenGrid:
    """Evenly spaced times.

    Attributes
    ----------
    period : float
        Time between two samples [s].
    spans : tuple of Span
        The rows between the gaps.
    even : bool
        Whether the samples are so spaced as they are; if not they have to be resampled.
    notes : tuple of str
        Notes for the user, in sentences.
    longest : float
        Step in the file's times from which on it is a gap [periods].
    """

    period: float
    spans: tuple[Span, ...]
    even: bool
    notes: tuple[str, ...]
    longest: float = GAP

    def noise(self, time: FloatArray) -> FloatArray | None:
        """Return white noise of variance 1, sampled at the file's ``time`` [s] and resampled.

        It shows how much of a channel's noise is left, and in which colour. Of the longest span, at
        most ``SAMPLES_TOGETHER`` samples; None where the samples are taken as they are.
        """
        if self.even:
            return None
        at = max(self.spans, key=lambda span: span.times.size).times[:SAMPLES_TOGETHER]
        white = np.random.default_rng(0).standard_normal(time.size)
        resampled = interpolate(time, white, at, reach=self.longest)
        return resampled[np.isfinite(resampled)]

    def values(self, span: Span, time: FloatArray, column: FloatArray) -> FloatArray:
        """Return a column sampled at the file's ``time`` [s] at the times of a span.

        NaN where a sample is missing.
        """
        if not self.even:
            return interpolate(time, column, span.times, reach=self.longest)
        values = np.full(span.times.size, np.nan)
        values[span.places] = column[span.rows]
        return values


def even_grid(
    time: FloatArray, where: str, bridged: int = 0, place: Callable[[int], str] = row_place
) -> EvenGrid:
    """Find the even grid that times lie on, or jitter about.

    A step longer than 1.5 periods, or than jitter ever makes it, is a gap. Deviations from even
    spacing that rounding of the written times explains, or below 1/1000 of a period, are taken as
    none.

    Parameters
    ----------
    time : array, shape (n,)
        Time of each sample [s].
    where : str
        The name of the times' file in messages.
    bridged : int
        Gaps of up to so many samples, if it goes on in step behind them, do not split: the samples
        missing there are not known, as others of the file may be.
    place : callable
        Says where in the file a time (from 0) is.

    Raises
    ------
    RecordingError
        If there are fewer than two times, one is not known or not later than the one before, or
        more than a third of the steps are off by more than half a period, and no whole number of
        them.
    """
    _check(time, where, place)
    steps = np.diff(time)
    usual = np.quantile(steps, 0.5, method="lower")  # one of the steps, no mean of two
    there = _usual_there(steps, usual)
    _refuse_irregular(steps, there, where)
    longest = longest_step(steps, there)
    inside = steps <= longest * there
    if isinstance(there, np.ndarray):
        return _of_several_rates(time, steps, inside, there, where)
    rows = _parts(inside)
    odd = (np.abs(_ratio(steps, usual, 1.0)) > ODD)[inside]
    few = 0.0 < odd.mean() < FEW_ODD
    period = float(np.mean(steps[inside][~odd])) if few else _period(time, rows)
    jitter = max(_jitter(time[part], period) for part in rows)
    even = jitter <= max(_measure_rounding(time), NEGLIGIBLE * period)
    notes = []
    if not even:
        notes.append(
            f"{where}: times deviate by up to {1e3 * jitter:.3g} ms from even spacing; where that "
            f"is needed, resampled by a cubic spline at {1.0 / period:.6g} Hz"
        )
    # Two times are rounded; resampled rows keep their times, in step or not.
    in_step = ~np.array(even) | (
        _off(steps, period) <= 2.0 * max(_measure_rounding(time), NEGLIGIBLE * period)
    )
    joined = inside | (in_step & (steps <= (bridged + longest) * period))
    rows = _parts(joined)
    gaps = steps[~joined]
    del steps, in_step, inside, odd  # a long recording fills the memory
    if gaps.size:
        notes.append(
            f"{where}: {gaps.size} gap{'s' if gaps.size > 1 else ''}, the longest "
            f"{gaps.max():.4g} s; split into {gaps.size + 1} parts"
        )
    return EvenGrid(period, tuple(_spans(time, rows, period, even)), even, tuple(notes), longest)


def _usual_there(steps: FloatArray, usual: float) -> float | FloatArray:
    """Return the usual step, or that about each of the steps where a recording has several rates.

    A rate lasts for more than half of ``LASTING`` steps, which are even, and is no whole number of
    periods of the others: there samples are missing.
    """
    if steps.size < LASTING or float(steps.max()) <= GAP * float(steps.min()):
        return usual
    from scipy.ndimage import median_filter  # loaded with the other code for uneven times

    there = median_filter(steps, LASTING, mode="nearest")
    even = np.mean(np.abs(_ratio(steps, there, 1.0)) > WHOLE) < IRREGULAR_SHARE
    others = bool(np.any(_off(there, usual) > WHOLE * usual))
    apart = GAP * there.min() < there.max()
    few = float(np.sum(there)) < MOST_EVEN_TIMES * there.size * float(there.min())
    return there if others and even and apart and few else usual


def _of_several_rates(
    time: FloatArray, steps: FloatArray, inside: np.ndarray, there: FloatArray, where: str
) -> EvenGrid:
    """Return the grid of the highest of several rates, on which the slower samples are resampled.

    All samples keep their own times beside it.
    """
    period = float(np.median(steps[there < GAP * there.min()]))
    rows = _parts(inside)
    notes = [
        f"{where}: sampled at rates from {1.0 / there.max():.4g} to {1.0 / there.min():.4g} Hz; "
        "each sample keeps its time"
    ]
    if len(rows) > 1:
        notes.append(f"{where}: split into {len(rows)} parts by gaps")
    longest = float(steps[inside].max() / np.median(steps)) * (1.0 + NEGLIGIBLE)
    spans = tuple(_spans(time, rows, period, even=False))
    return EvenGrid(period, spans, even=False, notes=tuple(notes), longest=longest)


def interpolate(
    time: FloatArray, values: FloatArray, at: FloatArray, reach: float = 2.5
) -> FloatArray:
    """Return values at other times by a cubic spline through those that are known.

    NaN before the first and after the last known value, and between two that are further apart
    than ``reach``.

    Parameters
    ----------
    time : array, shape (n,)
        Ascending times of the values [s].
    values : array, shape (n,)
        NaN where not known.
    at : array, shape (k,)
        Times to sample at [s].
    reach : float
        In usual steps of ``time``.
    """
    result = np.empty(at.size)
    usual = np.median(np.diff(time), overwrite_input=True)
    for first in range(0, at.size, SAMPLES_TOGETHER):
        piece = slice(first, first + SAMPLES_TOGETHER)
        begin, end = np.searchsorted(time, [at[piece][0], at[piece][-1]])
        near = slice(max(int(begin) - MARGIN, 0), int(end) + MARGIN)
        result[piece] = _piece(time[near], values[near], at[piece], reach * usual)
    return result


def _piece(time: FloatArray, values: FloatArray, at: FloatArray, longest: float) -> FloatArray:
    """Return values at ascending times; NaN in steps longer than ``longest`` [s].

    By a spline through those between two jumps, across which it would ring.
    """
    known = np.isfinite(values)
    result = np.full(at.size, np.nan)
    if np.count_nonzero(known) < 2:
        return result
    t, y = time[known], values[known]
    after = np.clip(np.searchsorted(t, at), 1, t.size - 1)
    near = t[after] - t[after - 1] <= longest
    inside = near & (at >= t[0]) & (at <= t[-1])
    from scipy.interpolate import CubicSpline  # only where times are uneven

    result[inside] = np.interp(at[inside], t, y)
    for first, last in pairwise([0, *_after_jumps(t, y), t.size]):
        own = inside & (at >= t[first]) & (at <= t[last - 1])
        if last - first >= SPLINE and own.any():
            result[own] = CubicSpline(t[first:last], y[first:last])(at[own])
    return result


def _after_jumps(time: FloatArray, values: FloatArray) -> IntArray:
    """Return the first values after jumps that are larger than bends and noise of the signal."""
    steps = np.diff(values)
    if steps.size < SPLINE:
        return np.zeros(0, dtype=np.int64)
    # White noise of variance 1 has second differences of variance 6, and steps of variance 2.
    noise = NORMAL * float(np.median(np.abs(np.diff(steps)))) / np.sqrt(6.0)
    found = jumps(steps / np.diff(time))
    result: IntArray = found[np.abs(steps[found - 1]) > RARE_GAP * np.sqrt(2.0) * noise]
    return result


def sample_blocks(
    grid: EvenGrid, origin: int, position: list[FloatArray], force: list[FloatArray]
) -> Iterator[SampleBlock]:
    """Yield a block for each span, from its position [m] and force [N].

    ``origin`` is the stamp of the times' zero [ns since the epoch].
    """
    for span, u, f in zip(grid.spans, position, force, strict=True):
        yield SampleBlock(
            stamp=origin + round(span.times[0] * NANOSECONDS),
            sequence=span.sequence,
            sample_period=grid.period,
            position=u,
            force=f,
            command=np.broadcast_to(np.nan, u.size),  # one number, not as many as samples
        )


def longest_step(steps: FloatArray, usual: float | FloatArray) -> float:
    """Return the longest step in time that may be jitter, and no gap [periods].

    Parameters
    ----------
    steps : array, shape (n,)
        Steps in time [s]; by how much they are off whole periods tells how much they jitter.
    usual : float, or array of shape (n,)
        The period [s], or that about each step.
    """
    jitter = NORMAL * float(np.median(_off(steps, usual) / usual))
    return max(GAP, 1.0 + RARE_GAP * jitter)


def _check(time: FloatArray, where: str, place: Callable[[int], str]) -> None:
    if time.size < 2:
        raise RecordingError(f"{where} has {time.size} samples; give at least two")
    for wrong, what in (
        (~np.isfinite(time), "no time"),
        (np.concatenate([[False], np.diff(time) <= 0.0]), "a time not later than that before"),
    ):
        if wrong.any():
            row = int(np.argmax(wrong))
            raise RecordingError(
                f"{where}, {place(row)} (t = {time[row]:g} s): {what}; correct it, or give "
                "`sample_rate` and leave the times out"
            )


def _refuse_irregular(steps: FloatArray, usual: float | FloatArray, where: str) -> None:
    """Refuse times that follow no rate; where samples are missing they still do."""
    in_step = (steps > GAP * usual) & (_off(steps, usual) < WHOLE * usual)
    off = np.mean((np.abs(_ratio(steps, usual, 1.0)) > 0.5) & ~in_step)
    if off > IRREGULAR_SHARE:
        raise RecordingError(
            f"{where} is sampled irregularly: {100.0 * off:.0f} % of its steps in time are off by "
            f"more than half of the usual {np.median(usual):g} s; record at an even rate, or give "
            "`sample_rate` if the samples were in fact taken evenly"
        )


def _ratio(steps: FloatArray, period: float | FloatArray, less: float) -> FloatArray:
    """Return steps in periods, less a number of these, in memory of their own size."""
    ratio = steps / period
    ratio -= less
    return ratio


def _off(steps: FloatArray, period: float | FloatArray) -> FloatArray:
    """Return by how much steps differ from whole periods [s]."""
    off = steps / period
    off -= np.rint(off)
    off *= period
    return np.abs(off, out=off)


def _parts(joined: np.ndarray) -> list[slice]:
    """Return the rows between steps that do not join two."""
    bounds = [0, *(np.flatnonzero(~joined) + 1), joined.size + 1]
    return [slice(first, stop) for first, stop in pairwise(bounds)]


def _period(time: FloatArray, rows: list[slice]) -> float:
    """Return the least-squares slope of the times against their numbers, over all parts [s]."""
    along, across = 0.0, 0.0
    for part in rows:
        own = time[part]
        numbers = np.arange(own.size) - (own.size - 1) / 2.0
        along += float(numbers @ own) - own[0] * float(numbers.sum())
        across += own.size * (own.size**2 - 1.0) / 12.0
    return along / across


def _jitter(time: FloatArray, period: float) -> float:
    """Return the largest deviation from a grid of this period [s]."""
    least, most = np.inf, -np.inf
    for first in range(0, time.size, SAMPLES_TOGETHER):
        own = time[first : first + SAMPLES_TOGETHER]
        deviations = own - time[0] - period * np.arange(first, first + own.size)
        least, most = min(least, float(deviations.min())), max(most, float(deviations.max()))
    return (most - least) / 2.0


def _measure_rounding(time: FloatArray) -> float:
    """Return by how much rounding to the digits that the times have moves them at most [s]."""
    largest = max(abs(float(time.max())), abs(float(time.min())))
    precision = 4.0 * np.spacing(largest)
    pieces = [
        time[first : first + SAMPLES_TOGETHER] for first in range(0, time.size, SAMPLES_TOGETHER)
    ]
    for digits in range(10):
        if all(np.abs(own - np.round(own, digits)).max() <= precision for own in pieces):
            return float(0.75 * 10.0**-digits + precision)
    return float(precision)


def _spans(time: FloatArray, rows: list[slice], period: float, even: bool) -> Iterator[Span]:
    free = 0
    for part in rows:
        own = time[part]
        sequence = max(free, round((own[0] - time[0]) / period))
        places = _places(own, period) if even else np.empty(0, dtype=np.int64)
        if even:
            whole = places[-1] + 1 == own.size
            times = own if whole else np.interp(np.arange(places[-1] + 1), places, own)
        else:
            count = int((own[-1] - own[0]) / period + 1e-6) + 1
            times = np.minimum(own[0] + period * np.arange(count), own[-1])
        yield Span(part, sequence, times, places)
        free = sequence + times.size


def _places(own: FloatArray, period: float) -> IntArray:
    """Return at which period after the first each time lies."""
    counts = np.diff(own)
    counts /= period
    np.rint(counts, out=counts)
    np.maximum(counts, 1.0, out=counts)
    places = np.zeros(own.size, dtype=np.int64)
    np.cumsum(counts, out=places[1:], dtype=np.int64)
    return places


def consecutive(count: int, period: float) -> EvenGrid:
    """Return the grid of samples one after the other, the first at time 0."""
    times = np.arange(count, dtype=float) * period
    whole = Span(slice(0, count), 0, times, np.arange(count))
    return EvenGrid(period, (whole,), even=True, notes=())
