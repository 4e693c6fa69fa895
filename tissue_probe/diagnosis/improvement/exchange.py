"""Effects of a path that give way: searched anew, or to others that do better beside the rest.

What belongs here: what is fitted in the place of one effect, or of both.
What does not: which path is taken in the end (``ladder``), one effect more (``further``).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument
from tissue_probe.diagnosis.improvement.further import RELATED, Further, Path, asked
from tissue_probe.diagnosis.ranking.candidate import SAME, shared
from tissue_probe.diagnosis.ranking.candidates import fit_candidates, refit
from tissue_probe.diagnosis.ranking.rules import (
    SIMPLER,
    added,
    explained,
    gains_much,
    only_rounding,
    ranked,
    significant,
)
from tissue_probe.diagnosis.sharing import mapped
from tissue_probe.physics.composition import Composition

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect


def anew(path: Path, further: Further) -> Path:
    """Search once more for the first effect, beside the last: it was found while that was missing.

    Another form of it may have done better alone. The last may have been found badly beside it,
    too, and is then taken as it is found alone. Only where something is left that better values
    may explain, and the last explains something.
    """
    final, first = path[-1], added(path[0])
    if explained(final) or not significant(path[-2], final):
        return path
    for other in _without_first(path, further.instrument):
        if further.has_settled(other, first):
            continue
        for fit in further.searched(other, [first], final.cost):
            found = refit(fit, final.composition.having(added(fit)), further.instrument)
            if found is not None and found.bic < path[-1].bic:
                path = (*path[:-1], found)
        if explained(path[-1]):
            break
    return path


def _without_first(path: Path, instrument: Instrument) -> Iterator[Fit]:
    """Yield fits with all but the first effect: from the values of all, then the last alone.

    The second only if it ends elsewhere.
    """
    final, first = path[-1], added(path[0])
    without = refit(final, final.composition.without(first.name), instrument)
    if without is not None:
        yield without
    if len(path) == 2:
        base = refit(path[0], path[0].composition.without(first.name), instrument)
        for alone in fit_candidates(base, [added(final)], instrument) if base else ():
            if without is None or not 1.0 / SAME < alone.cost / without.cost < SAME:
                yield alone


def exchanged(steps: Sequence[Fit], ranking: Sequence[Fit], further: Further) -> list[Fit]:
    """Let one of several effects give way to another of its family, if better, or that it contains.

    Or to one that contains it, if better by much, or if something is left to explain. It was chosen
    while the others were missing, which another form of it may have followed. One that was found
    badly stays if it is the better when it is searched in the same way.
    """
    if len(steps) < 2:
        return list(steps)
    steps, begun = list(steps), steps[-1]
    alone = {added(fit).name: fit for fit in ranking}
    last = added(steps[-1])
    for first, old in ((True, added(steps[0])), (False, last)):
        stays = [added(steps[-1] if first else steps[0])] if len(steps) == 2 else []
        for fit in _in_its_place(old, steps[-1], alone, stays, further):
            if _is_better(fit, steps[-1], old):
                old = added(fit)
                steps[-1] = fit
                if first:
                    steps[0] = alone[old.name]
                    steps[-1] = refit(fit, _last(fit, last), further.instrument) or fit
    return steps if steps[-1] is begun else list(anew(tuple(steps), further))


def _is_better(fit: Fit, final: Fit, old: Effect) -> bool:
    """Whether a fit with another effect in the place of the old one is better than the final one.

    What contains a simpler effect stands back, unless it alone explains all.
    """
    gain = final.bic - fit.bic
    if added(fit).name in old.simpler and (explained(fit) or not explained(final)):
        return only_rounding(fit) or gain > -SIMPLER
    if old.name in added(fit).simpler and explained(final):
        return gains_much(final, fit)
    return gain > 0.0


def _in_its_place(
    old: Effect,
    final: Fit,
    alone: Mapping[str, Fit],
    stays: Sequence[Effect],
    further: Further,
) -> list[Fit]:
    """Fit a model with others of its family, what it contains or what contains it, in its place.

    Where all is explained, what contains it is tried from there only. Beside the effect that stays,
    if it is one, they are searched from there, and it from them where they are nearly as good
    alone: where they are nothing beside it alone, no way may lead to them from there.
    """
    rivals = [
        effect
        for effect in map(added, alone.values())
        if effect.name not in final.composition.names
        and (
            effect.family == old.family or effect.name in old.simpler or old.name in effect.simpler
        )
    ]
    less = final.composition.without(old.name)
    without = refit(final, less, further.instrument) if rivals else None
    if without is None:
        return []
    needed = _needed(final, further)
    # Where all is explained, what was given up before would not come near now either; but what is
    # simpler, and as good, may have been found badly from its own side.
    # So may be what was found beside another form of what stays.
    found = further.known(without.composition, rivals) if explained(final) else []
    found = [fit for fit in found if fit.composition == without.composition.plus(added(fit))]
    found = [fit for fit in found if explained(fit) or added(fit).name not in old.simpler]
    richer = [each for each in rivals if old.name in each.simpler]
    passed = [*map(added, found), *(richer if explained(final) else ())]
    others = [each for each in rivals if each not in passed]
    # Of two of which one contains the other, either may be reached from where they are as good.
    nested = [each for each in rivals if each.name in old.simpler or each in richer]
    refitted = _refitted([(final, less.plus(each)) for each in nested], further)
    found += [fit for fit in refitted if fit is not None]
    pairs: list[tuple[Fit, Sequence[Effect]]] = [(without, others)]
    own = [(alone[old.name], stays)] if stays and old.name in alone else []
    for begun, _ in own:
        near = [alone[e.name] for e in others if alone[e.name].cost < RELATED * begun.cost]
        pairs += [(fit, stays) for fit in near]
    found += _told(further.longer(pairs, needed), without, further)
    if any(_is_better(fit, final, old) and fit.bic < final.bic for fit in found):
        again = further.longer([(without, [old]), *own], needed)
        found = ranked([*found, *_told(again, without, further)])
    further.note(found)
    return found


def _told(paths: Sequence[Path], without: Fit, further: Further) -> list[Fit]:
    """Return the ends of paths, told as if all began with what is without an effect."""
    others = [path for path in paths if path[0] is not without]
    turned = iter(
        _refitted([(path[-1], _last(path[-1], added(path[0]))) for path in others], further)
    )
    told = [path[-1] if path[0] is without else next(turned) for path in paths]
    return [fit for fit in told if fit is not None]


def _last(fit: Fit, effect: Effect) -> Composition:
    """Return a fit's model as if one of its effects had come last."""
    return fit.composition.without(effect.name).plus(effect)


