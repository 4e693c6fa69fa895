"""Adding effect after effect until the residual is noise.

What belongs here: the ladder from the base model to the one that is left, and its verdict.
What does not: fitting one model (``search``), comparing models (``ranking``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.measurement import Instrument, Measurement
from tissue_probe.diagnosis.improvement.exchange import anew, both_exchanged, exchanged, kin_of
from tissue_probe.diagnosis.improvement.further import RELATED, SHARE, Further, Path, addable, asked
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates, refit
from tissue_probe.diagnosis.ranking.harmonic import better_harmonic, is_multiple
from tissue_probe.diagnosis.ranking.rules import (
    EXPLAINED,
    FORMS,
    RELAXATION,
    SIMPLER,
    TIE,
    added,
    alike,
    beyond_doubt,
    differing,
    doubtful,
    explained,
    preferred,
    ranked,
    significant,
    ties,
)
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import Effect

Verdict = Literal["adequate", "missing", "ambiguous", "unexplained"]
#: Residuals, and errors on another recording, are alike up to this factor.
ALIKE = 1.02
#: Effects on which a second is tried, if there are so many of different families; effects in all.
BEAM, MOST = 3, 3
#: One of two effects must alone remove this share of what exceeds the noise, and the first for a
#: third to be sought: among the few lines of a steady motion several that alone explain nothing can
#: make up for any.
LEADING = 0.2
#: None is tried on an effect that alone leaves this many times the best's cost.
BEHIND = 25.0


@dataclass(frozen=True)
class Ladder:
    """The models from the base to the best, and the candidates for the first step.

    Attributes
    ----------
    base : Fit
        The model that was asked about.
    ranking : tuple of Fit
        The base with each effect of the library, the best first.
    steps : tuple of Fit
        Models that were accepted one after the other; none where the base is adequate.
    rivals : tuple of Fit
        Models that explain the measurement equally well, the last step's first.
    verdict : str
        "adequate", "missing", "ambiguous" or "unexplained".
    harmonic : float or None
        Frequency [Hz] of a line that explains more than the effects do, see ``better_harmonic``.
    asked : bool
        Whether the effects were asked for, and no others tried.
    """

    base: Fit
    ranking: tuple[Fit, ...]
    steps: tuple[Fit, ...]
    rivals: tuple[Fit, ...]
    verdict: Verdict
    harmonic: float | None = None
    asked: bool = False

    @property
    def final(self) -> Fit:
        """The model of the last step."""
        return self.steps[-1] if self.steps else self.base

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that were added."""
        return self._more(self.final)

    @property
    def tied(self) -> tuple[str, ...]:
        """Effects by which the rivals differ; where there is one only, the first that was added."""
        if not self.rivals:
            return ()
        return differing(self.rivals) or (added(self.steps[0]).name,)

    @property
    def alternatives(self) -> tuple[tuple[str, ...], ...]:
        """Names of the effects that each of several rivals adds; none where one is alone."""
        return tuple(map(self._more, self.rivals)) if len(self.rivals) > 1 else ()

    def _more(self, fit: Fit) -> tuple[str, ...]:
        return fit.composition.names[len(self.base.composition.names) :]


def climb(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    library: Mapping[str, Effect],
    begin_at: Mapping[str, float] | None = None,
) -> Ladder:
    """Fit a model, and add to it what is missing.

    Parameters
    ----------
    composition : Composition
        The model to begin with.
    measurements : sequence of Measurement
        All of one specimen.
    instrument : Instrument
        What is known of the rig.
    library : mapping of str to Effect
        What may be added.
    begin_at : mapping of str to float, optional
        Values at which the search for the model itself begins, see ``fit_base``.
    """
    base = fit_base(composition, measurements, instrument, begin_at)
    allowed = addable(composition, library).values()
    ranking = ranked(fit_candidates(base, allowed, instrument))
    if not ranking or not significant(base, ranking[0]):
        verdict: Verdict = "adequate" if explained(base) else "unexplained"
        return Ladder(base, tuple(ranking), (), (), verdict)
    near = [fit for fit in ranking if fit.cost < BEHIND * ranking[0].cost]
    leading = [fit for fit in near if _leads(base, fit)]
    paths = _begun([fit for fit in near if significant(base, fit)])
    further = Further(base, instrument, library, [added(fit).name for fit in leading])
    best = paths[0]
    # Where none leads, no two effects are accepted.
    while leading and (not explained(best[-1]) or doubtful(best[-1])) and _is_worth(base, best):
        longest = _longest(further, paths, ranking, leading)
        if not longest or not _removes(best[-1], longest[-1]):
            break
        longest = tuple(exchanged(longest, ranking, further))
        longest = _beside_each(longest, ranking, leading, further)
        if not any(_leads(base, fit) for fit in _alone(longest[-1], ranking)):
            break
        best, paths = longest, [longest]
    steps = _needed(best, further)
    first = steps[0]
    if len(steps) == 1:
        ranking = _bettered(ranking, first)
    if len(steps) > 1:
        rivals = alike(steps[-1], further.tried.values())
    else:
        rivals = ties(ranking) if added(first) is added(ranking[0]) else [first]
    harmonic = better_harmonic(base, steps[-1], instrument) if explained(steps[-1]) else None
    verdict = "missing" if explained(steps[-1]) and harmonic is None else "unexplained"
    if verdict == "missing" and len(rivals) > 1:
        verdict = "ambiguous"
    return Ladder(base, tuple(ranking), tuple(steps), tuple(rivals), verdict, harmonic)


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


