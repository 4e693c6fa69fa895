"""How finely a model is simulated whose values are held: until its error changes no more.

Contents: the measurements of such a model, to be simulated more finely.

A fit asks by how much its values would change. Values that are held do not change: of these the
output is asked, as near a sharp resonance a simulation may be off by more than the model.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from tissue_probe.diagnosis.fitting.accuracy import in_more_parts, smoother
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.noise import FAINT_NOISE
from tissue_probe.diagnosis.revisions.fineness import RULE_ORDER


def refine_held(
    fit: Fit, instrument: Instrument, carry: Callable[[Sequence[Measurement]], Fit | None]
) -> Fit:
    """Return a model, its values held, on its measurements as finely simulated as its error asks.

    Parameters
    ----------
    fit : Fit
        The model on its measurements, simulated as they say.
    instrument : Instrument
        Constants of the rig with their tolerances.
    carry : callable
        From measurements to the same model on them; None where it diverges.
    """
    while finer := _in_shorter_steps(fit, instrument):
        again = carry(finer)
        if again is None:
            break
        fit = again
    while finer := _along_smoother_course(fit, instrument):
        again = carry(finer)
        # An input that has corners has no smoother course: the model does worse along it.
        if again is None or again.cost > fit.cost:
            break
        fit = again
    return fit


def _in_shorter_steps(fit: Fit, instrument: Instrument) -> list[Measurement] | None:
    """Return the measurements of a fit in shorter steps; None where its output hardly moves."""
    kernel = fit.composition.kernel
    if kernel.linear or not kernel.states:
        return None
    off = _change(fit, [in_more_parts(each) for each in fit.measurements], instrument)
    if off <= 1.0:
        return None
    times = math.ceil(off ** (1.0 / RULE_ORDER)) + 1
    return _other_than(fit, [in_more_parts(each, times) for each in fit.measurements])


def _along_smoother_course(fit: Fit, instrument: Instrument) -> list[Measurement] | None:
    """Return them along a smoother course of the input; None where the output hardly moves."""
    along = [smoother(each) or each for each in fit.measurements]
    return _other_than(fit, along) if _change(fit, along, instrument) > 1.0 else None


def _other_than(fit: Fit, refined: list[Measurement]) -> list[Measurement] | None:
    """Return refined measurements; None where they are as fine as those of a fit."""
    pairs = zip(refined, fit.measurements, strict=True)
    return refined if any(new.fineness != old.fineness for new, old in pairs) else None


def _change(fit: Fit, finer: Sequence[Measurement], instrument: Instrument) -> float:
    """Return by how much the output moves, over the change that is faint beside the residual.

    A change of ``FAINT_NOISE`` of the residual alters its size by half a percent.
    """
    problem, moved, left = Problem(fit.composition, finer, instrument), 0.0, 0.0
    for index, (measurement, before) in enumerate(zip(finer, fit.predicted, strict=True)):
        if measurement.fineness == fit.measurements[index].fineness:
            continue
        driven, start = measurement.input_values, fit.starts[index]
        off = problem.response(index, driven, fit.values, start).output - before
        moved += float(np.sum(off[measurement.counted] ** 2))
        left += float(np.sum(fit.residuals[index][measurement.counted] ** 2))
    if not 0.0 < moved < math.inf:
        return 0.0
    return math.sqrt(moved / max(left, np.finfo(float).tiny)) / FAINT_NOISE
