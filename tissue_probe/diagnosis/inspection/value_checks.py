"""Values that no sensor measured: cut off at a limit, repeated, or far from their neighbours.

What belongs here: what is said of them. What does not: finding them (``repeats``).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.ndimage import maximum_filter1d, percentile_filter

from tissue_probe.diagnosis.inspection.channel import Channel
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.inspection.repeats import Runs, clipped, stuck
from tissue_probe.signals import FloatArray, IntArray

#: Share of a cubic through the neighbours that each of them has, and how far off stands alone.
_CUBIC = np.array([-1.0, 4.0, 0.0, 4.0, -1.0]) / 6.0
_ALONE, _LARGE = 12.0, 0.03  # times what is usual around it; times the rms of all
_AROUND = 101  # samples
_COUNTS = 3.0  # steps of an encoder by which no reading of it is off alone
#: What a spike's neighbours are off lies between these shares of what it is off.
_BEND, _STEP = 0.55, 0.8
_HELD = 0.5  # share of samples in runs from which a channel is slower than it is sampled


def check_values(position: Channel, force: Channel, known: np.ndarray) -> Iterator[Finding]:
    """Yield ``adc_saturation`` of the force, ``stuck_samples`` and spikes of either channel.

    Parameters
    ----------
    position, force : Channel
        Moving both.
    known : array of bool, shape (n,)
        Which samples were measured, not bridged.
    """
    repeated = {
        channel.name: _known(stuck(channel, other), known)
        for channel, other in ((position, force), (force, position))
    }
    limits = [
        (limit, there)
        for limit, there in clipped(force, position)
        if not _is_one_of_many(there, repeated["force"])
    ]
    if limits:
        yield _saturation(force, limits)
    at_limits = np.concatenate([np.empty(0), *(there.first for _, there in limits)])
    held = np.zeros(known.size, dtype=bool)
    for channel in (position, force):
        found = repeated[channel.name]
        for first, stop in found.spans():
            held[first:stop] = True
        if channel is force:
            found = found[~np.isin(found.first, at_limits)]
        if found.first.size:
            yield _stuck(channel, found)
    for _, there in limits:
        for first, stop in there.spans():
            held[first:stop] = True
    # Where a channel begins to move, or is held and let go, the force turns as sharply.
    excused = maximum_filter1d(held | _alone(position.values, 0.0), 7)
    alone = np.flatnonzero(_alone(force.values, _LARGE) & ~excused & known)
    if alone.size:
        yield _spikes("spikes", "forces", alone, known.size)
    excused = maximum_filter1d(held, 7)
    alone = _alone(position.values, _LARGE, _COUNTS * position.step)
    alone = np.flatnonzero(alone & ~excused & known)
    if alone.size:
        yield _spikes("position_spikes", "positions", alone, known.size)


def _alone(values: FloatArray, large: float, least: float = 0.0) -> np.ndarray:
    """Tell the samples that stand out of the cubic through two neighbours to either side.

    As far as no noise does, as ``least``, as ``large`` a share of their rms, and with both
    neighbours thrown off by two thirds as much, as by a spike: a step throws one off as far, a bend
    both by half.
    """
    off = np.abs(values - np.convolve(values, _CUBIC, mode="same"))
    off[:2] = off[-2:] = 0.0
    usual = np.maximum(np.median(off) / 0.67, percentile_filter(off, 75, _AROUND) / 1.15)
    near = np.stack([np.roll(off, 1), np.roll(off, -1)])
    shaped = ((near > _BEND * off) & (near < _STEP * off)).all(axis=0)
    return shaped & (off > _ALONE * usual) & (off > max(large * np.std(values), least))


def _spikes(name: str, values: str, alone: IntArray, count: int) -> Finding:
    return Finding(
        name,
        f"{alone.size} of {count} {values} stand alone, far from both neighbours, the first at "
        f"sample {alone[0]}: disturbances of the electronics, left out; look for a loose contact "
        "or a switching load.",
        spans=tuple((int(index), int(index) + 1) for index in alone),
    )


def _known(found: Runs, known: np.ndarray) -> Runs:
    """Leave out runs that bridging made."""
    return found[np.array([known[first:stop].all() for first, stop in found.spans()], dtype=bool)]


def _is_one_of_many(there: Runs, repeated: Runs) -> bool:
    """Whether a limit was held once only, and other values were held too: then it was stuck."""
    return there.first.size == 1 and not np.isin(repeated.first, there.first).all()


def _saturation(force: Channel, limits: list[tuple[float, Runs]]) -> Finding:
    spans = tuple(sorted(span for _, there in limits for span in there.spans()))
    samples = sum(stop - first for first, stop in spans)
    values = " and ".join(f"{limit:.5g}" for limit, _ in limits)
    share = 100.0 * samples / force.values.size
    return Finding(
        "adc_saturation",
        f"The force stands still at {values} N, its extreme, {len(spans)} times ({share:.2g} % of "
        "the samples): the converter or amplifier was at its limit; lower the amplitude or choose "
        "a larger range, and record again.",
        spans=spans,
    )


def _stuck(channel: Channel, found: Runs) -> Finding:
    samples = int(found.length.sum())
    usual = int(np.median(found.length))
    if samples > _HELD * channel.values.size:
        said = (
            f"The {channel.name} repeats each value about {usual} times: it was measured at a "
            f"lower rate than it was recorded; record it, or resample both channels, at 1/{usual} "
            "of the rate."
        )
    else:
        said = (
            f"The {channel.name} is stuck {found.first.size} times, for {found.length.min()} to "
            f"{found.length.max()} samples, {samples} in all: look for lost samples between sensor "
            "and recorder, and leave these out."
        )
    return Finding("stuck_samples", said, spans=found.spans())
