"""A fit whose values need a finer simulation: shorter steps, or a smoother course of the input.

Contents: how much finer.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from tissue_probe.diagnosis.evidence.posterior import RIVAL
from tissue_probe.diagnosis.fitting.accuracy import (
    DEGREES,
    MOST_FINER_PARTS,
    UNSEEN,
    doubt,
    in_more_parts,
    smoother,
)
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.refit_samples import refit_measurements
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement

#: Of the rule of integration: halving the step divides its error by 16.
RULE_ORDER = 4


def finer(fit: Fit, instrument: Instrument) -> list[Measurement] | None:
    """Return the measurements of a fit, to be simulated as finely as its values need it.

    None where that is as finely as they are, or where the samples are too few for it.
    """
    told = doubt(fit, instrument)
    parts = min(math.ceil((told.step / UNSEEN) ** (1.0 / RULE_ORDER)), MOST_FINER_PARTS)
    refined = [in_more_parts(each, max(parts, 1)) for each in fit.measurements]
    if told.course > UNSEEN:
        along = [smoother(each) or each for each in refined]
        known = all(each.fineness.degree < DEGREES[-1] for each in along)
        refined = along if known and not _is_worse(along, refined, fit, instrument) else refined
    pairs = zip(refined, fit.measurements, strict=True)
    return refined if any(new.fineness != old.fineness for new, old in pairs) else None


def _is_worse(
    along: Sequence[Measurement],
    before: Sequence[Measurement],
    fit: Fit,
    instrument: Instrument,
) -> bool:
    """Whether measurements speak against a smoother course: it has corners."""
    smooth, other = (refit_measurements(fit, each, instrument) for each in (along, before))
    return smooth is None or (other is not None and smooth.bic > other.bic + 2.0 * RIVAL)
