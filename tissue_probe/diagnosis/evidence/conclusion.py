"""The models from the base to the most probable one, and the verdict on them.

Contents: the verdict, and the rules that decide it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from tissue_probe.diagnosis.evidence.adequacy import ROUGHLY, excess_of, leaves_only_noise, removes
from tissue_probe.diagnosis.evidence.posterior import (
    FORM_SHARE,
    SURE_PROBABILITY,
    ModelPosterior,
    posterior,
)
from tissue_probe.diagnosis.fitting.fit import Fit

Verdict = Literal["adequate", "missing", "ambiguous", "unexplained"]


@dataclass(frozen=True)
class Ladder:
    """The models from the base to the best, and the candidates for the first step.

    Attributes
    ----------
    base : Fit
        The model that was asked about.
    ranking : tuple of Fit
        The base with each effect of the library, the most probable first.
    steps : tuple of Fit
        Models that were accepted one after the other; none where the base is adequate.
    tried : tuple of Fit
        All models that were tried, of each set of effects one.
    posterior : Posterior
        How probable they are.
    verdict : str
        "adequate", "missing", "ambiguous" or "unexplained".
    family : str or None
        Family of which some effect is surely missing, where no form of it is sure.
    harmonic : float or None
        Frequency [Hz] of a line that explains more than the effects do, see ``better_harmonic``.
    asked : bool
        Whether the effects were asked for, and no others tried.
    curtailed : bool
        Whether more is left than noise, and not all was tried that might explain it.
    revisions : tuple of str
        Names of the revisions of the samples and of their weights that models asked for, in their
        order.
    """

    base: Fit
    ranking: tuple[Fit, ...]
    steps: tuple[Fit, ...]
    tried: tuple[Fit, ...]
    posterior: ModelPosterior
    verdict: Verdict
    family: str | None = None
    harmonic: float | None = None
    asked: bool = False
    curtailed: bool = False
    revisions: tuple[str, ...] = ()

    def exchange_model(self, old: Fit, new: Fit) -> Ladder:
        """Return the same, of a model of which more is known: wherever it stands, another."""

        def exchange_fits(fits: tuple[Fit, ...]) -> tuple[Fit, ...]:
            return tuple(new if fit is old else fit for fit in fits)

        told = replace(self.posterior, models=exchange_fits(self.posterior.models))
        if self.base is old:
            told = replace(told, base=new)
        return replace(
            self,
            base=new if self.base is old else self.base,
            ranking=exchange_fits(self.ranking),
            steps=exchange_fits(self.steps),
            tried=exchange_fits(self.tried),
            posterior=told,
        )

    @property
    def final(self) -> Fit:
        """The model of the last step."""
        return self.steps[-1] if self.steps else self.base

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that were added."""
        return self.posterior.more(self.final)

    @property
    def rivals(self) -> tuple[Fit, ...]:
        """The likely models, the last step's first; it alone where that is sure or unlikely."""
        likely = self.posterior.likely
        return likely if self.steps and self.final is likely[0] else self.steps[-1:]

    @property
    def tied(self) -> tuple[str, ...]:
        """Effects by which the rivals differ; where there is one only, the first that was added."""
        if not self.rivals:
            return ()
        return name_differences(self.rivals) or (self.steps[0].composition.names[-1],)

    @property
    def alternatives(self) -> tuple[tuple[str, ...], ...]:
        """Names of the effects that each of several rivals adds; none where one is alone."""
        return tuple(map(self.posterior.more, self.rivals)) if len(self.rivals) > 1 else ()


def conclude_search(
    base: Fit,
    ranking: Sequence[Fit],
    steps: Sequence[Fit],
    tried: Sequence[Fit] = (),
    second: Mapping[frozenset[str], float] | None = None,
) -> Ladder:
    """Name the missing effects, by the probabilities of the models that were tried.

    The most probable one is the last step, whether it leaves noise only or not: the named model is
    never less probable than those beside it.

    Parameters
    ----------
    base : Fit
        The model that was asked about.
    ranking : sequence of Fit
        It with one effect more, the best first.
    steps : sequence of Fit
        The models that the search went through.
    tried : sequence of Fit
        Others that it tried.
    second : mapping, optional
        See ``posterior``.
    """
    every = (*ranking, *tried, *steps)
    told = posterior(base, every, second)
    best = told.models[0]
    accepted, steps = bool(steps), _path(best, ranking, steps, told)
    ladder = Ladder(base, tuple(ranking), tuple(steps), every, told, "unexplained")
    family = _family(told)
    if leaves_only_noise(best):
        sure = len(told.likely) == 1
        family = None if sure else family
        verdict: Verdict = "missing" if sure else "ambiguous"
        return _order_ranking(
            replace(ladder, verdict=verdict if ladder.steps else "adequate", family=family)
        )
    # Where no form was accepted none of them is nearly right.
    if family and accepted and (nearest := _nearest(family, told)):
        return _order_ranking(replace(ladder, steps=(nearest,), verdict="ambiguous", family=family))
    return ladder


def name_differences(rivals: Sequence[Fit]) -> tuple[str, ...]:
    """Name the effects by which models differ, those of the first model first."""
    named = [fit.composition.names for fit in rivals]
    common = set(named[0]).intersection(*named[1:])
    return tuple(dict.fromkeys(n for names in named for n in names if n not in common))


def _family(told: ModelPosterior) -> str | None:
    """Return the family that is sure, though none of its forms is."""
    for family, probability in told.families.items():
        own = {
            effect.name
            for fit in told.models
            for effect in fit.composition.effects
            if effect.family == family and effect.name in told.more(fit)
        }
        if probability >= SURE_PROBABILITY and all(
            told.effect(name) < SURE_PROBABILITY for name in own
        ):
            return family
    return None


def _nearest(family: str, told: ModelPosterior) -> Fit | None:
    """Return the best form of a family, alone; None where it is not nearly right.

    Models of more effects may be more probable. Then the residual of the form must be no larger
    than the noise, of any colour, and most of the base's error beyond the noise must be gone; or it
    must be no larger than the error of a law's form (``FORM``). Else the residual is another
    effect's.
    """
    alone = [
        fit
        for fit in told.models
        if len(told.more(fit)) == 1 and fit.composition.effects[-1].family == family
    ]
    nearest = min(alone, key=lambda fit: fit.ratio, default=None)
    if nearest is None or nearest.ratio >= ROUGHLY:
        return None
    removed = told.base.ratio**2 - nearest.ratio**2
    nearly = excess_of(nearest) < 1.0 and removes(told.base, nearest)
    little = nearly or nearest.ratio**2 - 1.0 <= FORM_SHARE**2 * removed
    return nearest if little or len(told.more(told.models[0])) == 1 else None


def _path(
    best: Fit, ranking: Sequence[Fit], steps: Sequence[Fit], told: ModelPosterior
) -> list[Fit]:
    """Return models up to the best, each with effects of it only, as far as there are such."""
    names, more = set(best.composition.names), told.more(best)
    if not more:
        return []
    earlier = [fit for fit in steps if set(fit.composition.names) < names and fit is not best] or [
        fit for fit in ranking if fit.composition.names[-1] in more and len(more) > 1
    ][:1]
    return [*earlier, best]


def _order_ranking(ladder: Ladder) -> Ladder:
    """Put the most probable effect first in the ranking, of equally probable ones the better."""
    order = sorted(
        ladder.ranking,
        key=lambda fit: -round(ladder.posterior.effect(fit.composition.names[-1]), 3),
    )
    return replace(ladder, ranking=tuple(order))
