"""A line at a multiple of a sine's frequency: any nonlinear cause leaves one.

Contents: whether one line explains the same residual as an effect.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.diagnosis.evidence.line import LINE_FREQUENCY_NAME, sine_of
from tissue_probe.diagnosis.evidence.posterior import LINE, evidence
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.search import promise, search
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.ranking.starts import begin_states
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect
    from tissue_probe.physics.scale import Scale

#: The highest multiple of the drive's frequency that is tried.
HIGHEST_MULTIPLE = 5

_Begun = tuple[Problem, FloatArray, list[FloatArray]]

#: Names of hum's effect and parameters.
HUM, SINE, COSINE = "mains_hum", "hum_sine", "hum_cosine"


@cache
def _line(scale: Scale) -> Effect:
    """Return an effect with the equations of hum, at any frequency."""
    from tissue_probe.physics.effect_scale import resize_effect
    from tissue_probe.physics.effects import EFFECTS

    hum = EFFECTS[HUM]
    parameters = (
        replace(each, lower=0.0, upper=1e6) if each.name == LINE_FREQUENCY_NAME else each
        for each in hum.parameters
    )
    return resize_effect(replace(hum, name="harmonic", parameters=tuple(parameters)), scale)


def better_harmonic(base: Fit, final: Fit, instrument: Instrument) -> float | None:
    """Return the multiple of a sine's frequency at which one line explains more than effects do.

    A lightly damped mode, tuned to such a multiple by the fit, makes the line that stiffening of
    another form leaves. Beside the line's sine and cosine the frequency to which it is tuned counts
    as one more value.

    Parameters
    ----------
    base : Fit
        The model without effects.
    final : Fit
        The same with effects.
    instrument : Instrument
        Constants of the rig with their tolerances.

    Returns
    -------
    float or None
        Frequency [Hz]; None where no line is better, the drive is no sine, or there are several
        measurements: then effects have more to explain than a line.
    """
    line = _line(base.composition.scale)
    taken = HUM in final.composition.names or not base.composition.rig.admits(line)
    if taken or len(base.measurements) > 1:
        return None
    sine = sine_of(base.measurements[0])
    if sine is None:
        return None
    multiples = [order * sine for order in range(2, HIGHEST_MULTIPLE + 1)]
    begun = {each: _begin_line(base, each, instrument) for each in multiples}
    frequency = min(begun, key=lambda each: promise(*begun[each]))
    fit = search(*begun[frequency])
    if fit is None:
        return None
    return frequency if -0.5 * fit.bic - LINE > evidence(final, base) else None


def _begin_line(base: Fit, frequency: float, instrument: Instrument) -> _Begun:
    """Put a line of no height beside a fitted model."""
    held = {LINE_FREQUENCY_NAME: frequency}
    composition = base.composition.plus(_line(base.composition.scale))
    problem = Problem(composition, base.measurements, instrument, held)
    known = base.named() | {SINE: 0.0, COSINE: 0.0} | held
    values = np.array([known[name] for name in problem.runs.names])
    return problem, values, begin_states(problem, base, values)
