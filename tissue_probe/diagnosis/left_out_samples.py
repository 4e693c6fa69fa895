"""Which samples a diagnosis left out of its fits, and why.

Contents: the sentences.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from tissue_probe.diagnosis.fitting.corners import corners_that_count
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.undecided_samples import find_undecided
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.signals import BoolArray, spans_of

OUTLIERS = (
    "{told}{count} samples in short rows, the first at sample {first}, are far from the residual "
    "of those before and after: disturbances, left out of the fit; look for a loose contact "
    "or a switching load."
)
CORNERS = (
    "{told}{count} samples beside corners of the {input} that drives, the first at sample {first}, "
    "are left out of the fit: how it goes on between two samples is not known there. Sample "
    "faster, or round off the corners, to learn from them."
)
UNDECIDED = (
    "{told}{count} samples, the first at sample {first}, are left out of the fit: the noise of the "
    "{input} hides there which way the tip moves, and friction turns with it. A finer encoder, or "
    "a quicker motion, tells more."
)


def report_left_out(
    given: Sequence[Measurement], final: Fit, instrument: Instrument
) -> Iterator[Finding]:
    """Yield ``corners``, ``undecided`` and ``outliers`` for each measurement that has such samples.

    Parameters
    ----------
    given : sequence of Measurement
        As they were inspected.
    final : Fit
        The last model: without these samples.
    instrument : Instrument
        Constants of the rig with their tolerances.
    """
    hidden = find_undecided(final, instrument)
    for one, rest, unknown in zip(given, final.measurements, hidden, strict=True):
        missing = one.used & ~rest.used
        # A noisy motion is told anew on the way, and its corners with it.
        near = (corners_that_count(each, final.composition.rig) for each in (one, rest))
        turns = missing & np.logical_or(*near)
        unknown = missing & unknown & ~turns
        others = missing & ~turns & ~unknown
        yield from _report_left_out("corners", CORNERS, one, turns)
        yield from _report_left_out("undecided", UNDECIDED, one, unknown)
        yield from _report_left_out("outliers", OUTLIERS, one, others)


def _report_left_out(
    name: str, sentence: str, of: Measurement, samples: BoolArray
) -> Iterator[Finding]:
    if not samples.any():
        return
    spans, told = tuple(spans_of(samples)), f"{of.source}: " if of.source else ""
    filled = sentence.format(
        told=told, count=int(samples.sum()), first=spans[0][0], input=of.input.name
    )
    yield Finding(name, filled, spans=spans)
