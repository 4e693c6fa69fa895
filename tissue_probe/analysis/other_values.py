"""The prediction of a fitted model at other values than those found.

Contents: that alone; it is asked for while somebody moves a slider, so nothing is fitted.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.runs import Runs
from tissue_probe.errors import ParameterError
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from tissue_probe.diagnosis.fitting.fit import Fit
    from tissue_probe.diagnosis.observation.instrument import Instrument


def predict_output(
    fit: Fit, instrument: Instrument, values: Mapping[str, float], index: int
) -> FloatArray:
    """Return a model's prediction of a measurement if some values were others.

    See ``ComparisonResult.predict``.
    """
    problem = Problem(fit.composition, [fit.measurements[index]], instrument)
    names = _names_in(fit, instrument, index)
    whole = np.array([values.get(name, fit.named()[name]) for name in names])
    _check(fit, names, whole, values)
    found = np.array([fit.named()[name] for name in names])
    (before,), (after,) = problem.begin(found), problem.begin(whole)
    start = fit.starts[index] + after.mean - before.mean
    with np.errstate(all="ignore"):
        measured = fit.measurements[index].input_values
        return problem.response(0, measured, whole, start).output


def _names_in(fit: Fit, instrument: Instrument, index: int) -> list[str]:
    """Return the names of the values that a measurement's run has, in the kernel's order."""
    runs = Runs(fit.composition, fit.measurements, instrument.of_run)
    return [runs.names[place] for place in runs.places[index]]


def _check(fit: Fit, names: list[str], whole: FloatArray, values: Mapping[str, float]) -> None:
    """Refuse values that the model has not, or that are out of its bounds."""
    if unknown := [name for name in values if name not in fit.names]:
        raise ParameterError(
            f"`values` {unknown[0]}: the model has no such value; it has {', '.join(fit.names)}"
        )
    entries = {entry.name: entry for entry in fit.entries}
    for name, value in zip(names, whole, strict=True):
        entry = entries[name]
        if name in values and not entry.lower <= value <= entry.upper:
            raise ParameterError(
                f"`values` {name}={value:g}: it lies from {entry.lower:g} to {entry.upper:g} "
                f"{entry.unit}; give one that does"
            )