def climb_by(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    wanted: Sequence[Effect],
    begin_at: Mapping[str, float] | None = None,
) -> Ladder:
    """Fit a model, and add the effects that are asked for, one by one; else as ``climb``.

    Raises
    ------
    ValueError
        If one of them cannot be fitted.
    """
    base = fit_base(composition, measurements, instrument, begin_at)
    steps: list[Fit] = []
    for effect in wanted:
        found = fit_candidates([base, *steps][-1], [effect], instrument)
        if not found:
            raise ValueError(
                f"{effect.name} cannot be fitted to these measurements of a {composition.rig}"
            )
        steps += found
    verdict: Verdict = "missing" if significant(base, steps[-1]) else "adequate"
    if not explained(steps[-1]):
        verdict = "unexplained"
    return Ladder(base, tuple(steps[:1]), tuple(steps), (), verdict, asked=True)


def _longest(
    further: Further, paths: Sequence[Path], ranking: Sequence[Fit], leading: Sequence[Fit]
) -> Path:
    """Return the best path with one effect more.

    The second may have been found beside a first that only stands for another: whatever else goes
    with it is tried. Where none leaves noise beyond doubt, those that promise less are tried, too;
    where none leaves noise, lost contact beside relaxing tissue is tried in every form, as no
    promise tells of it; then all beside other forms of a first, and simpler ones; then the best
    first beside each that alone leads somewhere: to some pairs a way leads from one only.
    """
    longer = further.of(paths)
    best = anew(longer[0], further) if longer else ()
    if len(paths[0]) > 1:
        return best
    best = _better(best, further.of(_turned(best, paths, ranking)), further)
    if best and beyond_doubt(best[-1]):
        return best
    best = _better(best, further.of(paths[:1], promising=False), further)
    if best and explained(best[-1]):
        return best
    relaxing = [fit for fit in leading if added(fit).family == RELAXATION][:1]
    best = _better(best, further.losing_contact(relaxing, _asked(best)), further)
    if best and explained(best[-1]):
        return best
    others = [*further.reformed(paths), *_simpler(paths[0], ranking)]
    best = _better(best, further.of(others), further)
    if best and explained(best[-1]):
        return best
    return _better(best, further.towards(paths[0][0], _forms(leading), _asked(best)), further)


def _asked(path: Path) -> float:
    """Return the cost that is asked of what is tried late: a good part less than was reached."""
    return asked(path[-1]) if path else np.inf


def _simpler(path: Path, ranking: Sequence[Fit]) -> list[Path]:
    """Return paths that begin with what a first effect contains: it may have followed a second."""
    return [(fit,) for fit in ranking if added(fit).name in added(path[0]).simpler]


def _beside_each(
    path: Path, ranking: Sequence[Fit], leading: Sequence[Fit], further: Further
) -> Path:
    """Try whatever else goes with either of two effects, until nothing does better.

    Both may have to give way at once, too. What does as well is noted, and told in the end.
    """
    while len(path) == 2:
        kin = [kin_of(added(each), ranking) for each in path]
        if not all(kin):
            break
        others = further.unasked([(fits[0],) for fits in kin], path[-1])
        others += both_exchanged(path[-1], kin, further)
        if explained(path[-1]):
            others += _from_beside(path[-1], kin, leading, further)
        found = _better(path, sorted(others, key=lambda each: each[-1].bic), further)
        if found is path:
            break
        path = tuple(exchanged(found, ranking, further))
    return path


