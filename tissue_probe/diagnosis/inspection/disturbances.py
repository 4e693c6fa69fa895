"""Values far from their neighbours for a few samples: electronics make them, and no motion.

Contents: finding them in one channel.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import percentile_filter

from tissue_probe.call_cache import for_a_call
from tissue_probe.signals import BoolArray, FloatArray, spans_of

#: Share of a cubic through the neighbours that each of them has.
_CUBIC = np.array([-1.0, 4.0, 0.0, 4.0, -1.0]) / 6.0
#: A value stands out that is off by so many times the usual deviation around it.
_LONE_DEVIATIONS = 12.0
_AROUND = 101  # samples
#: The neighbours of a single one are off by shares of its deviation between these.
_BEND, _STEP = 0.55, 0.8
#: Samples in a row at the most, and to either side of them those that a cubic follows.
LONGEST, _SIDE = 8, 4
#: Those to either side are off by less than this many times the usual deviation, and this share.
_QUIET, _SHARE = 3.0, 0.15
#: Both ends of a row are off by this share of it, to one side: at a bend less, at a step to both.
_ABRUPT = 0.6
#: A row is a bend if straight lines from both sides leave less than this share of it. They leave
#: nothing of a bend, and all of a row that was moved away from a curve: half is midway.
_BENT = 0.5


def find_disturbed(
    values: FloatArray, large: float, least: float, excused: BoolArray, turning: BoolArray
) -> BoolArray:
    """Tell the samples that stand out of the curve through those before and after.

    Parameters
    ----------
    values : array, shape (n,)
        One channel, finite.
    large, least : float
        Share of the rms, and size, that an outstanding value exceeds.
    excused : array of bool, shape (n,)
        Which samples are known to be of another kind.
    turning : array of bool, shape (n,)
        Where the other channel turns sharply: a longer disturbance there comes from it.
    """
    large = max(large * float(np.std(values)), least)
    single = find_lone_samples(values, large) & ~excused
    found = single.copy()
    for first, stop in _rows(bridge_disturbed(values, ~single), large):
        if not (excused | turning)[first:stop].any():
            found[first:stop] = True
    return found


def find_lone_samples(values: FloatArray, large: float) -> BoolArray:
    """Tell the samples that stand out of the cubic through two neighbours to either side.

    As far as no noise does, more than ``large``, and with both neighbours thrown off by two thirds
    as much, as by a spike: a step throws one off as far, a bend both by half.
    """
    off = _off(values)
    near = -np.stack([np.roll(off, 1), np.roll(off, -1)]) * np.sign(off)
    off = np.abs(off)
    shaped = ((near > _BEND * off) & (near < _STEP * off)).all(axis=0)
    return shaped & turning_sharply(values) & (off > large)


def turning_sharply(values: FloatArray) -> BoolArray:
    """Tell the samples that are off the cubic through two neighbours to either side."""
    off = np.abs(_off(values))
    usual = np.maximum(np.median(off) / 0.67, percentile_filter(off, 75, _AROUND) / 1.15)
    sharp: BoolArray = off > _LONE_DEVIATIONS * usual
    return sharp


def _off(values: FloatArray) -> FloatArray:
    off = values - np.convolve(values, _CUBIC, mode="same")
    off[:2] = off[-2:] = 0.0
    return off


def bridge_disturbed(values: FloatArray, steady: BoolArray) -> FloatArray:
    """Replace values that are not steady by those of a curve through the others."""
    number = np.arange(values.size)
    if steady.all():
        return values
    from scipy.interpolate import CubicSpline  # only where something stands out

    return np.where(steady, values, CubicSpline(number[steady], values[steady])(number))


def _rows(values: FloatArray, large: float) -> list[tuple[int, int]]:
    """Return (first, stop) of two and more samples that stand out together.

    A cubic follows those to either side, and not them, which leave it at once and to one side. Of
    several that overlap the one stays that explains most.
    """
    found: list[tuple[float, int, int]] = []
    for length in range(2, LONGEST + 1):
        if values.size < _AROUND + length:
            break
        windows = np.lib.stride_tricks.sliding_window_view(values, length + 2 * _SIDE)
        departures = _departures(length)
        # A copy in one piece, which is multiplied several times faster than the view.
        row = np.ascontiguousarray(windows) @ departures[_SIDE:-_SIDE].T
        inside = np.sqrt(np.mean(row**2, axis=1))
        far = (inside > large) & (inside > _LONE_DEVIATIONS * np.median(inside) / 0.93)
        if not far.any():
            continue  # the most records
        beside = np.abs(windows @ np.delete(departures, np.s_[_SIDE:-_SIDE], axis=0).T).max(axis=1)
        ends = (row[:, [0, -1]] * np.sign(row[:, :1])).min(axis=1)
        clear = far & (beside < _SHARE * inside) & (ends > _ABRUPT * inside)
        for place in map(int, np.flatnonzero(clear)):
            usual, quiet = (_usual(each, place) for each in (inside, beside))
            stands_out = inside[place] > _LONE_DEVIATIONS * usual and beside[place] < _QUIET * quiet
            if stands_out and not _is_bend(windows[place], inside[place]):
                explained = length * (inside[place] ** 2 - (0.4 * _LONE_DEVIATIONS * usual) ** 2)
                found.append((explained, place + _SIDE, place + _SIDE + length))
    taken = np.zeros(values.size, dtype=bool)
    for _, first, stop in sorted(found, reverse=True):
        if not taken[max(first - _SIDE, 0) : stop + _SIDE].any():
            taken[first:stop] = True
    return list(spans_of(taken))


def _is_bend(window: FloatArray, size: float) -> bool:
    """Whether a row goes on straight from one side and, from some sample on, from the other.

    Such is a corner of a motion that is over within few samples: ``size`` is how far the row stands
    out of one curve through both sides.
    """
    length = window.size - 2 * _SIDE
    apart = np.arange(length)
    left, right = window[:_SIDE], window[-_SIDE:]
    went, goes = (float(np.diff(each).mean()) for each in (left, right))
    off_left = window[_SIDE:-_SIDE] - (left.mean() + went * (apart + 0.5 * (_SIDE + 1)))
    back = length - 1 - apart + 0.5 * (_SIDE + 1)
    off_right = window[_SIDE:-_SIDE] - (right.mean() - goes * back)
    splits = (np.concatenate([off_left[:at], off_right[at:]]) for at in range(length + 1))
    return min(float(np.sqrt(np.mean(each**2))) for each in splits) < _BENT * size


def _usual(off: FloatArray, place: int) -> float:
    """Return the usual deviation around a place."""
    around = off[max(place - _AROUND, 0) : place + _AROUND]
    return float(max(np.median(off), np.percentile(around, 65)) / 0.93)


@for_a_call(32)
def _departures(length: int) -> FloatArray:
    """Return the matrix of departures from a cubic through the samples to either side of a row."""
    place = np.linspace(-1.0, 1.0, length + 2 * _SIDE)
    powers = np.vander(place, 4)
    beside = np.abs(np.arange(place.size) - (place.size - 1) / 2) > (length - 1) / 2
    matrix = np.eye(place.size)
    matrix[:, beside] -= powers @ np.linalg.pinv(powers[beside])
    return matrix
