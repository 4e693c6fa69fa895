"""How probable each model is that was tried, and each effect.

Contents: from fits to probabilities.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tissue_probe.diagnosis.evidence.adequacy import adequacy, leaves_more, leaves_only_noise
from tissue_probe.diagnosis.evidence.line import is_multiple
from tissue_probe.diagnosis.fitting.fit import Fit

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

#: Logarithm of the odds of no second effect, and of no line at a multiple of the drive: it makes up
#: for one line of any nonlinear cause.
SECOND, LINE = 4.0, 8.0
#: A law's form is right to this share: forms of one family are told apart no better by their
#: residuals.
FORM_SHARE = 0.01
#: Logarithm of a ratio of costs from which on a form is beyond all question.
MUCH = 50.0
#: Minus twice the logarithm of a ratio of likelihoods by which chance may tell models of the same
#: function apart: of one value, two of its standard deviations.
FORMS_BY_CHANCE = 4.0
#: How fast the odds of a model that is not in the library grow with the adequacy of the best, and
#: how probable the effects of that remain if none in the library is right (21 of 50 seen).
UNKNOWN, STILL = 8.0, 0.4
#: Probability that a set of models holds, and from which on one counts as sure.
SURE_PROBABILITY = 0.95
#: Logarithm of the odds beyond which a model is not in the set that is sure, if a better one is.
RIVAL = float(np.log(SURE_PROBABILITY / (1.0 - SURE_PROBABILITY)))


@dataclass(frozen=True)
class ModelPosterior:
    """Probabilities of the models that were tried, given that one of the library's is right.

    Attributes
    ----------
    base : Fit
        The model that was asked about.
    models : tuple of Fit
        The most probable first.
    probabilities : tuple of float
        Of each.
    unknown : float
        Probability that none of the library's is right.
    """

    base: Fit
    models: tuple[Fit, ...]
    probabilities: tuple[float, ...]
    unknown: float

    @property
    def likely(self) -> tuple[Fit, ...]:
        """The fewest models that together are sure."""
        count = int(np.searchsorted(np.cumsum(self.probabilities), SURE_PROBABILITY)) + 1
        return self.models[:count]

    def effect(self, name: str) -> float:
        """Return the probability that an effect is missing, over all models."""
        known = sum(
            probability
            for fit, probability in zip(self.models, self.probabilities, strict=True)
            if name in self.more(fit)
        )
        still = STILL if name in self.more(self.models[0]) else 0.0
        return (1.0 - self.unknown) * known + self.unknown * still

    @property
    def families(self) -> dict[str, float]:
        """Probability that some effect of a family is missing, by the family's name.

        The most probable first; of equally probable ones in the order of the models and effects.
        """
        found: dict[str, float] = defaultdict(float)
        for fit, probability in zip(self.models, self.probabilities, strict=True):
            for family in dict.fromkeys(_families(fit, self.base)):
                found[family] += probability
        return dict(sorted(found.items(), key=lambda each: -each[1]))

    def more(self, fit: Fit) -> tuple[str, ...]:
        """Name the effects that a model has beside the base."""
        return _names(fit, self.base)


def posterior(
    base: Fit, fits: Iterable[Fit], second: Mapping[frozenset[str], float] | None = None
) -> ModelPosterior:
    """Return how probable models are.

    Nothing is added to a model that leaves noise only. Forms of one family are told apart no better
    than a law's form is right: their likelihood is tempered, and the evidence of the family is not.

    Parameters
    ----------
    base : Fit
        The model that was asked about.
    fits : iterable of Fit
        It with effects more; of each set of effects the best counts.
    second : mapping of frozenset of str to float, optional
        Logarithm of the likelihood of a second recording, by the names of a model's effects; then
        only the models named there count.
    """
    best = _best_of_each([base, *fits])
    groups: dict[tuple[str, ...], list[_WeightedFit]] = defaultdict(list)
    for names, fit in _possible(best, base, second).items():
        likely = -0.5 * fit.misfit + (second.get(names, 0.0) if second else 0.0)
        told = _WeightedFit(fit, likely, weigh_model(fit, base))
        groups[tuple(sorted(_families(fit, base)))].append(told)
    weighed = [pair for group in groups.values() for pair in _temper_group(group, best)]
    weighed.sort(key=lambda pair: (-pair[1], pair[0].fit.misfit))
    weighed = _with_twins(weighed, base)
    models, weights = [told.fit for told, _ in weighed], np.array([each for _, each in weighed])
    probabilities = np.exp(weights - np.logaddexp.reduce(weights))
    return ModelPosterior(
        base, tuple(models), tuple(map(float, probabilities)), _unknown(adequacy(models[0]))
    )


def _possible(
    best: Mapping[frozenset[str], Fit], base: Fit, second: Mapping[frozenset[str], float] | None
) -> dict[frozenset[str], Fit]:
    """Return the models of which one is to be probable, by the names of their effects."""
    enough = [
        names for names, fit in best.items() if leaves_only_noise(fit) and not leaves_more(fit)
    ]
    found = {
        names: fit
        for names, fit in best.items()
        if not any(names > fewer for fewer in enough)
        and not _is_another(fit, best, base)
        and not any(_is_nothing(effect, fit) for effect in _effects(fit, base))
        and (second is None or names in second)
    }
    return found or {frozenset(): base}


class _WeightedFit(NamedTuple):
    """A fit, the logarithm of its likelihood, and of its probability before that."""

    fit: Fit
    likely: float
    thought: float


_Weighed = tuple[_WeightedFit, float]
"""A fit, and the logarithm of its probability up to the same constant of all."""


def evidence(fit: Fit, base: Fit) -> float:
    """Return the logarithm of a model's probability, up to the same constant of all models."""
    return -0.5 * fit.misfit + weigh_model(fit, base)