def _from_beside(
    final: Fit, kin: Sequence[Sequence[Fit]], leading: Sequence[Fit], further: Further
) -> list[Path]:
    """Return paths to each of two effects from what alone is as good as the other, of any family.

    Found from its own side it may have gone astray. Only beside what leads somewhere: what alone
    explains nothing is as good as any other.
    """
    found: list[Path] = []
    for (own, *_), (other, *_) in (kin, kin[::-1]):
        near = [fit for fit in leading if fit.cost < RELATED * own.cost] if own in leading else []
        asked = [fit for fit in near if not further.explains(fit, other)]
        found += further.towards(other, asked, final.cost + SIMPLER)
    return found


def _better(path: Path, others: Sequence[Path], further: Further) -> Path:
    """Return the best of others, if it is better than a path, its first effect searched anew.

    Of two ways to the same effects that end as well, the one stays that was found first.
    """
    if not others:
        return path
    found = others[0]
    if path:
        final, other = path[-1], found[-1]
        same = set(final.composition.names) == set(other.composition.names)
        if preferred([final, other])[0] is final or (same and final.bic <= other.bic + TIE):
            return path
    return anew(found, further)


def _turned(path: Path, paths: Sequence[Path], ranking: Sequence[Fit]) -> list[Path]:
    """Return the path that begins with the last effect of another, unless it was tried already."""
    tried = {added(each[0]).name for each in paths}
    last = {added(path[-1]).name} - tried if path else set()
    return [(fit,) for fit in ranking if added(fit).name in last]


def _forms(ranking: Sequence[Fit]) -> list[Fit]:
    """Leave out all forms of a law but the best, which gives way to them where they do better."""
    best: dict[str, Fit] = {}
    for fit in ranking:
        law = added(fit).family if added(fit).family in FORMS else added(fit).name
        best.setdefault(law, fit)
    return list(best.values())


def _begun(ranking: Sequence[Fit]) -> list[Path]:
    """Return the paths to begin with.

    Those come last, and take no place of others, that begin with a hum at a multiple of the drive's
    frequency and do not explain all: it makes up for one line of what is not linear, not for that.
    """
    various = _various(ranking)
    lines = [fit for fit in various if not explained(fit) and is_multiple(fit)]
    others = [fit for fit in various if fit not in lines]
    return [(fit,) for fit in others[:BEAM] + lines]


def _various(ranking: Sequence[Fit]) -> list[Fit]:
    """Put the best of each family before their others."""
    best: dict[str, Fit] = {}
    for fit in ranking:
        best.setdefault(added(fit).family, fit)
    return sorted(ranking, key=lambda fit: fit is not best[added(fit).family])


def _bettered(ranking: Sequence[Fit], found: Fit) -> list[Fit]:
    """Put a fit in the place of a worse one with the same effect: a longer path led to it."""
    others = [fit for fit in ranking if added(fit).name != added(found).name]
    known = [fit for fit in ranking if added(fit).name == added(found).name]
    return ranked([min([found, *known], key=lambda fit: fit.cost), *others])


def _is_worth(base: Fit, path: Sequence[Fit]) -> bool:
    """Whether one more effect is sought: no third one for a rest that is no more than noise."""
    if len(path) == 1:
        return True
    return len(path) < MOST and path[-1].ratio > EXPLAINED and _leads(base, path[0])


def _leads(base: Fit, alone: Fit) -> bool:
    """Whether an effect alone removes a good part of what exceeds the noise."""
    return base.ratio**2 - alone.ratio**2 > LEADING * (base.ratio**2 - 1.0)


def _alone(fit: Fit, ranking: Sequence[Fit]) -> list[Fit]:
    """Return what was found of each of a model's effects alone, and of what they contain."""
    contained = {name for effect in fit.composition.effects for name in effect.simpler}
    names = contained.union(fit.composition.names)
    return [alone for alone in ranking if added(alone).name in names]


def _removes(fit: Fit, better: Fit) -> bool:
    """Whether a further effect removes most of what exceeds the noise, or leaves only noise.

    How much noise there is, is estimated: less may be left of what is no noise than it seems.
    """
    excess, left = fit.ratio**2 - 1.0, better.ratio**2 - 1.0
    enough = left < (1.0 - SHARE) * excess or (beyond_doubt(better) and not explained(fit))
    return significant(fit, better) and enough


def _needed(path: Sequence[Fit], further: Further) -> list[Fit]:
    """Drop what became superfluous: an earlier effect that the last model does without.

    Beside it the others may have been found badly; they are searched once more.
    """
    steps = list(path)
    for fit in path[:-1]:
        less = steps[-1].composition.without(added(fit).name)
        without = refit(steps[-1], less, further.instrument)
        if without is not None and fit is not path[0]:
            without = anew((path[0], without), further)[-1]
        if without is not None and not significant(without, steps[-1]):
            steps = [step for step in steps[:-1] if step is not fit]
            steps = [*steps, without]
    return steps
