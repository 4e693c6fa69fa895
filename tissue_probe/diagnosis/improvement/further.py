"""A further effect beside those of a path: which are tried, and how they are kept.

What belongs here: paths with one effect more. What does not: which path is taken, and what its
effects are worth in the end (``ladder``).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.diagnosis.fitting.effort import Effort
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument
from tissue_probe.diagnosis.ranking.candidate import SAME, shared
from tissue_probe.diagnosis.ranking.candidates import fit_candidates, forms
from tissue_probe.diagnosis.ranking.rules import TIE, added, exclude, explained, preferred, ranked
from tissue_probe.diagnosis.ranking.screen import Promise, screened
from tissue_probe.diagnosis.sharing import mapped
from tissue_probe.physics.composition import Composition

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

#: A further effect must remove this share of what exceeds the noise.
SHARE = 0.65
#: Where one removes this share, and all is explained, it is sought beside no other first effect.
CLEAR = 0.95
#: Families of which a second effect is tried: those that promise most; beside play all are.
FOLLOWED = 5
#: Of families whose best effect leaves no more than this many times the lowest cost, all are.
NEAR = 4.0
#: Responses after which no more is sought for one effect more, and where all is explained no more
#: is told from it.
SOUGHT, COMPARED = 10_000, 25_000
#: Where no two effects explain all, other forms of a first one are tried that alone leave no more
#: than this many times its cost; and where one gives way, kin of it from their own side.
RELATED = 1.2
#: Share of the noise, rms, by which what two forms of a first effect leave must differ.
UNSEEN = 1e-6

#: Pairs that promise most are tried before all else, beside so many of the best first effects: so
#: many pairs, and so many at once.
FIRSTS, PAIRS, AT_ONCE = 8, 12, 4

Path = tuple[Fit, ...]


def addable(composition: Composition, library: Mapping[str, Effect]) -> dict[str, Effect]:
    """Return what may stand beside a model's effects: no second form of a law that it has."""
    own = composition.all_effects
    return {
        name: effect
        for name, effect in library.items()
        if name not in composition.names and not any(exclude(effect, each) for each in own)
    }


def asked(fit: Fit) -> float:
    """Return the cost at which a model removes enough of what a fit leaves beyond the noise."""
    return fit.floor * (1.0 + (1.0 - SHARE) * (fit.ratio**2 - 1.0))


def _is_clear(fit: Fit, better: Fit) -> bool:
    """Whether a further effect explains all, and of what exceeded the noise leaves next to none."""
    return explained(better) and better.ratio**2 - 1.0 < (1.0 - CLEAR) * (fit.ratio**2 - 1.0)


def _leave_the_same(fit: Fit, other: Fit) -> bool:
    """Whether two forms of an effect leave the same: such as where the tip never comes off."""
    pairs = zip(fit.residuals, other.residuals, strict=True)
    difference = np.concatenate([one - another for one, another in pairs])
    return float(np.sqrt(np.mean(difference**2))) < UNSEEN * fit.noise


def _may_part(effect: Effect) -> bool:
    """Whether an effect may part the tip from the tissue, or the coil from the tip."""
    return _changes_contact(effect) or _has_play(effect)


def _has_play(effect: Effect) -> bool:
    return any(form.engaged != 1 for form in effect.every_form)


def _changes_contact(effect: Effect) -> bool:
    return any(form.changes_contact for form in effect.every_form)


