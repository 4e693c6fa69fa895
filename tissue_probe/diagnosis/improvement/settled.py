"""Models that explain one recording equally well, told apart by their error on another.

What belongs here: the choice. What does not: the errors (``diagnosis``), the models (``ladder``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.improvement.ladder import Ladder
from tissue_probe.diagnosis.ranking.rules import added

#: Residuals, and errors on another recording, are alike up to this factor.
ALIKE = 1.02


def settled(ladder: Ladder, errors: Mapping[tuple[str, ...], float]) -> Ladder:
    """Choose among models that explain one recording equally well by their error on another.

    Of those that are as good on both, the criterion's order stands: it counts parameters.

    Parameters
    ----------
    ladder : Ladder
        Of the recording that was fitted.
    errors : mapping of tuple of str to float
        Error [N] on the other recording, by the names of a model's effects.
    """
    if not ladder.steps or ladder.verdict == "unexplained":
        return ladder
    if len(ladder.steps) > 1:
        proved = _proved(ladder.rivals, errors)
        return _ending(ladder, proved) if proved else ladder
    near = [fit for fit in ladder.ranking if fit.ratio <= ALIKE * ladder.final.ratio]
    proved = _proved(near, errors)
    if not proved:
        return ladder
    names = {added(fit).name for fit in proved}
    ranking = sorted(ladder.ranking, key=lambda fit: added(fit).name not in names)
    tied = [fit for fit in proved if fit is ranking[0] or added(fit).name in ladder.tied]
    return _ending(replace(ladder, ranking=tuple(ranking)), tied)


def _proved(rivals: Sequence[Fit], errors: Mapping[tuple[str, ...], float]) -> list[Fit]:
    """Return the models that are as good as the best on another recording."""
    tried = [fit for fit in rivals if fit.composition.names in errors]
    bar = ALIKE * min((errors[fit.composition.names] for fit in tried), default=0.0)
    return [fit for fit in tried if errors[fit.composition.names] <= bar]


def _ending(ladder: Ladder, rivals: Sequence[Fit]) -> Ladder:
    """Let a ladder end with the first of models that cannot be told apart."""
    final = rivals[0]
    names = set(final.composition.names)
    earlier = [fit for fit in ladder.steps[:-1] if names.issuperset(fit.composition.names)]
    if len(ladder.steps) > 1 and not earlier:
        earlier = [fit for fit in ladder.ranking if added(fit).name in names][:1]
    return replace(
        ladder,
        steps=(*earlier, final),
        rivals=tuple(rivals),
        verdict="ambiguous" if len(rivals) > 1 else "missing",
    )
