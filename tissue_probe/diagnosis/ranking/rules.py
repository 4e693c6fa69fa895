"""Which effect is missing: the candidates in order, and what may be said of them.

What belongs here: the rules by which fits are compared, and the verdict.
What does not: fitting (``search``, ``candidates``), further effects (``improvement``).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.residuals.whiteness import SLOW

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

#: A better fit is real where the BIC falls by more than this and the residual by this share.
LEAST_GAIN, LEAST_SHARE = 20.0, 0.003
#: Fits whose BIC is within this of the best are not distinguished from it.
TIE = 14.0
#: An effect that contains a simpler one stands back where its BIC gains less than this, or the
#: residual less than the share above.
SIMPLER = 30.0
#: But is told beside it where it gains at least this: strong evidence (Kass and Raftery 1995).
STRONG = 6.0
#: Residual over noise up to which nothing is left to explain, of many samples; of few the noise is
#: not known so well: its estimate varies by one over the root of their number, and so many times
#: that are granted, which one recording in a hundred exceeds.
EXPLAINED, UNKNOWN = 1.07, 3.0
#: Square of the residual over noise below which the noise is another than it was taken for: more
#: than half of it is not there.
NOT_THERE = 0.5
#: The same where an encoder's rounding is as large as the noise: its size is known roughly. Where
#: it is less, but at least this share, it may still have any colour.
ROUGHLY, ROUNDING = 1.2, 0.15
#: And the residual's rms below a sixteenth of the sampling rate over that above: it is white. Of
#: few samples noise varies more: so many standard deviations of white noise are granted, more than
#: it ever has, since a fine encoder rounds a steady sine alike in every period.
WHITE, RARE = 1.12, 5.0
#: And how far an octave of it may stand out, in what is usual for noise.
EVEN = 8.0
#: And the sum of squared departures, in standard deviations, from the rig's tolerances and starts.
STRAINED = 30.0
#: Share of these limits within which a residual is noise beyond doubt.
BEYOND_DOUBT = 0.6

#: The family of what recedes from the tip.
RELAXATION = "relaxation"
#: Families whose effects are forms of one law: beside one of them another only bends it. Of an
#: encoder with coarse steps nothing finer is known.
FORMS = (RELAXATION, "stiffening", "friction", "time-varying", "encoder")


def significant(simple: Fit, better: Fit) -> bool:
    """Whether the second fit explains more than noise would let it, or a rig that is unlikely.

    Where it alone explains all, it need only be told from the first.
    """
    needed = TIE if explained(better) and not explained(simple) else LEAST_GAIN
    less = better.ratio < (1.0 - LEAST_SHARE) * simple.ratio
    likelier = better.strain < STRAINED <= simple.strain
    return simple.bic - better.bic > needed and (less or likelier)


def explained(fit: Fit) -> bool:
    """Whether a fit leaves noise only: no more than there is, white, and with a likely rig.

    An encoder's rounding, of which more than its size is not known, may have any colour.
    """
    share, most = fit.rounding / fit.noise, most_left(fit.samples)
    if share > ROUNDING:
        return fit.ratio < most + max(ROUGHLY - most, 0.0) * min(share**2, 1.0)
    noise = fit.ratio < most and not is_quiet(fit)
    return noise and _is_white(fit) and fit.strain < STRAINED


def is_quiet(fit: Fit) -> bool:
    """Whether more than half of the noise that a fit counts is not there."""
    return fit.ratio**2 <= NOT_THERE


def most_left(samples: int) -> float:
    """Return the residual over noise up to which so many samples leave nothing to explain."""
    return max(EXPLAINED, 1.0 + UNKNOWN * samples**-0.5)


def _is_white(fit: Fit) -> bool:
    """Whether what a fit leaves has the colour of noise."""
    return fit.colour < whitest(fit.samples) and fit.unevenness < EVEN


def whitest(samples: int) -> float:
    """Return the largest colour that so many samples of white noise may have."""
    return max(WHITE, 1.0 + RARE * (SLOW / (2.0 * samples)) ** 0.5)


def beyond_doubt(fit: Fit) -> bool:
    """Whether a fit leaves noise only, far from the limits of what noise may be."""
    return explained(fit) and (
        fit.ratio - 1.0 < BEYOND_DOUBT * (most_left(fit.samples) - 1.0)
        and fit.colour - 1.0 < BEYOND_DOUBT * (WHITE - 1.0)
        and fit.unevenness < BEYOND_DOUBT * EVEN
        and fit.strain < BEYOND_DOUBT * STRAINED
    )


def doubtful(fit: Fit) -> bool:
    """Whether an encoder's rounding, known roughly, may pass for what a fit leaves.

    It leaves more than it should beyond doubt, or what has a colour that fine steps do not give.
    """
    much = fit.ratio - 1.0 > BEYOND_DOUBT * (most_left(fit.samples) - 1.0)
    coloured = not (_is_coarse(fit) or _is_white(fit))
    return fit.rounding > ROUNDING * fit.noise and (much or coloured)


def only_rounding(fit: Fit) -> bool:
    """Whether an encoder's rounding alone is as large as what a fit leaves.

    More than its size is not known, and among the few lines of a steady motion any further
    parameter may follow it: a fit that leaves less is no better.
    """
    return explained(fit) and fit.rounding > ROUNDING * fit.noise and fit.ratio <= 1.0


def preferred(fits: Iterable[Fit]) -> list[Fit]:
    """Order fits by BIC.

    Where the coarse steps of an encoder explain all and the best does not, they come first: they
    are there to be seen, and what smooths the force instead (a lag) may do better by a criterion
    that takes their noise for white.
    """
    order = sorted(fits, key=lambda fit: fit.bic)
    if order and not explained(order[0]):
        order.sort(key=lambda fit: not (_is_coarse(fit) and explained(fit)))
    return order


def _is_coarse(fit: Fit) -> bool:
    """Whether a model reads an encoder in coarse steps."""
    return any(effect.rounded != 0 for effect in fit.composition.effects)


def ranked(fits: Sequence[Fit]) -> list[Fit]:
    """Order fits with one effect more, a simpler effect before one that contains it."""
    order = preferred(fits)
    for fit in list(order):
        for name in added(fit).simpler:
            simpler = next((each for each in order if added(each).name == name), None)
            if simpler is None or gains_much(simpler, fit):
                continue
            if order.index(simpler) > order.index(fit):
                order.remove(simpler)
                order.insert(order.index(fit), simpler)
    return order


def gains_much(simpler: Fit, fit: Fit) -> bool:
    """Whether a fit with an effect that contains the other's is worth what it has more.

    One that ends in the limit where it is the other, or follows an encoder's rounding, is not.
    Where it alone explains all, it need only be told from the other.
    """
    if only_rounding(simpler) or in_limit(fit):
        return False
    share = 1.0 - fit.ratio / simpler.ratio
    needed = TIE if explained(fit) and not explained(simpler) else SIMPLER
    return simpler.bic - fit.bic > needed and share > LEAST_SHARE


def in_limit(fit: Fit) -> bool:
    """Whether an effect that contains a simpler one ended in the limit where it is that."""
    limits = [each for each in added(fit).parameters if each.name == added(fit).limit]
    return any(fit.named()[each.name] <= each.lower for each in limits)


def ties(order: Sequence[Fit]) -> list[Fit]:
    """Return the fits that cannot be told from the first: as good, and not containing it.

    Where there are several, another form of one of them that leaves as little may be there as
    well: what cannot tell relaxation from a bias cannot tell how many branches relax.
    """
    tied = alike(order[0], order)
    if len(tied) == 1:
        return tied
    least: dict[str, float] = {}
    for fit in tied:
        family = added(fit).family
        if family in FORMS:
            least[family] = min(fit.cost, least.get(family, np.inf))
    others = (fit for fit in order if fit not in tied)
    return tied + [fit for fit in others if fit.cost < least.get(added(fit).family, -np.inf) + TIE]


def alike(final: Fit, others: Iterable[Fit]) -> list[Fit]:
    """Return a model, and those as good that differ from it in one effect.

    One that contains the other does as well wherever that is right: it must do better to be told.
    """
    found = [final]
    for fit in others:
        own, lost = _not_in(final, fit), _not_in(fit, final)
        if len(own) == len(lost) == 1:
            contains = lost[0].name in own[0].simpler
            told = _is_likelier(fit, final) if contains else _as_good(fit, final)
            found += [fit] if told else []
    return found


def _not_in(model: Fit, fit: Fit) -> list[Effect]:
    """Return the effects of a fit that a model has not."""
    return [each for each in fit.composition.effects if each.name not in model.composition.names]


def _is_likelier(fit: Fit, final: Fit) -> bool:
    """Whether there is strong evidence for a fit that stands back behind one that it contains.

    Of many samples any model that is not quite right gains more: a gain that is large, and yet no
    share of the residual, is none. Nor is one that follows an encoder's rounding.
    """
    return STRONG <= final.bic - fit.bic <= SIMPLER and not only_rounding(final)


def _as_good(fit: Fit, final: Fit) -> bool:
    """Whether a fit cannot be told from a final one: not by what else it must learn of its start.

    What was before the first sample is unknown, and has to be learnt by one and not by the other.
    """
    more = max(fit.start_penalty - final.start_penalty, 0.0)
    return fit.bic - more < final.bic + TIE


def differing(rivals: Sequence[Fit]) -> tuple[str, ...]:
    """Name the effects by which models differ, those of the first model first."""
    named = [fit.composition.names for fit in rivals]
    common = set(named[0]).intersection(*named[1:])
    return tuple(dict.fromkeys(n for names in named for n in names if n not in common))


def added(fit: Fit) -> Effect:
    """Return the effect that a fit has more than the model it was added to."""
    return fit.composition.effects[-1]