def list_favoured_effects(base: Fit, fits: Iterable[Fit]) -> tuple[str, ...]:
    """Name effects that may be there although the residual without them is noise.

    The tests of a residual look for anything, so a known effect must leave more to be found by them
    than its own evidence needs. The samples do not show it then, but they speak for it: these are
    the effects that a set of models would have in it if one of them were missing.

    Parameters
    ----------
    base : Fit
        The model, which leaves noise only.
    fits : iterable of Fit
        It with one effect more each.
    """
    known = evidence(base, base)
    more = [(evidence(fit, base) - known, fit) for fit in fits if np.isfinite(fit.bic)]
    best = max((gain for gain, _ in more), default=0.0)
    return tuple(
        name for gain, fit in more if gain > max(RIVAL, best - RIVAL) for name in _names(fit, base)
    )


def promise_evidence(fit: Fit, effect: Effect, cost: float, base: Fit) -> float:
    """Return the evidence of a model with one effect more, if it left a cost.

    Parameters
    ----------
    fit : Fit
        The model without the effect.
    effect : Effect
        The added effect.
    cost : float
        The promised cost.
    base : Fit
        The model that was asked about.
    """
    samples = float(fit.samples)
    gain = 0.5 * samples * (np.log(fit.cost) - np.log(max(cost, np.finfo(float).tiny)))
    learnt = 0.5 * len(effect.parameters) * np.log(samples)
    known = _effects(fit, base)
    return evidence(fit, base) + float(gain - learnt) + prior([*known, effect]) - prior(known)


def weigh_model(fit: Fit, base: Fit) -> float:
    """Return the logarithm of a model's odds without its likelihood.

    By the odds of its effects, and by the Bayesian information criterion for the values that it has
    to learn (G. Schwarz, Ann. Statist. 6 (1978), 461).
    """
    line = LINE if is_multiple(fit) else 0.0
    return -0.5 * (fit.bic - fit.misfit) + prior(_effects(fit, base)) - line


def prior(effects: Sequence[Effect]) -> float:
    """Return the logarithm of the odds of effects before anything is measured, against none.

    One of all effects of the library is missing as likely as none is; a second one is seldom
    missing beside it. An effect without odds is in a model because somebody asked for it.
    """
    told = sum(np.log((each.odds or 1.0) / library_size()) for each in effects)
    return float(told) - SECOND * max(len(effects) - 1, 0)


@cache
def library_size() -> int:
    """Count the effects of the library; a user's own change the odds of each by little."""
    from tissue_probe.physics.effects import EFFECTS

    return len(EFFECTS)


def _unknown(left: float) -> float:
    """Return the probability that no model is right, by the adequacy of the best."""
    return float(1.0 / (1.0 + np.exp(min(-UNKNOWN * (left - 1.0), 500.0))))


def _with_twins(weighed: Sequence[_Weighed], base: Fit) -> list[_Weighed]:
    """Make models as probable as the most probable one that are the same function of the record.

    Such a twin leaves noise only, and is as likely but for chance. It has no more effects, and no
    more values that are off their bounds; neither contains the other. The record tells nothing
    between both, and the number of values that an effect declares says nothing of the tissue. The
    prior odds of the effects still count. A model that contains a twin is no twin.
    """
    best, most = weighed[0]
    twins = [told for told, _ in weighed if _are_twins(told, best, base)]
    extended = [told for told in twins if any(_contains(told.fit, each.fit) for each in twins)]
    alike = [told for told in twins if told not in extended]
    before = prior(_effects(best.fit, base))
    as_sure = {told: most + prior(_effects(told.fit, base)) - before for told in alike}
    found = [(told, as_sure.get(told, weight)) for told, weight in weighed]
    return sorted(found, key=lambda pair: -pair[1])


def _are_twins(told: _WeightedFit, best: _WeightedFit, base: Fit) -> bool:
    """Whether a model is the same function of the record as the best, of other families."""
    fit, other = told.fit, best.fit
    return (
        sorted(_families(fit, base)) != sorted(_families(other, base))
        and 0 < len(_names(fit, base)) <= len(_names(other, base))
        and abs(best.likely - told.likely) <= 0.5 * FORMS_BY_CHANCE
        and leaves_only_noise(fit)
        and leaves_only_noise(other)
        and not _contains(fit, other)
        and not _contains(other, fit)
        and not _at_an_end(fit, base)
        and _told_off_bounds(fit) <= _told_off_bounds(other)
    )


