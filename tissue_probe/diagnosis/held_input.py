"""Whether an input is held between its samples: a command that a converter puts out.

What belongs here: telling it from a smooth one. What does not: its course (``physics.response``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.ranking.candidates import fit_base
from tissue_probe.diagnosis.ranking.rules import TIE
from tissue_probe.physics.composition import Composition

#: Share of its range by which the spline through a force overshoots a jump: half of the tenth by
#: which it overshoots a single step.
OVERSHOT = 0.05
HELD = (
    "The force has no noise, and jumps: it is taken for a command that a converter puts out, and "
    "that stays as each sample has it until the next."
)


def with_input(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    begin_at: Mapping[str, float] | None = None,
) -> tuple[list[Measurement], list[Finding]]:
    """Return measurements with the course of their input by which the model fits better.

    Only of a force that has no noise and jumps: what was measured is no command, and on a smooth
    course being held is a delay of half a sample, which is an effect of its own.
    """
    smooth = list(measurements)
    if not all(each.is_commanded for each in smooth) or not any(map(_jumps, smooth)):
        return smooth, []
    held = [replace(each, held=True) for each in smooth]
    fits = [fit_base(composition, each, instrument, begin_at) for each in (smooth, held)]
    if fits[1].bic - fits[0].bic > TIE:
        return smooth, []
    return held, [Finding("held", HELD)]


def _jumps(measurement: Measurement) -> bool:
    """Whether a smooth course through the samples of the force would overshoot them."""
    from scipy.interpolate import CubicSpline  # only where a force drives that has no noise

    force = measurement.force
    between = CubicSpline(np.arange(force.size), force)(np.arange(force.size - 1) + 0.5)
    beyond = max(float(between.max() - force.max()), float(force.min() - between.min()))
    return beyond > OVERSHOT * float(np.ptp(force))
