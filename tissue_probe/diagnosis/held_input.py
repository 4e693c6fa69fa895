"""Whether an input is held between its samples: a command that a converter puts out.

What belongs here: telling it from a smooth one. What does not: its course (``physics.response``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.evidence.adequacy import explained
from tissue_probe.diagnosis.evidence.posterior import RIVAL
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates, refit
from tissue_probe.errors import MeasurementError
from tissue_probe.physics.composition import Composition
from tissue_probe.quantities import FORCE

#: Share of its range by which the spline through a force overshoots a jump: half of the tenth by
#: which it overshoots a single step.
OVERSHOT = 0.05
DELAY = "channel_delay"
HELD = (
    "The model follows the force better as a command that a converter puts out, and that stays as "
    "each sample has it until the next: it is taken for one (`course`)."
)
NOT_DRIVEN = (
    "`course`: the position drives a {}, and it is measured: it moves on between two samples; "
    "leave it out, or give rig force_driven if a force drives"
)


def with_input(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    begin_at: Mapping[str, float] | None = None,
) -> tuple[list[Measurement], list[Finding]]:
    """Return measurements with the course of their input by which the model fits better.

    Only of a force, and where nobody has said it. A force that jumps and has no noise is a command,
    and held unless the smooth course is likelier by much; any other the other way round. On a
    smooth course being held is a delay of half a sample, which is an effect of its own: held is
    told of it only where that effect does no better, and the model leaves noise only.

    Raises
    ------
    MeasurementError
        If a position that drives is said to be held.
    """
    smooth = list(measurements)
    if composition.input is not FORCE:
        if any(each.held for each in smooth):
            raise MeasurementError(NOT_DRIVEN.format(composition.rig))
        return smooth, []
    if any(each.held is not None for each in smooth):
        return smooth, []
    held = [replace(each, held=True) for each in smooth]
    one, other = (fit_base(composition, each, instrument, begin_at) for each in (smooth, held))
    jumps = any(map(_jumps, smooth))
    commanded = jumps and all(each.is_commanded for each in smooth)
    if other.bic - one.bic > (2.0 * RIVAL if commanded else -2.0 * RIVAL):
        return smooth, []
    delayed = [] if jumps else _delayed(one, instrument)
    if not jumps and not (explained(other) and _is_as_good(other, delayed)):
        return smooth, []
    return held, [Finding("held", HELD)]


def is_held(final: Fit, instrument: Instrument) -> list[Measurement]:
    """Return the measurements of a fit with a delay as held, where that does as well without it.

    Beside all that the model lacked at first it can be told.
    """
    known = any(each.held is not None for each in final.measurements)
    if final.composition.input is not FORCE or known or DELAY not in final.composition.names:
        return []
    held = [replace(each, held=True) for each in final.measurements]
    fit = refit(final, final.composition.without(DELAY), instrument, held)
    return held if fit is not None and _is_as_good(fit, [final]) else []


def _is_as_good(held: Fit, delayed: Sequence[Fit]) -> bool:
    return all(held.bic < fit.bic + 2.0 * RIVAL for fit in delayed)


def _delayed(fit: Fit, instrument: Instrument) -> list[Fit]:
    """Return the model with a delay between its channels, if that can be fitted."""
    from tissue_probe.physics.effects import EFFECTS
    from tissue_probe.physics.resized import sized

    return fit_candidates(fit, [sized(EFFECTS[DELAY], fit.composition.scale)], instrument)


def _jumps(measurement: Measurement) -> bool:
    """Whether a smooth course through the samples of the force would overshoot them."""
    from scipy.interpolate import CubicSpline  # only where a force drives that has no noise

    force = measurement.force
    between = CubicSpline(np.arange(force.size), force)(np.arange(force.size - 1) + 0.5)
    beyond = max(float(between.max() - force.max()), float(force.min() - between.min()))
    return beyond > OVERSHOT * float(np.ptp(force))