def _told_off_bounds(fit: Fit) -> int:
    """How many values of a model are off their bounds beyond chance.

    Of a mass that is not there chance decides whether its value ends at zero, or near it.
    """
    named, deviations = fit.named(), fit.deviations()
    by = FORMS_BY_CHANCE**0.5
    return sum(
        0.0 < by * deviations[e.name] < min(named[e.name] - e.lower, e.upper - named[e.name])
        for e in fit.entries
    )


def _at_an_end(fit: Fit, base: Fit) -> bool:
    """Whether an effect ended at a bound of its values, where it is another effect, or none."""
    values = {value.name for effect in _effects(fit, base) for value in effect.parameters}
    return not values.isdisjoint(fit.exhausted)


def _contains(fit: Fit, other: Fit) -> bool:
    """Whether another model is a special case of a model by their effects."""
    within = {name for each in fit.composition.effects for name in (each.name, *each.simpler)}
    return fit is not other and within.issuperset(other.composition.names)


def _temper_group(
    group: Sequence[_WeightedFit], known: Mapping[frozenset[str], Fit]
) -> list[_Weighed]:
    """Share the evidence of a group of forms among them, told apart as far as forms may be.

    Where an effect removes E of the cost, its form leaves FORM_SHARE^2 E of that, if it is right to
    that share: one that leaves D more than the likeliest is less likely by exp(-D / 2 (1 +
    FORM_SHARE^2 E)). Effects that both models have remove nothing here: their form is the same in
    both. Values that have to be learnt cost the same: of a value that may be anything a law that is
    right to FORM_SHARE tells so much that log(1 / FORM_SHARE) is as large as the criterion's
    penalty. But no form that leaves more than noise is more probable than one that leaves noise
    only, however simple it is.
    """
    likely = np.array([each.likely for each in group])
    thought = np.array([each.thought for each in group])
    first = int(np.argmax(likely + thought))
    best, samples = group[first].fit, group[first].fit.samples
    removed = np.array(
        [max(_without_forms(best, each.fit, known) - best.cost, 0.0) for each in group]
    )
    more = samples * np.expm1(np.minimum((2.0 / samples) * (likely[first] - likely), MUCH))
    told = thought - 0.5 * more / (1.0 + FORM_SHARE**2 * removed)
    enough = np.array([leaves_only_noise(each.fit) for each in group])
    if enough.any():
        told = np.where(enough, told, np.minimum(told, told[enough].max()))
    shares = told - np.logaddexp.reduce(told) + np.logaddexp.reduce(likely + thought)
    return [(each, float(share)) for each, share in zip(group, shares, strict=True)]


def _without_forms(one: Fit, other: Fit, known: Mapping[frozenset[str], Fit]) -> float:
    """Return the cost of the model that has only effects of both of two models."""
    common = frozenset(one.composition.names) & frozenset(other.composition.names)
    return min(fit.cost for names, fit in known.items() if names <= common)


def _best_of_each(fits: Iterable[Fit]) -> dict[frozenset[str], Fit]:
    best: dict[frozenset[str], Fit] = {}
    for fit in fits:
        names = frozenset(fit.composition.names)
        if np.isfinite(fit.bic) and (names not in best or fit.bic < best[names].bic):
            best[names] = fit
    return best


def _is_another(fit: Fit, best: Mapping[frozenset[str], Fit], base: Fit) -> bool:
    """Whether an effect ended in the limit where it is a simpler one, which does as well there.

    That is: the simpler one leaves noise only, or is no rival that a set of models leaves out.
    """
    names, named = frozenset(fit.composition.names), fit.named()
    others = [
        best[each]
        for effect in fit.composition.effects
        if is_at_limit(effect, named)
        for simpler in effect.simpler
        if (each := names - {effect.name} | {simpler}) in best
    ]
    least = evidence(fit, base) - RIVAL
    return any(leaves_only_noise(other) or evidence(other, base) > least for other in others)


def _is_nothing(effect: Effect, fit: Fit) -> bool:
    """Whether every strength of an effect ended where it changes nothing."""
    strengths, named = effect.parameters[: effect.strengths], fit.named()
    return bool(strengths) and all(
        each.name in fit.exhausted and named[each.name] == effect.neutral for each in strengths
    )


def is_at_limit(effect: Effect, named: Mapping[str, float]) -> bool:
    """Whether an effect that contains a simpler one ended in the limit where it is that.

    Within ``FORM_SHARE``: no law's form is righter than that.
    """
    limits = [each for each in effect.parameters if each.name == effect.limit]
    return any(named[each.name] <= (1.0 + FORM_SHARE) * each.lower for each in limits)


def _effects(fit: Fit, base: Fit) -> tuple[Effect, ...]:
    return fit.composition.effects[len(base.composition.effects) :]


def _names(fit: Fit, base: Fit) -> tuple[str, ...]:
    return tuple(each.name for each in _effects(fit, base))


def _families(fit: Fit, base: Fit) -> list[str]:
    return [each.family for each in _effects(fit, base)]