def _refitted(models: Sequence[tuple[Fit, Composition]], further: Further) -> list[Fit | None]:
    """Fit models, each from the values of a fit."""
    known = [part for fit, model in models for part in shared(fit, [model])]
    return mapped(lambda one: refit(*one, further.instrument), models, known)


def both_exchanged(final: Fit, kin: Sequence[Sequence[Fit]], further: Further) -> list[Path]:
    """Fit kin of one of two effects beside kin of the other, where it does nearly as well alone."""
    pairs: list[tuple[Fit, Sequence[Effect]]] = []
    for (old, *firsts), (_, *seconds) in (kin, kin[::-1]):
        for first in (fit for fit in firsts if fit.cost < RELATED * old.cost):
            new = [each for each in map(added, seconds) if further.is_new(first, each)]
            pairs += [(first, new)] if new else []
    found = further.longer(pairs, _needed(final, further))
    further.note(path[-1] for path in found)
    return found


def _needed(final: Fit, further: Further) -> float:
    """Return the cost asked of what takes an effect's place.

    Of what is tried late a good part less; but where all is explained, what does as well is told.
    """
    late = further.is_spent(final) and not explained(final)
    return asked(final) if late else final.cost + SIMPLER


def kin_of(effect: Effect, ranking: Sequence[Fit]) -> list[Fit]:
    """Return what was found of an effect alone, then of others of its family; or nothing."""
    own = [fit for fit in ranking if added(fit).name == effect.name]
    family = [fit for fit in ranking if added(fit).family == effect.family]
    return own and own + [fit for fit in family if fit is not own[0]]
