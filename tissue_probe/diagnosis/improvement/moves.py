"""Moves from one model to another: which there are, and how they are made.

Contents: an effect that may be added, an effect that may be left out, the fits of both.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tissue_probe.diagnosis.evidence.posterior import evidence, promise_evidence
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.ranking.candidate import SAME_COST, list_shared_objects
from tissue_probe.diagnosis.ranking.candidates import fit_candidates, forms, refit
from tissue_probe.diagnosis.ranking.rules import exclude
from tissue_probe.diagnosis.ranking.screen import Promise, screen_effects
from tissue_probe.diagnosis.sharing import map_shared
from tissue_probe.physics.composition import Composition

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect


Kind = tuple[bool, tuple[str, ...]]


class Move(NamedTuple):
    """An effect that is added to a fitted model.

    Attributes
    ----------
    fit : Fit
        The model without the effect.
    effect : Effect
        The added effect, with all forms of it that are tried.
    promised : float
        Logarithm of the probability that the larger model is promised, up to the same constant of
        all models.
    reliable : bool
        Whether the promise is worth much: none tells when effects that switch will do so.
    kind : (bool, tuple of str)
        This, and the families of all effects, and of those that they contain: moves of one kind
        lead to kin.
    """

    fit: Fit
    effect: Effect
    promised: float
    reliable: bool
    kind: Kind

    @property
    def names(self) -> frozenset[str]:
        """Names of the effects of the larger model."""
        return frozenset((*self.fit.composition.names, self.effect.name))

    @property
    def families(self) -> tuple[str, ...]:
        """Families of the effects of the larger model."""
        return tuple(sorted((*families(self.fit), self.effect.family)))


def families(fit: Fit) -> tuple[str, ...]:
    """Return the families of a model's effects, in alphabetical order."""
    return tuple(sorted(each.family for each in fit.composition.effects))


def addable(composition: Composition, library: Mapping[str, Effect]) -> dict[str, Effect]:
    """Return the effects that may stand beside a model's: no second form of one that it has.

    And nothing that follows the spring where that is straight: it is one of its simpler effects.
    """
    own, straight = composition.all_effects, not composition.has_curved_spring
    return {
        name: effect
        for name, effect in library.items()
        if name not in composition.names
        and not any(exclude(effect, each) for each in own)
        and not (straight and effect.follows_spring)
    }


def switches(effect: Effect) -> bool:
    """Whether an effect, in any form of it, switches, or may part the tip from the tissue."""
    return any(form.switches or form.changes_contact for form in effect.every_form)


class Moves:
    """The moves that may be made from fitted models.

    Parameters
    ----------
    base : Fit
        The model without any effect.
    instrument : Instrument
        Constants of the rig with their tolerances.
    library : mapping of str to Effect
        The effects that may be added.
    leading : collection of str
        Names of effects that alone lead somewhere. A model without any is not sought.
    """

    def __init__(
        self,
        base: Fit,
        instrument: Instrument,
        library: Mapping[str, Effect],
        leading: Collection[str],
    ) -> None:
        self._base, self._instrument = base, instrument
        self._library, self._leading = library, frozenset(leading)

    def longer(self, fits: Sequence[Fit]) -> list[Move]:
        """Return each effect that may be added to models, by the promise of the score test."""
        pairs = [(fit, self._list_allowed(fit)) for fit in fits]
        screens = screen_effects(pairs, self._base.composition, self._instrument)
        return [
            self._move(fit, each)
            for fit, screen in zip(fits, screens, strict=True)
            for each in screen
        ]

    def _move(self, fit: Fit, promise: Promise) -> Move:
        whole = self._library[promise.effect.name]
        reliable = not any(map(switches, (whole, *fit.composition.effects)))
        # By the base, whose spring is straight, a zero of the force is one of the position.
        reliable &= not (whole.zero and self._instrument.any_zero)
        promised = promise_evidence(fit, promise.effect, promise.cost, self._base)
        kind = reliable, self.parts((whole, *fit.composition.effects))
        return Move(fit, promise.effect if reliable else whole, promised, reliable, kind)

    def parts(self, effects: Iterable[Effect]) -> tuple[str, ...]:
        """Return the families of effects and of those that they contain, in alphabetical order."""
        return tuple(sorted(family for each in effects for family in self._families(each)))

    def _families(self, effect: Effect) -> set[str]:
        """Return the families of an effect and of those that it contains."""
        contained = (self._library[name] for name in effect.simpler if name in self._library)
        return {effect.family, *(each.family for each in contained)}

    def _list_allowed(self, fit: Fit) -> list[Effect]:
        """Return effects that may be added to a fit: leading ones, where it has none of them."""
        allowed = addable(fit.composition, self._library).values()
        leads = any(map(self._leads, fit.composition.effects))
        return [each for each in allowed if leads or self._leads(each)]

    def _leads(self, effect: Effect) -> bool:
        """Whether an effect, or one that it contains, alone leads somewhere."""
        return not self._leading.isdisjoint((effect.name, *effect.simpler))

    def fit_moves(self, moves: Iterable[Move], needed: float) -> list[Fit]:
        """Fit the larger model of each move; searches that will not come near a cost end early."""
        moves = list(moves)
        known: list[object] = []
        for move in moves:
            larger = map(move.fit.composition.plus, forms(move.fit.composition, [move.effect]))
            known += list_shared_objects(move.fit, larger)
        found = map_shared(
            lambda move: fit_candidates(move.fit, [move.effect], self._instrument, needed),
            moves,
            known,
        )
        return [fit for fits in found for fit in fits]

    def remainders(self, fit: Fit) -> list[Fit]:
        """Fit a model without each of its effects, from its own values.

        Other values than those found without may lead to other effects.
        """
        models = [
            fit.composition.without(effect.name)
            for effect in fit.composition.effects[len(self._base.composition.effects) :]
        ]
        return self._refit_models(fit, models)

    def fit_nested(self, fit: Fit) -> list[Fit]:
        """Fit a model with an effect's place taken by one that it contains, or that contains it.

        Where both are as good one may be reached from the other only.
        """
        models = []
        for own in fit.composition.effects[len(self._base.composition.effects) :]:
            rest = fit.composition.without(own.name)
            allowed = addable(rest, self._library).values()
            models += [
                rest.plus(form)
                for each in allowed
                if each.name in own.simpler or own.name in each.simpler
                for form in forms(rest, [each])
            ]
        return self._refit_models(fit, models)

    def _refit_models(self, fit: Fit, models: Sequence[Composition]) -> list[Fit]:
        found = map_shared(
            lambda model: refit(fit, model, self._instrument),
            models,
            list_shared_objects(fit, models),
        )
        return [each for each in found if each is not None]


def is_elsewhere(fit: Fit, known: Fit | None) -> bool:
    """Whether a fit of the same effects ended at another place than the one that is known."""
    return known is None or not 1.0 / SAME_COST < fit.cost / known.cost < SAME_COST


def better(fit: Fit, known: Fit | None, base: Fit) -> bool:
    """Whether a fit is more probable than another one of the same effects."""
    return np.isfinite(fit.bic) and (known is None or evidence(fit, base) > evidence(known, base))
