"""Which variables a missing force depends on: sets of them, and the smallest that explains it.

Contents: the order in which sets are tried, when one is accepted, and sets that explain as much.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from tissue_probe.diagnosis.evidence.adequacy import SHARE
from tissue_probe.diagnosis.shape.free_functions import VARIABLES, Group
from tissue_probe.diagnosis.shape.gram import Gram, names_of
from tissue_probe.diagnosis.shape.smoothing import Smooth, smooth

Set = frozenset[str]

#: A shape is accepted that leaves so little over the noise, and, of parts that are left out, so
#: little more than of those fitted: a rest of at most 0.4 and 0.6 of the noise, sqrt(1.07^2 - 1)
#: and sqrt(1.15^2 - 1), which no single sample shows.
FITS, HOLDS = 1.07, 1.15
#: By how much the logarithm of the evidence must rise for each further variable: a thousandfold.
EACH = 7.0
#: Sets are not told apart whose rests differ by less than this factor, and the forces that they
#: explain by no more of their power: the free functions themselves are no more exact.
ALIKE_FACTOR = 1.03
#: Variables that go with no other: with the clock anything can be explained.
ALONE = frozenset(["clock"])


@dataclass(frozen=True, eq=False)
class Choice:
    """All sets that were tried, and the one that is chosen.

    Attributes
    ----------
    tried : mapping of frozenset of str to Smooth
        Each set, the empty one too.
    chosen : frozenset of str
        The set that explains most for its size.
    """

    tried: Mapping[Set, Smooth]
    chosen: Set

    @property
    def best(self) -> Smooth:
        """The chosen set's fit."""
        return self.tried[self.chosen]

    @property
    def accepted(self) -> bool:
        """Whether the chosen set leaves noise only, in parts that are left out, too."""
        return bool(self.chosen) and is_accepted(self.best)

    @property
    def rivals(self) -> list[Set]:
        """Sets that do not contain the chosen one, leave as little, and explain as much."""
        left = self.best.ratio**2
        explained = self.tried[frozenset()].ratio ** 2 - left
        most = left + (ALIKE_FACTOR**2 - 1.0) * min(left, explained)
        return [
            each
            for each, fit in self.tried.items()
            if each and not each >= self.chosen and fit.ratio**2 <= most
        ]

    def share(self, variables: Set) -> float:
        """Return the share of the held-out residual beyond the noise that a set explains."""
        none, some = self.tried[frozenset()], self.tried[variables]
        excess = none.heldout**2 - 1.0
        if excess <= 0.0:
            return 0.0
        return min(max((none.heldout**2 - some.heldout**2) / excess, 0.0), 1.0)

    def beyond(self, variable: str) -> float:
        """Return the share that a variable explains beyond the chosen others."""
        without = self.chosen - {variable}
        return max(self.share(without | {variable}) - self.share(without), 0.0)


def is_accepted(fit: Smooth) -> bool:
    """Whether a set leaves noise only."""
    return fit.ratio <= FITS and fit.heldout <= HOLDS * max(fit.ratio, 1.0)


def choose_variables(gram: Gram, groups: Sequence[Group]) -> Choice:
    """Try sets of variables, one, two and, where two do not do, three; and choose one."""
    tried: dict[Set, Smooth] = {}

    def attempt(variables: Set) -> Smooth:
        if variables not in tried:
            tried[variables] = smooth(gram, list(names_of(groups, variables)))
        return tried[variables]

    attempt(frozenset())
    for name in VARIABLES:
        attempt(frozenset([name]))
    mixed = [name for name in VARIABLES if name not in ALONE]
    for pair in combinations(mixed, 2):
        attempt(frozenset(pair))
    best = _best(tried)
    if not is_accepted(tried[best]) and len(best) == 2:
        for name in mixed:
            attempt(best | {name})
        best = _best(tried)
    for name in VARIABLES:
        attempt(best | {name})
        attempt((best - {name}) or frozenset())
    return Choice(tried, best)


def _best(tried: Mapping[Set, Smooth]) -> Set:
    """Return the most probable set of the least size that no larger one puts in the shade.

    A larger one has to remove most of the residual beyond the noise, as a further effect has.
    """
    best: Set = frozenset()
    for size in range(1, max(map(len, tried)) + 1):
        of_size = [each for each in tried if len(each) == size and each]
        if not of_size:
            continue
        most = max(of_size, key=lambda each: tried[each].evidence)
        before, after = tried[best], tried[most]
        pays = after.evidence - before.evidence > EACH * (size - len(best))
        if pays and _removes(before, after):
            best = most
    return best


def _removes(before: Smooth, after: Smooth) -> bool:
    """Whether a larger set removes most of the residual, or leaves noise only."""
    if is_accepted(before):
        return after.ratio * ALIKE_FACTOR < before.ratio
    left, excess = after.ratio**2 - 1.0, before.ratio**2 - 1.0
    return left < (1.0 - SHARE) * excess or is_accepted(after)
