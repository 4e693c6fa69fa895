"""The change of a rig's output by a small further force on the tip.

Contents: the linear response of rig and tissue, with the values of a fit.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import sympy as sp
from scipy.interpolate import interp1d
from scipy.signal import cont2discrete, lfilter, ss2tf

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects.effect import Effect, Parameter
from tissue_probe.physics.tissues import TISSUES
from tissue_probe.signals import FloatArray

_PUSH = sp.Symbol("further_force", real=True)
_PUSHED = Effect("further_force", "", "", (Parameter(_PUSH, "N", 0.0, -1e9, 1e9),), force=_PUSH)

Respond = Callable[[FloatArray, Measurement], FloatArray]
"""From forces of the tissue on the tip [N], shape (n, m), to changes of the output, (n, m)."""


def tip_response(fit: Fit) -> Respond:
    """Return the response to a force of the tissue, of the tissue without effects.

    It is exact where that tissue is linear, whichever variable the force depends on: the effects
    of the fit have answered in its prediction.
    """
    composition = fit.composition
    plain = Composition(composition.rig, composition.tissue)
    model = composition.rig.compose(
        (*plain.all_effects, _PUSHED), TISSUES[composition.tissue], contact_position=True
    )
    named = fit.named()
    at = {symbol: named.get(str(symbol), 0.0) for symbol in model.values}
    at |= dict.fromkeys([*model.states, *model.course], 0.0)
    push = sp.Matrix([_PUSH])
    system = [
        np.array(matrix.subs(at), dtype=np.float64)
        for matrix in (
            model.motion.jacobian(model.states) if model.states else sp.zeros(0, 0),
            model.motion.jacobian(push) if model.states else sp.zeros(0, 1),
            sp.Matrix([model.output]).jacobian(model.states) if model.states else sp.zeros(1, 0),
            sp.Matrix([model.output]).jacobian(push),
        )
    ]

    def respond(forces: FloatArray, measurement: Measurement) -> FloatArray:
        if not model.states:
            found: FloatArray = system[3][0, 0] * forces
            return found
        period = measurement.sample_period
        top, bottom = ss2tf(*cont2discrete(system, period, "foh")[:4])
        if measurement.at is None:
            return np.asarray(lfilter(top[0], bottom, _between(forces), axis=0))
        count = int(np.ceil(measurement.at[-1] / period - 1e-6)) + 1
        even = np.minimum(np.arange(count) * period, measurement.at[-1])
        driven = interp1d(measurement.at, forces, axis=0)(even)
        return measurement.interpolate_columns(lfilter(top[0], bottom, _between(driven), axis=0))

    return respond


def _between(forces: FloatArray) -> FloatArray:
    """Return samples through which straight lines have the mean of the smooth course there.

    Straight lines through the samples themselves lose the share (w dt)^2 / 12 at a frequency w.
    """
    bend = np.zeros_like(forces)
    bend[1:-1] = forces[2:] - 2.0 * forces[1:-1] + forces[:-2]
    return np.asarray(forces - bend / 12.0)
