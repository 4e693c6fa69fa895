"""The signs of an effect in each experiment: residuals of the plain model, and of other effects.

The change of the force by an effect is projected on the changes that the plain model's own values
can make, and on those of another effect, linearly in all values. So it is an estimate; a diagnosis
fits instead.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tissue_probe.analysis.effect_pages.simulated_force import DriveMotion, force, rig_for, typical
from tissue_probe.diagnosis.advice.separation import PROBE_EXPERIMENTS
from tissue_probe.diagnosis.advice.visibility import SEEN
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import Effect
from tissue_probe.physics.rigs import Rig
from tissue_probe.signals import FloatArray

#: Noise of the force [N] against which the tolerances of a rig weigh, and which a simulated
#: recording has: a load cell of a laboratory, 0.1 % of some newtons.
NOISE = 2e-3
#: Share of a value by which it is moved to take the derivative.
DERIVATIVE_STEP = 0.02
#: Another effect takes the place of one where it leaves less than this share of the plain model's
#: residual: it then explains 90 % of the square.
PASSES_FOR = 0.3


@dataclass(frozen=True)
class Outcome:
    """The signs of one effect in one experiment.

    Attributes
    ----------
    motion : Motion
        The experiment.
    left : float
        Rms that the plain model leaves of the effect [N].
    rivals : dict of float
        Rms that is left with each other effect in its place [N].
    """

    motion: DriveMotion
    left: float
    rivals: Mapping[str, float]

    @property
    def shows(self) -> bool:
        """Whether the residual is seen in a recording with noise, as a diagnosis asks."""
        return (self.left / NOISE) ** 2 * self.motion.times.size > SEEN

    @property
    def nearest(self) -> str:
        """The effect that leaves least; empty where there is no other."""
        return min(self.rivals, key=lambda name: self.rivals[name], default="")

    @property
    def nearest_left(self) -> float:
        """Rms that the nearest other effect leaves [N]."""
        return self.rivals.get(self.nearest, self.left)

    @property
    def passing(self) -> tuple[str, ...]:
        """The effects that can take the place of this one in this experiment."""
        return tuple(name for name, left in self.rivals.items() if left < PASSES_FOR * self.left)


@dataclass(frozen=True)
class _Changes:
    """Changes of the force in one experiment, with a row for each tolerance of the rig below."""

    plain: FloatArray
    effects: Mapping[str, FloatArray]
    spans: Mapping[str, FloatArray]


def outcomes(library: Mapping[str, Effect]) -> dict[str, tuple[Outcome, ...]]:
    """Return the signs of each effect in each of the usual experiments.

    Parameters
    ----------
    library : mapping of str to Effect
        All effects; each is compared with the others that its rig admits and that do not contain
        it.
    """
    motions = [DriveMotion(*each) for each in PROBE_EXPERIMENTS]
    rigs = {name: rig_for(effect) for name, effect in library.items()}
    changes = {
        (rig, number): _changes(rig, motion, library)
        for rig in dict.fromkeys(rigs.values())
        for number, motion in enumerate(motions)
    }
    return {
        name: tuple(
            _outcome(effect, library, motion, changes[rigs[name], number])
            for number, motion in enumerate(motions)
        )
        for name, effect in library.items()
    }


def residual(effect: Effect, motion: DriveMotion) -> FloatArray:
    """Return the residual of the nearest plain model at each sample of an effect's force [N]."""
    rig = rig_for(effect)
    changes = _changes(rig, motion, {effect.name: effect})
    return _beyond(changes.effects[effect.name], changes.plain)[: motion.times.size]


def best(told: Sequence[Outcome]) -> Outcome:
    """Return the experiment in which the nearest other effect leaves most."""
    return max(told, key=lambda each: each.nearest_left)


def _outcome(
    effect: Effect, library: Mapping[str, Effect], motion: DriveMotion, changes: _Changes
) -> Outcome:
    change = changes.effects[effect.name]
    rivals = {
        name: _rms(_beyond(change, span), motion)
        for name, span in changes.spans.items()
        if name != effect.name and effect.name not in library[name].simpler
    }
    return Outcome(motion, _rms(_beyond(change, changes.plain), motion), rivals)


def _rms(residual: FloatArray, motion: DriveMotion) -> float:
    return float(np.linalg.norm(residual) / np.sqrt(motion.times.size))


def _beyond(change: FloatArray, span: FloatArray) -> FloatArray:
    """Return the part of a change that no combination of the orthonormal columns makes."""
    return np.asarray(change - span @ (span.T @ change))


def _changes(rig: Rig, motion: DriveMotion, library: Mapping[str, Effect]) -> _Changes:
    plain = Composition(rig)
    values = typical(plain)
    before = force(plain, values, motion)
    # The place of touch is fitted where a rig has no tolerance for it: nobody states it.
    tolerances = {each.name: each.deviation or np.inf for each in rig.constants}
    own = [_derivative(plain, values, name, motion, before) for name in values]
    prior = np.diag([_weight(values[n], tolerances.get(n, np.inf)) for n in values])
    columns = np.vstack([np.column_stack(own), prior])
    changed, spans = {}, {}
    for name, effect in library.items():
        if not rig.admits(effect):
            continue
        model = plain.plus(effect.plain)
        with_it = typical(model)
        after = force(model, with_it, motion)
        further = [
            _derivative(model, with_it, entry.name, motion, after) for entry in effect.parameters
        ]
        added = np.column_stack([after - before, *further])
        added = np.vstack([added, np.zeros((len(values), added.shape[1]))])
        changed[name] = added[:, 0]
        spans[name] = _span(np.hstack([columns, added]))
    return _Changes(_span(columns), changed, spans)


def _derivative(
    model: Composition, values: Mapping[str, float], name: str, motion: DriveMotion, at: FloatArray
) -> FloatArray:
    """Return the change of the force by ``DERIVATIVE_STEP`` of a value."""
    moved = {**values, name: values[name] + _step(values[name])}
    return force(model, moved, motion) - at


def _step(value: float) -> float:
    """Return how far a value is moved; one that is 0 by a hundredth of a millimetre or second."""
    return DERIVATIVE_STEP * value if value else 1e-5


def _weight(value: float, tolerance: float) -> float:
    """Return the force that a step of a value is worth, being as unlikely as its tolerance says."""
    return NOISE * _step(value) / tolerance


def _span(columns: FloatArray) -> FloatArray:
    """Return orthonormal columns of the same span; those that are none are left out."""
    size = np.linalg.norm(columns, axis=0)
    left, weights, _ = np.linalg.svd(columns[:, size > 0.0] / size[size > 0.0], full_matrices=False)
    return np.asarray(left[:, weights > 1e-9 * weights[0]])
