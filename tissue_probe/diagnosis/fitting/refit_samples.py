"""A fitted model on samples that are observed in another way.

Contents: the search from where it ended before.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.search import search
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement


def refit_measurements(
    fit: Fit,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    held: Mapping[str, float] | None = None,
) -> Fit | None:
    """Fit a model to other measurements of the same runs; None where that diverges.

    Parameters
    ----------
    fit : Fit
        Where the search begins.
    measurements : sequence of Measurement
        As many as those of the fit.
    instrument, held
        As for ``Problem``.
    """
    problem = Problem(fit.composition, measurements, instrument, held)
    return search(problem, fit.values, fit.starts)
