"""Several chains, run until they agree on which inclusions there are.

Contents: seeds, lengths, and when to stop.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np

from tissue_probe.mapping.posterior.background import Background
from tissue_probe.mapping.posterior.chain import run
from tissue_probe.mapping.posterior.moves import SitesRegion
from tissue_probe.mapping.posterior.outliers import ErrorKinds
from tissue_probe.mapping.posterior.prior import MOST_INCLUSIONS, PARAMETERS
from tissue_probe.signals import FloatArray, IntArray

CHAINS = 4
#: How much of what the data say each of the coupled chains is told: that of the posterior all. At a
#: tenth, two places that the sites tell apart by 10 in log density differ by 1.
_BETAS = np.geomspace(1.0, 0.1, 4)
#: Moves of one chain in a stretch, and what share of the first goes before anything is kept.
STRETCH, _BURN_IN = 2000, 0.5
_THIN = 10
#: Chains that do not agree run on for so many stretches, and longer while moves of one chain times
#: sites are fewer: a move takes longer the more sites it is told by, and few sites leave more to be
#: weighed. Together 0.4 s of processor time for 81 sites.
_STRETCHES, _WORK = 2, 0.4e6
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
    kinds : array, shape (chains, states, n)
        How each site errs: 0, or its place among the sizes of outliers.
    """

    inclusions: FloatArray
    count: IntArray
    level: IntArray
    kinds: ErrorKinds

    def flat(self) -> tuple[FloatArray, IntArray, IntArray, ErrorKinds]:
        """Return all chains' states as if of one chain: inclusions, their number, level and kinds.

        Shapes (states, MOST, PARAMETERS), (states,), (states,) and (states, n).
        """
        return (
            self.inclusions.reshape(-1, MOST_INCLUSIONS, PARAMETERS),
            self.count.ravel(),
            self.level.ravel(),
            self.kinds.reshape(self.count.size, -1),
        )

    def some(self, most: int) -> tuple[FloatArray, IntArray, IntArray, ErrorKinds]:
        """Return at most so many states, evenly chosen from all chains, as ``flat`` does."""
        chosen = np.unique(np.linspace(0, self.count.size - 1, most).astype(int))
        rows, count, level, kinds = self.flat()
        return rows[chosen], count[chosen], level[chosen], kinds[chosen]

    @staticmethod
    def join_parts(parts: list[States]) -> States:
        """Return stretches, one after another."""
        return States(
            *(
                np.concatenate([getattr(part, name) for part in parts], axis=1)
                for name in ("inclusions", "count", "level", "kinds")
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
    outliers : array, shape (2,)
        Beta prior of the share of sites that are outliers.
    """

    def __init__(
        self, y: FloatArray, region: SitesRegion, background: Background, outliers: FloatArray
    ) -> None:
        self._data = (y, region, background.precision, background.log_weight, outliers)
        self._seeds = np.random.default_rng(_digest(y, region.sx, region.sy))
        self._ends = np.zeros((CHAINS, _BETAS.size, MOST_INCLUSIONS + 1, PARAMETERS))
        # The chains begin at levels of their own, and without inclusions.
        levels = np.linspace(0, background.log_weight.size - 1, CHAINS).astype(int)
        self._ends[:, :, MOST_INCLUSIONS, 1] = levels[:, None]
        self._kinds = np.zeros((CHAINS, _BETAS.size, y.size), dtype=np.int8)
        self.stretches = 0

    def further(self, moves: int = STRETCH) -> States:
        """Run every chain so many moves further, and return its states."""
        if not self.stretches:
            self._run(int(moves * _BURN_IN))
        self.stretches += 1
        return self._run(moves)

    @property
    def exhausted(self) -> bool:
        """Whether the chains have run as long as they may."""
        further = (self.stretches + 1) * STRETCH * self._data[0].size
        return self.stretches >= _STRETCHES and further > _WORK

    def _run(self, steps: int) -> States:
        kept = steps // _THIN
        rows = np.zeros((CHAINS, kept, MOST_INCLUSIONS, PARAMETERS))
        count, level = (np.zeros((CHAINS, kept), dtype=np.int64) for _ in range(2))
        kinds = np.zeros((CHAINS, kept, self._data[0].size), dtype=np.int8)
        for i in range(CHAINS):
            seed = int(self._seeds.integers(2**31))
            of = (rows[i], count[i], level[i], kinds[i])
            run(seed, *self._data, _BETAS, self._ends[i], self._kinds[i], steps, _THIN, *of)
        return States(rows, count, level, kinds)


def _digest(*arrays: FloatArray) -> int:
    """Return a number that follows from the data: the same sites have the same map."""
    digest = hashlib.blake2b(digest_size=8)
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return int.from_bytes(digest.digest(), "little")
