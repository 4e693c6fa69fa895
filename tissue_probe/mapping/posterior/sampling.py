"""Several chains, run until they agree on which inclusions there are.

What belongs here: seeds, lengths, and when to stop. What does not: the moves of one chain
(``chain``), and what is read out of the states (``found``, ``surface``, ``hidden``).
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np

from tissue_probe.mapping.posterior.background import Background
from tissue_probe.mapping.posterior.chain import run
from tissue_probe.mapping.posterior.moves import Region
from tissue_probe.mapping.posterior.prior import MOST, PARAMETERS
from tissue_probe.signals import FloatArray, IntArray

CHAINS = 4
#: Moves of one chain before anything is kept, and of each stretch that is kept.
_BURN_IN, _STRETCH = 2000, 4000
_THIN = 20
#: Moves of one chain times sites at most: a move takes longer the more sites it is told by, and
#: few sites leave more to be weighed.
_MOST_WORK = 0.4e6
#: Two halves of the chains may differ so much in the probability of an inclusion. Two runs, each
#: of all the chains, then differ by less: each has twice as many states as a half.
AGREEMENT = 0.05


@dataclass(frozen=True)
class States:
    """The kept states of all chains.

    Attributes
    ----------
    inclusions : array, shape (chains, states, MOST, PARAMETERS)
        Of each state, those beyond its number are meaningless.
    count, level : array, shape (chains, states)
        Number of inclusions, and level of the background's variation.
    """

    inclusions: FloatArray
    count: IntArray
    level: IntArray

    def flat(self) -> tuple[FloatArray, IntArray, IntArray]:
        """Return all chains' states as if of one chain."""
        return (
            self.inclusions.reshape(-1, MOST, PARAMETERS),
            self.count.ravel(),
            self.level.ravel(),
        )

    def some(self, most: int) -> tuple[FloatArray, IntArray, IntArray]:
        """Return at most so many states, evenly chosen from all chains, as ``flat`` does."""
        chosen = np.unique(np.linspace(0, self.count.size - 1, most).astype(int))
        rows, count, level = self.flat()
        return rows[chosen], count[chosen], level[chosen]

    @staticmethod
    def joined(parts: list[States]) -> States:
        """Return stretches, one after another."""
        return States(
            *(
                np.concatenate([getattr(part, name) for part in parts], axis=1)
                for name in ("inclusions", "count", "level")
            )
        )


class Chains:
    """The chains of one map, which can be run on.

    Parameters
    ----------
    y : array, shape (n,)
        log k less its median.
    region : Region
        The sites, and where inclusions may be.
    background : Background
        Of these sites.
    """

    def __init__(self, y: FloatArray, region: Region, background: Background) -> None:
        self._data = (y, region, background.precision, background.log_weight)
        self._seeds = np.random.default_rng(_digest(y, region.sx, region.sy))
        self._ends = np.zeros((CHAINS, MOST + 1, PARAMETERS))
        # The chains begin at levels of their own, and without inclusions.
        self._ends[:, MOST, 1] = np.linspace(0, background.log_weight.size - 1, CHAINS).astype(int)
        self.stretches = 0

    def further(self) -> States:
        """Run every chain a stretch further, and return its states."""
        if not self.stretches:
            self._run(_BURN_IN)
        self.stretches += 1
        return self._run(_STRETCH)

    @property
    def exhausted(self) -> bool:
        """Whether the chains have run as long as they may."""
        return (self.stretches + 1) * _STRETCH * self._data[0].size > _MOST_WORK

    def _run(self, steps: int) -> States:
        kept = steps // _THIN
        rows = np.zeros((CHAINS, kept, MOST, PARAMETERS))
        count, level = (np.zeros((CHAINS, kept), dtype=np.int64) for _ in range(2))
        for i in range(CHAINS):
            seed = int(self._seeds.integers(2**31))
            run(seed, *self._data, self._ends[i], steps, _THIN, rows[i], count[i], level[i])
        return States(rows, count, level)


def _digest(*arrays: FloatArray) -> int:
    """Return a number that follows from the data: the same sites have the same map."""
    digest = hashlib.blake2b(digest_size=8)
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return int.from_bytes(digest.digest(), "little")
