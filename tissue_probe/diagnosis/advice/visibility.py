"""How well an excitation shows an effect, before anybody has seen it.

Contents: the change of the force by an effect of typical strength, less the part that the model
absorbs.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.sensitivities import by_unknown, precision, unknown
from tissue_probe.diagnosis.improvement.moves import addable
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.ranking.rules import find_added_effect
from tissue_probe.diagnosis.ranking.starts import begin_states, start_values
from tissue_probe.diagnosis.sharing import map_shared
from tissue_probe.physics.composition import Composition
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

#: Squared signal over noise from which an effect is found.
SEEN = 50.0
#: An effect that changes the force by this many times the noise is not expected to hide.
PLAIN_RATIO = 2.0
#: Share of the typical strength at which the response is taken as linear in it.
FAINT_STRENGTH = 0.01


def visibilities(
    fit: Fit, effects: Iterable[Effect], instrument: Instrument, alone: Composition
) -> list[float]:
    """Squared change of the force over the noise that effects leave, summed over the samples.

    Each has typical strength, or the one that changes the force by ``PLAIN_RATIO`` times the noise
    (rms) if that is less: an excitation should show it well before it spoils the other values. The
    part of the change that the model's own parameters, the rig's tolerances and the unknown start
    would absorb is taken off (a Schur complement of the normal matrix). Infinite for effects whose
    strength is not small of first order, such as lost contact: they show or they are absent.

    Parameters
    ----------
    fit : Fit
        The model without the effects, and the measurements.
    effects : iterable of Effect
        With their parameters at their defaults.
    instrument : Instrument
        Constants of the rig with their tolerances.
    alone : Composition
        The model to which an effect is added to see its change: that of the fit, or, where
        the fit has further effects, the one without them, whose pairs are compiled already.
    """
    with np.errstate(all="ignore"):  # a change beyond all bounds shows nothing
        own = _Absorbed(fit, instrument)
        return map_shared(lambda effect: _visibility(fit, own, effect, instrument, alone), effects)


def unseen(
    fit: Fit,
    library: Mapping[str, Effect],
    instrument: Instrument,
    alone: Composition,
    tried: Iterable[Fit] = (),
) -> tuple[str, ...]:
    """Name the effects that the measurements could not have shown.

    See ``visibilities``; and of the models that were ``tried`` with one effect more, those whose
    strength is known no better than its typical value: in a single ramp dry friction poses as
    damping, though its steps would show by themselves.
    """
    others = addable(fit.composition, library)
    seen = visibilities(fit, others.values(), instrument, alone)
    hidden = {find_added_effect(each).name for each in tried if _is_unknown(each)}
    return tuple(
        name for name, size in zip(others, seen, strict=True) if size < SEEN or name in hidden
    )


def _is_unknown(fit: Fit) -> bool:
    """Whether the strength of the effect that a model has more may be as large as is typical."""
    strengths = find_added_effect(fit).parameters[:1]
    known = fit.deviations()
    return any(known.get(each.name, 0.0) > abs(each.default) for each in strengths)


class _Absorbed:
    """The part of a change of the force that a fitted model can absorb."""

    def __init__(self, fit: Fit, instrument: Instrument) -> None:
        problem = Problem(fit.composition, fit.measurements, instrument)
        free = unknown(problem)
        self.columns = by_unknown(problem, fit.values, fit.starts)[:, free]
        self.precision = precision(problem, fit.values)[free]

    def measure_rest(self, change: FloatArray, further: FloatArray, known: FloatArray) -> float:
        """Sum of squares of a change, less the part that the model and further columns absorb.

        Parameters
        ----------
        change : array, shape (N,)
            Of the force over the noise.
        further : array, shape (N, m)
            The sensitivities of unknowns that the model has not.
        known : array, shape (m,)
            Their precision.
        """
        whole = np.column_stack([self.columns, further])
        normal = whole.T @ whole + np.diag(np.concatenate([self.precision, known]))
        root = np.sqrt(np.diag(normal))
        used = root > 0.0
        inner = normal[np.ix_(used, used)] / np.outer(root[used], root[used])
        across = (whole.T @ change)[used] / root[used]
        return float(change @ change - across @ np.linalg.pinv(inner, 1e-11, True) @ across)


def _visibility(
    fit: Fit, own: _Absorbed, effect: Effect, instrument: Instrument, alone: Composition
) -> float:
    if not effect.parameters or effect.neutral != 0.0 or effect.switches or effect.rounded != 0:
        return np.inf
    problem = Problem(alone.plus(effect), fit.measurements, instrument)
    strengths = effect.parameters[: effect.strengths]
    typical = {strength.name: strength.default for strength in strengths}
    # Not at none: the start of the effect's memory matters in proportion to its strength.
    faint = {name: FAINT_STRENGTH * size for name, size in typical.items()}
    values = start_values(problem, fit.named(), effect, faint)
    columns = by_unknown(problem, values, begin_states(problem, fit, values))
    change = columns[:, : problem.count] @ [typical.get(n, 0.0) for n in problem.runs.meanings]
    states = [state not in fit.composition.kernel.states for state in problem.kernel.states]
    begun = np.array([False] * problem.count + states * len(fit.measurements), dtype=bool)
    whole = float(change @ change)
    if not np.isfinite(whole) or whole == 0.0:
        return 0.0
    left = own.measure_rest(
        change, columns[:, begun] / FAINT_STRENGTH, precision(problem, values)[begun]
    )
    return max(left, 0.0) * min(1.0, PLAIN_RATIO**2 * fit.samples / whole)
