"""How well an excitation shows an effect, before anybody has seen it.

What belongs here: what an effect of typical strength would change in the force, beyond what the
model can absorb. What does not: choosing excitations (``separation``).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tissue_probe.diagnosis.candidates import begin_states
from tissue_probe.diagnosis.fit import Fit, Problem, normal_matrix
from tissue_probe.diagnosis.measurement import Instrument
from tissue_probe.physics.effects import Effect

#: Squared signal over noise from which an effect is found.
SEEN = 50.0
#: An effect that changes the force by this many times the noise is not expected to hide.
PLAIN = 2.0


def visibility(base: Fit, effect: Effect, instrument: Instrument) -> float:
    """Squared change of the force over the noise that an effect leaves, summed over the samples.

    It has typical strength, or the one that changes the force by ``PLAIN`` times the noise (rms) if
    that is less: an excitation should show it well before it spoils the other values. The part of
    the change that the model's own parameters, the rig's tolerances and the unknown start would
    absorb is taken off (a Schur complement of the normal matrix). Infinite for effects whose
    strength is not small of first order, such as lost contact: they show or they are absent.

    Parameters
    ----------
    base : Fit
        The model without the effect, and the measurements.
    effect : Effect
        With its parameters at their defaults.
    instrument : Instrument
        What is known of the rig.
    """
    if not effect.parameters or effect.neutral != 0.0 or effect.switches or effect.rounded != 0:
        return np.inf
    problem = Problem(base.composition.plus(effect), base.measurements, instrument)
    strengths = [p.name for p in effect.parameters[: effect.strengths]]
    known = base.named() | dict.fromkeys(strengths, 0.0)
    names = problem.kernel.VALUES
    values = np.array([known.get(e.name, e.default) for e in problem.composition.values])
    normal = normal_matrix(problem, values, begin_states(problem, base, values))
    if normal is None:
        return 0.0
    own = [names.index(name) for name in strengths]
    shape = {p.name for p in effect.parameters} - set(strengths)
    free = [
        index
        for index in range(normal.shape[0])
        if index not in own
        and normal[index, index] > 0
        and (index >= problem.count or (problem.free[index] and names[index] not in shape))
    ]
    root = np.sqrt(np.diag(normal)[free])
    inner = normal[np.ix_(free, free)] / np.outer(root, root)
    across = normal[np.ix_(free, own)] / root[:, None]
    left = normal[np.ix_(own, own)] - across.T @ np.linalg.pinv(inner, 1e-11, True) @ across
    size = np.array([p.default for p in effect.parameters[: effect.strengths]])
    change = size @ normal[np.ix_(own, own)] @ size
    share = min(1.0, PLAIN**2 * base.samples / change) if change > 0 else 0.0
    return float(max(size @ left @ size, 0.0) * share)


def unseen(base: Fit, library: Mapping[str, Effect], instrument: Instrument) -> tuple[str, ...]:
    """Name the effects that the measurements could not have shown (see ``visibility``)."""
    return tuple(
        name
        for name, effect in library.items()
        if name not in base.composition.names and visibility(base, effect, instrument) < SEEN
    )