class Further:
    """Paths with one effect more.

    Parameters
    ----------
    base : Fit
        Where all paths begin.
    instrument : Instrument
        What is known of the rig.
    library : mapping of str to Effect
        What may be added.
    leading : collection of str
        Names of effects that alone lead somewhere. Paths without any are not accepted in the end,
        and so not sought.
    effort : Effort, optional
        What is done is counted there; nowhere by default, and then all is done that there is to do.
    """

    def __init__(
        self,
        base: Fit,
        instrument: Instrument,
        library: Mapping[str, Effect],
        leading: Collection[str],
        effort: Effort | None = None,
    ) -> None:
        self._base, self.instrument, self._library = base, instrument, library
        self._effort = effort or Effort(base.measurements)
        self._leading = frozenset(leading)
        self._promises: dict[tuple[str, ...], list[Promise]] = {}
        self._extended: set[Fit] = set()
        self._settled: dict[tuple[str, ...], float] = {}
        #: The best fit of every set of effects that was tried.
        self.tried: dict[frozenset[str], Fit] = {}

    def is_spent(self, found: Fit | None = None) -> bool:
        """Whether so much was done that no more is: where all is explained already, or not yet."""
        most = COMPARED if found and explained(found) else SOUGHT
        return self._effort.done > most

    def reformed(self, paths: Iterable[Path]) -> list[Path]:
        """Return first effects that may part in other forms that do nearly as well alone.

        What makes one form the better may be the lack of the second effect: relaxing tissue
        recedes. Other effects take another form beside the second (``exchange.anew``).
        """
        found: list[Path] = []
        for first in (path[0] for path in paths):
            whole = self._library[added(first).name]
            for form in whole.every_form if _may_part(whole) else ():
                if form != added(first).plain:
                    fits = fit_candidates(self._base, [form], self.instrument)
                    near = [fit for fit in fits if fit.cost < RELATED * first.cost]
                    found += [(fit,) for fit in near if not _leave_the_same(fit, first)]
        return found

    def searched(self, fit: Fit, effects: Iterable[Effect], needed: float = np.inf) -> list[Fit]:
        """Add each effect to a model, in the form of it that fits best beside the others.

        Alone it may have done better in another form: see ``fit_candidates``.
        """
        whole = [self._library[effect.name] for effect in effects]
        return fit_candidates(fit, whole, self.instrument, needed)

    def longer(
        self, pairs: Iterable[tuple[Fit, Iterable[Effect]]], needed: float = np.inf
    ) -> list[Path]:
        """Return what ``searched`` finds beside each of several models."""
        searches = [(fit, list(effects)) for fit, effects in pairs]
        known: list[object] = []
        for fit, effects in searches:
            whole = [self._library[effect.name] for effect in effects]
            known += shared(fit, map(fit.composition.plus, forms(fit.composition, whole)))
        found = mapped(lambda search: self.searched(*search, needed), searches, known)
        paired = zip(searches, found, strict=True)
        return [(fit, both) for (fit, _), fits in paired for both in fits]

    def note(self, fits: Iterable[Fit]) -> None:
        """Keep fits among those that were tried."""
        for fit in fits:
            names = frozenset(fit.composition.names)
            if names not in self.tried or fit.bic < self.tried[names].bic:
                self.tried[names] = fit

    def known(self, composition: Composition, effects: Iterable[Effect]) -> list[Fit]:
        """Return what was found before of a model with one of these effects more."""
        sets = [(each, frozenset((*composition.names, each.name))) for each in effects]
        found = [(each, self.tried[names]) for each, names in sets if names in self.tried]
        return [fit for each, fit in found if added(fit).name == each.name]

    def towards(self, last: Fit, firsts: Iterable[Fit], needed: float) -> list[Path]:
        """Return paths from each of other effects to one that was found alone, the best first.

        Searches that will not come near the cost that is needed, or that of the one, are given up.
        """
        bar = min(needed, last.cost)
        effect, allowed = added(last), addable(last.composition, self._library)
        others = [
            fit
            for fit in firsts
            if added(fit).name in allowed and not self.has_settled(fit, effect)
        ]
        return self._noted([(fit, [effect]) for fit in others], bar)

    def promising(self, firsts: Sequence[Fit], best: Fit) -> list[Path]:
        """Return pairs that promise most, beside whichever of the best first effects, best first.

        Of each two families the pair that promises most: kin of it may take its place later. A few
        at a time: after the first only what promises to remove enough of what the best single
        effect leaves, and to leave less than what was found.
        """
        needed = asked(best)
        various: dict[frozenset[str], tuple[float, Fit, Effect]] = {}
        firsts = firsts[:FIRSTS]
        screens = zip(firsts, self._promised(firsts), strict=True)
        promises = [(each.cost, fit, each.effect) for fit, screen in screens for each in screen]
        for each in sorted(promises, key=lambda each: each[0]):
            various.setdefault(frozenset({added(each[1]).family, each[2].family}), each)
        waiting = list(various.values())[:PAIRS]
        found: list[Path] = []
        while waiting and (not found or waiting[0][0] < needed) and not self.is_spent():
            few, waiting = waiting[:AT_ONCE], waiting[AT_ONCE:]
            found += self._noted([(fit, [effect]) for _, fit, effect in few], needed)
            needed = min([needed, *(path[-1].cost for path in found)])
            if any(explained(path[-1]) for path in found):
                break
        order = preferred(path[-1] for path in found)
        return sorted(found, key=lambda path: order.index(path[-1]))

    def losing_contact(self, firsts: Iterable[Fit], needed: float) -> list[Path]:
        """Return paths from first effects to each that changes contact, the best first.

        Where contact is lost depends on all else: tissue that relaxes recedes from the tip. What
        was promised without, or how another form did, says little of it. Searches that will not
        come near the cost that is needed are given up.
        """
        pairs = []
        for fit in firsts:
            allowed = addable(fit.composition, self._library).values()
            losing = filter(_changes_contact, allowed)
            pairs.append((fit, [each for each in losing if not self.has_settled(fit, each)]))
        return self._noted(pairs, needed)

    def _noted(self, pairs: Iterable[tuple[Fit, Iterable[Effect]]], needed: float) -> list[Path]:
        """Return what ``longer`` finds, the best first, and keep it among what was tried."""
        found = self.longer(pairs, needed)
        self.note(path[-1] for path in found)
        return sorted(found, key=lambda path: path[-1].bic)

    def is_new(self, fit: Fit, effect: Effect) -> bool:
        """Whether an effect was not tried yet together with those of a fit, in whatever order."""
        return frozenset((*fit.composition.names, effect.name)) not in self.tried

    def has_settled(self, fit: Fit, effect: Effect) -> bool:
        """Whether a search for an effect beside this fit, or one as good, has led somewhere."""
        begun = self._settled.get((*fit.composition.names, effect.name), np.inf)
        return 1.0 / SAME < fit.cost / begun < SAME

    def explains(self, fit: Fit, other: Fit) -> bool:
        """Whether both fits' effects together were found to explain all, in whatever order."""
        names = frozenset((*fit.composition.names, *other.composition.names))
        return names in self.tried and explained(self.tried[names])

    def unasked(self, paths: Iterable[Path], final: Fit) -> list[Path]:
        """Return what ``of`` does of paths whose effects were not yet extended.

        Parameters
        ----------
        paths : iterable of tuple of Fit
            What is to be extended.
        final : Fit
            What will not come near it is given up. Where it explains all, others could only do as
            well: what was tried is passed over.
        """
        known = {fit.composition.names for fit in self._extended}
        return self.of([path for path in paths if path[-1].composition.names not in known], final)

    def of(self, paths: Sequence[Path], final: Fit | None = None) -> list[Path]:
        """Return every path with one effect more, the best first, each set of effects once.

        What was extended before is not extended again.

        Of two ways to the same effects that end as well, the one stays that began better. Where one
        of a path is clear, those after it are not extended.

        Parameters
        ----------
        paths : sequence of tuple of Fit
            What is to be extended.
        final : Fit, optional
            A model that is there already: see ``unasked``.
        """
        longer: dict[frozenset[str], Path] = {}
        for path in paths:
            if path[-1] in self._extended:
                continue
            self._extended.add(path[-1])
            others = [*([final] if final else []), *(each[-1] for each in longer.values())]
            lowest = min((fit.ratio for fit in others), default=np.inf)
            for fit in ranked(self._followed(path[-1], lowest, final)):
                names = frozenset(fit.composition.names)
                if names not in longer or fit.bic < longer[names][-1].bic - TIE:
                    longer[names] = (*path, fit)
                self.note([fit])
                if fit.converged:
                    self._settled[fit.composition.names] = path[-1].cost
            if any(_is_clear(path[-1], each[-1]) for each in longer.values()):
                break
            if self.is_spent(final):
                break
        order = preferred(path[-1] for path in longer.values())
        return sorted(longer.values(), key=lambda path: order.index(path[-1]))

    def _followed(self, fit: Fit, lowest: float, final: Fit | None) -> list[Fit]:
        """Fit the best of each family, then all of those families that keep their promise best.

        Of families those that promise most; beside play alone that leads somewhere all, as it takes
        away from what is promised as if it were not there.

        What will not come near the lowest residual of another path is given up. Beside what
        explains all, what was tried is passed over, and what promises to leave far more.
        """
        (promised,) = self._promised([fit])
        if final is not None and explained(final):
            near = [each for each in promised if each.cost <= NEAR * final.cost]
            promised = [each for each in near if self.is_new(fit, each.effect)]
        order = [each.effect for each in promised]
        first: dict[str, Effect] = {}
        for effect in order:
            first.setdefault(effect.family, effect)
        needed = min(asked(fit), fit.floor * lowest**2)
        chosen = list(first.values())
        more = fit.composition.effects[len(self._base.composition.effects) :]
        if len(more) > 1 or not any(_has_play(each) and self._leads(each) for each in more):
            chosen = chosen[:FOLLOWED]
        fits = fit_candidates(fit, chosen, self.instrument, needed)
        if not fits or self.is_spent(final):
            return fits
        enough = NEAR * min(each.cost for each in fits)
        kept = {added(each).family for each in fits if each.cost <= enough}
        others = [each for each in order if each.family in kept and each is not first[each.family]]
        return fits + fit_candidates(fit, others, self.instrument, needed, fits)

    def _promised(self, fits: Sequence[Fit]) -> list[list[Promise]]:
        """Return for each fit what may be added by what it promises, in the most promising form.

        What may part is tried in every form of it: no promise tells them apart.
        """
        new = [fit for fit in fits if fit.composition.names not in self._promises]
        pairs = [(fit, self._allowed(fit)) for fit in new]
        screens = screened(pairs, self._base.composition, self.instrument)
        for fit, screen in zip(new, screens, strict=True):
            found = [(each, self._library[each.effect.name]) for each in screen]
            self._promises[fit.composition.names] = [
                each._replace(effect=whole) if _may_part(whole) else each for each, whole in found
            ]
        return [self._promises[fit.composition.names] for fit in fits]

    def _allowed(self, fit: Fit) -> list[Effect]:
        """Return what may be added to a fit: what leads, where nothing of it does."""
        allowed = addable(fit.composition, self._library).values()
        leads = any(map(self._leads, fit.composition.effects))
        return [each for each in allowed if leads or self._leads(each)]

    def _leads(self, effect: Effect) -> bool:
        """Whether an effect, or what it contains, alone leads somewhere."""
        return not self._leading.isdisjoint((effect.name, *effect.simpler))
