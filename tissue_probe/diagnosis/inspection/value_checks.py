"""Values that no sensor measured: cut off at a limit, repeated, or far from their neighbours.

Contents: the findings on them.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.ndimage import maximum_filter1d

from tissue_probe.diagnosis.inspection.channel import InspectedChannel
from tissue_probe.diagnosis.inspection.disturbances import (
    find_disturbed,
    find_lone_samples,
    turning_sharply,
)
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.inspection.repeats import EqualRuns, find_clipped, find_stuck
from tissue_probe.signals import BoolArray, spans_of

_LARGE = 0.03  # share of the rms that a value exceeds which stands alone
_FOLLOWING = 21  # samples about a sharp turn of the position in which the force follows it
_COUNTS = 3.0  # steps of an encoder by which no reading of it is off alone
_HELD = 0.5  # share of samples in runs from which a channel is slower than it is sampled


def check_values(
    position: InspectedChannel, force: InspectedChannel, known: np.ndarray
) -> Iterator[Finding]:
    """Yield ``adc_saturation`` of the force, ``stuck_samples`` and spikes of either channel.

    Parameters
    ----------
    position, force : Channel
        Moving both.
    known : array of bool, shape (n,)
        Which samples were measured, not bridged.
    """
    repeated = {
        channel.name: _leave_out_bridged(find_stuck(channel, other), known)
        for channel, other in ((position, force), (force, position))
    }
    limits = [
        (limit, there)
        for limit, there in find_clipped(force, position)
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
            yield _report_stuck(channel, found)
    for _, there in limits:
        for first, stop in there.spans():
            held[first:stop] = True
    # Where a channel begins to move, or is held and let go, the force turns as sharply.
    excused = maximum_filter1d(held | find_lone_samples(position.values, 0.0), 7)
    turning = maximum_filter1d(turning_sharply(position.values), _FOLLOWING)
    off = find_disturbed(force.values, _LARGE, 0.0, excused, turning) & known
    if off.any():
        yield _spikes("spikes", "forces", off)
    excused = maximum_filter1d(held, 7)
    off = find_disturbed(position.values, _LARGE, _COUNTS * position.step, excused, excused) & known
    if off.any():
        yield _spikes("position_spikes", "positions", off)


def _spikes(name: str, values: str, off: BoolArray) -> Finding:
    spans = tuple(spans_of(off))
    return Finding(
        name,
        f"{np.count_nonzero(off)} of {off.size} {values} stand alone, far from those before and "
        f"after, the first at sample {spans[0][0]}: disturbances of the electronics, left out of "
        "the fit or, where they drive the model, bridged; look for a loose contact or a switching "
        "load.",
        spans=spans,
    )


def _leave_out_bridged(found: EqualRuns, known: np.ndarray) -> EqualRuns:
    """Leave out runs that bridging made."""
    return found[np.array([known[first:stop].all() for first, stop in found.spans()], dtype=bool)]


def _is_one_of_many(there: EqualRuns, repeated: EqualRuns) -> bool:
    """Whether a limit was held once only, and other values were held too: then it was stuck."""
    return there.first.size == 1 and not np.isin(repeated.first, there.first).all()


def _saturation(force: InspectedChannel, limits: list[tuple[float, EqualRuns]]) -> Finding:
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
        channel=force.name,
    )


def _report_stuck(channel: InspectedChannel, found: EqualRuns) -> Finding:
    samples = int(found.length.sum())
    usual = int(np.median(found.length))
    # A lower rate shows in many values; a single one that is held is a channel that got stuck.
    if samples > _HELD * channel.values.size and found.first.size > 1:
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
    return Finding("stuck_samples", said, spans=found.spans(), channel=channel.name)
