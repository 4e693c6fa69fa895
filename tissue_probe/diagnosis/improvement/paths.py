"""Which path is taken: of the models with one effect more, the best that was found.

What belongs here: where paths begin, in which order what may lead further is tried, and what is
better. What does not: what is fitted (``further``, ``exchange``), where it ends (``ladder``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tissue_probe.diagnosis.evidence.line import is_multiple
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.improvement.exchange import anew, both_exchanged, exchanged, kin_of
from tissue_probe.diagnosis.improvement.further import RELATED, Further, Path, asked
from tissue_probe.diagnosis.ranking.rules import (
    RELAXATION,
    SIMPLER,
    TIE,
    added,
    exclude,
    explained,
    in_limit,
    preferred,
)

#: Effects on which a second is tried, if there are so many of different families.
BEAM = 3
#: Of pairs that promise most kin is tried in the place of either in so many that do as well.
AS_GOOD = 2


def begun(ranking: Sequence[Fit]) -> list[Path]:
    """Return the paths to begin with.

    Those come last, and take no place of others, that begin with a hum at a multiple of the drive's
    frequency and do not explain all: it makes up for one line of what is not linear, not for that.
    What ended as a simpler effect is none of its own.
    """
    various = [fit for fit in _various(ranking) if fit is ranking[0] or not in_limit(fit)]
    lines = [fit for fit in various if not explained(fit) and is_multiple(fit)]
    others = [fit for fit in various if fit not in lines]
    return [(fit,) for fit in others[:BEAM] + lines]


def longest(
    further: Further, paths: Sequence[Path], ranking: Sequence[Fit], leading: Sequence[Fit]
) -> Path:
    """Return the best path with one effect more.

    Pairs that promise most come first. Where none leaves noise, all beside each path are tried, and
    the last is taken as the first, too: it may have been found beside one that only stands for
    another; then lost contact beside relaxing tissue is tried in every form, as no promise tells of
    it; then all beside other forms of a first, and simpler ones; then the best first beside each
    that alone leads somewhere: to some pairs a way leads from one only; at last all beside each of
    these. What would not come near what was found is given up, and nothing is begun once enough was
    tried.
    """
    best: Path = ()
    if len(paths[0]) == 1:
        best = _better(best, _promising(further, paths[0][0], ranking, leading), further)
        if best and _is_enough(best, further):
            return best
    best = _better(best, further.of(paths, _end(best)), further)
    if len(paths[0]) > 1 or _is_enough(best, further):
        return best
    best = _better(best, further.of(_turned(best, paths, ranking), _end(best)), further)
    if _is_enough(best, further):
        return best
    relaxing = [fit for fit in leading if added(fit).family == RELAXATION][:1]
    best = _better(best, further.losing_contact(relaxing, _asked(best)), further)
    if _is_enough(best, further):
        return best
    others = [*further.reformed(paths), *_simpler(paths[0], ranking)]
    best = _better(best, further.of(others, _end(best)), further)
    if _is_enough(best, further):
        return best
    best = _better(best, further.towards(paths[0][0], _forms(leading), _asked(best)), further)
    if _is_enough(best, further):
        return best
    return _better(best, further.of([(fit,) for fit in leading], _end(best)), further)


def _promising(
    further: Further, single: Fit, ranking: Sequence[Fit], leading: Sequence[Fit]
) -> list[Path]:
    """Return the pairs that promise most, the best first.

    Where they remove enough, but none explains all, kin takes the place of either in the best: no
    promise tells them apart.
    """
    pairs = further.promising(leading, single)
    if not pairs or explained(pairs[0][-1]):
        return pairs
    most = min(RELATED * pairs[0][-1].cost, asked(single))
    near = [path for path in pairs[:AS_GOOD] if path[-1].cost < most]
    better = [tuple(exchanged(path, ranking, further)) for path in near]
    return sorted([*better, *pairs[len(near) :]], key=lambda path: path[-1].bic)


def _end(path: Path) -> Fit | None:
    """Return the last model of a path, if there is one."""
    return path[-1] if path else None


def _is_enough(path: Path, further: Further) -> bool:
    """Whether there is a path that leaves only noise, or enough was tried."""
    return further.is_spent() or (bool(path) and explained(path[-1]))


def _asked(path: Path) -> float:
    """Return the cost that is asked of what is tried late: a good part less than was reached."""
    return asked(path[-1]) if path else np.inf


def _simpler(path: Path, ranking: Sequence[Fit]) -> list[Path]:
    """Return paths that begin with what a first effect contains: it may have followed a second."""
    return [(fit,) for fit in ranking if added(fit).name in added(path[0]).simpler]


def beside_each(
    path: Path, ranking: Sequence[Fit], leading: Sequence[Fit], further: Further
) -> Path:
    """Try whatever else goes with either of two effects, until nothing does better.

    Both may have to give way at once, too. What does as well is noted, and told in the end.
    """
    while len(path) == 2 and not further.is_spent(path[-1]):
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
        unknown = [fit for fit in near if not further.explains(fit, other)]
        found += further.towards(other, unknown, final.cost + SIMPLER)
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
    best: list[Fit] = []
    for fit in ranking:
        if not any(exclude(added(fit), added(other)) for other in best):
            best.append(fit)
    return best


def _various(ranking: Sequence[Fit]) -> list[Fit]:
    """Put the best of each family before their others."""
    best: dict[str, Fit] = {}
    for fit in ranking:
        best.setdefault(added(fit).family, fit)
    return sorted(ranking, key=lambda fit: fit is not best[added(fit).family])
