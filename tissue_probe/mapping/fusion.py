"""What several estimators found at each site, fused into one map.

Contents: which estimates count for which cell, and how the estimators' values become one.

Of a dwell, the last estimate of each estimator counts, with its status: a filter without forgetting
has put every earlier sample into it, and only at the end has every sample of the dwell been held
against the model. An estimator that ends a dwell with a rejected model or out of contact says
nothing of that cell, however sure it was before.

A dwell ends when its scan says so, when the next announcement begins, and for each estimator with
the run of samples in which it began (``signals.begin_anew``): a scan that dies says nothing more,
and its dwell does not last until somebody has moved the tip. A live mapper is told of the silence
of the scan besides (``fall_silent``), should another's driver measure on.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from tissue_probe.mapping.palpated_sites import PalpatedSites, Place, place_of
from tissue_probe.mapping.site_result import SiteResult
from tissue_probe.mapping.stiffness_map import StiffnessMapData
from tissue_probe.mapping.verdict import USABLE, CellVerdict, verdict_of
from tissue_probe.signals import (
    NOT_TOUCHED,
    FloatArray,
    IntArray,
    Leaving,
    PalpationSite,
    Phase,
    TissueEstimates,
    begin_anew,
)

_OPEN_END = int(np.iinfo(np.int64).max)
#: Estimates of each estimator that are kept while a dwell's end may yet be moved back: as many as
#: DDS holds back.
_HELD_BACK = 1000


class Estimate(NamedTuple):
    """What one estimator found at one site; units as in ``TissueEstimates``.

    An ``innovation`` that is NaN says that force or position of the sample are not known: then the
    rest is what the filter knew before, of whatever was under the tip then.
    """

    stamp: int
    stiffness: float
    damping: float
    covariance_trace: float
    stiffness_variance: float
    damping_variance: float
    innovation: float = 0.0

    def has_weight(self) -> bool:
        """Whether all is finite and both variances are positive: nothing else has a weight."""
        return (
            0.0 < self.stiffness_variance < math.inf
            and 0.0 < self.damping_variance < math.inf
            and math.isfinite(self.stiffness)
            and math.isfinite(self.damping)
            and math.isfinite(self.covariance_trace)
        )


def inverse_variance_weights(variance: FloatArray) -> FloatArray:
    """Return w_i = (1 / variance_i) / sum_j (1 / variance_j), shape (n,).

    Parameters
    ----------
    variance : array, shape (n,)
        Positive and finite, in any one unit.
    """
    relative = variance.min() / variance  # never overflows, as 1 / variance could
    found: FloatArray = relative / relative.sum()
    return found


def fuse_stddev(weights: FloatArray, values: FloatArray, variance: FloatArray) -> float:
    """Return the standard deviation of the weighted mean of several estimators' values.

    sigma^2 = (sum_i w_i sigma_i)^2 + sum_i w_i (v_i - mean)^2. The first part is the bound for
    fully correlated errors: the estimators saw the same samples with the same noise, so that more
    of them do not make the error smaller, as 1 / sqrt(sum_i 1 / variance_i) would have it. The
    second is the spread between them: where they differ by more than their noise, one of them is
    wrong, and the weights are all that is known of which (law of total variance).
    """
    noise = float(weights @ np.sqrt(variance))
    spread = float(weights @ (values - weights @ values) ** 2)
    return math.hypot(noise, math.sqrt(spread))


class Judged(NamedTuple):
    """The last estimate of one estimator in a dwell, and its status."""

    status: int
    estimate: Estimate

    @property
    def is_usable(self) -> bool:
        """Whether it gives the cell a value."""
        return self.status in USABLE

    @property
    def is_sound(self) -> bool:
        """Whether it says something of the tissue under the tip.

        It is made of a sample that is known, and a value that is claimed has a weight.
        """
        known = math.isfinite(self.estimate.innovation)
        return known and (not self.is_usable or self.estimate.has_weight())


@dataclass(slots=True, eq=False)
class Dwell:
    """One stay at one place.

    Attributes
    ----------
    site : PalpationSite
        The announcement; its stamp is when the dwell begins.
    end : int
        The first time that is no more in the dwell [ns since the epoch].
    ended : bool
        Whether the end is known.
    leaving : Leaving
        Why it ended.
    silent : int
        Since when the scan shows no more that it is alive [ns since the epoch].
    """

    site: PalpationSite
    end: int = _OPEN_END
    leaving: Leaving = Leaving.UNTOLD
    silent: int = _OPEN_END
    _found: dict[str, deque[Judged]] = field(default_factory=dict)
    _left: set[str] = field(default_factory=set)
    _kept: int = _HELD_BACK

    @property
    def begin(self) -> int:
        """When the dwell begins [ns since the epoch]."""
        return self.site.stamp

    @property
    def ended(self) -> bool:
        """Whether the end is known."""
        return self.until < _OPEN_END

    @property
    def until(self) -> int:
        """The first time from which nothing counts [ns since the epoch]."""
        return min(self.end, self.silent)

    def take(self, estimator: str, judged: Judged) -> bool:
        """Take an estimate made in the dwell; return whether it is the estimator's newest."""
        if estimator in self._left or judged.estimate.stamp >= self.silent:
            return False
        found = self._found.setdefault(estimator, deque(maxlen=self._kept))
        if found and found[-1].estimate.stamp >= judged.estimate.stamp:
            return False
        found.append(judged)
        return True

    def leave(self, estimator: str) -> None:
        """Take no more of an estimator, whose samples are of another run from now on."""
        self._left.add(estimator)

    def end_at(self, stamp: int) -> None:
        """End the dwell no later than ``stamp``; estimates from then on are no part of it."""
        self.end = min(self.end, stamp)
        for found in self._found.values():
            while found and found[-1].estimate.stamp >= self.end:
                found.pop()

    def close(self) -> None:
        """Keep the last estimates alone: the end will not be moved any more."""
        self._kept = 1
        self._found = {name: deque(found, maxlen=1) for name, found in self._found.items()}

    def last(self) -> dict[str, Judged]:
        """Return the last estimate of each estimator that made one, by its name."""
        counted = {
            name: [each for each in found if each.estimate.stamp < self.silent]
            if self.silent < _OPEN_END
            else found
            for name, found in sorted(self._found.items())
        }
        return {name: found[-1] for name, found in counted.items() if found}

    def verdict(self) -> CellVerdict:
        """Return why the dwell gives a value, or none."""
        if self.leaving in NOT_TOUCHED:
            return CellVerdict.CONTACT_NOT_FOUND
        return verdict_of(judged.status for judged in self.last().values())


@dataclass(slots=True)
class _Run:
    """The newest estimate of an estimator, and the time between it and the one before [ns]."""

    stamp: int
    sequence: int
    gap: int | None = None

    def begins_anew(self, stamp: int, sequence: int) -> bool:
        """Whether the next estimate is of another run of samples; note it as the newest."""
        gap = stamp - self.stamp
        usual = gap if self.gap is None else max(self.gap, 0)  # a replay steps back
        anew = begin_anew(gap, usual, sequence - self.sequence)
        self.stamp, self.sequence, self.gap = stamp, sequence, gap
        return bool(anew)


class MapBuilder:
    """Gathers estimates site by site and fuses them into a map.

    An announcement holds from its stamp on and replaces whatever was announced before for later
    times; so a scan may announce phases ahead and be cut short, and a replay may begin again. An
    estimate counts for the dwell that its stamp falls into, however late it arrives. So the map is
    a function of the announcements and the estimates, whenever they came.

    A cell that is visited again shows the last dwell in which an estimator came to a judgement:
    CONVERGED or DISTURBED, which give a value, NO_CONTACT or MODEL_REJECTED, which do not. Dwells
    without one leave the value before.

    Attributes
    ----------
    revision : int
        Rises with every change of the map; whoever publishes the map compares it with the revision
        published last.
    """

    def __init__(self) -> None:
        self.revision = 0
        self._sites = PalpatedSites()
        self._timeline: list[Dwell] = []  # by rising begin
        self._visits: dict[Place, list[Dwell]] = {}
        self._runs: dict[str, _Run] = {}

    def announce(self, site: PalpationSite) -> Dwell | None:
        """Note where the probe is, and return the dwell that begins, if one does.

        A site where no surface was found has a dwell without time, and no value.

        Raises
        ------
        ValueError
            If that is no place.
        """
        place = place_of(site)
        self._sites.add(site)
        self.revision += 1
        replaced = [dwell for dwell in self._timeline if dwell.begin >= site.stamp]
        self._timeline = [dwell for dwell in self._timeline if dwell.begin < site.stamp]
        for dwell in replaced:
            if not dwell.last():  # it was announced ahead, and never came to be
                self._visits[place_of(dwell.site)].remove(dwell)
        if self._timeline:
            last = self._timeline[-1]
            if site.phase == Phase.LIFTED and last.end == _OPEN_END:
                last.leaving = site.leaving
                last.silent = _OPEN_END  # it lives: only a scan that has lifted the tip says so
            last.end_at(site.stamp)
        if not site.is_visit:
            return None
        if self._timeline:
            self._timeline[-1].close()
        # Where no surface was found there is a visit, and no time in it.
        dwell = Dwell(site) if site.phase == Phase.DWELL else Dwell(site, site.stamp, site.leaving)
        self._timeline.append(dwell)
        self._visits.setdefault(place, []).append(dwell)
        return dwell

    def fall_silent(self, lease: int) -> None:
        """End the dwell under way where its scan was last known to be alive.

        That is ``lease`` [ns] before the newest estimate. Should the scan say after all when it
        lifted the tip, that holds.
        """
        if not self._timeline or self._timeline[-1].ended:
            return
        dwell = self._timeline[-1]
        newest = max((run.stamp for run in self._runs.values()), default=dwell.begin)
        dwell.silent = max(dwell.begin, newest - lease)
        self.revision += 1

    def take_up(self, dwell: Dwell) -> None:
        """Take a dwell that has ended with all that was found in it, as if it came now."""
        begun = self.announce(dwell.site)
        assert begun is not None, "a site that begins a dwell begins one"
        self.announce(
            replace(dwell.site, stamp=dwell.until, phase=Phase.LIFTED, leaving=dwell.leaving)
        )
        for estimator, judged in dwell.last().items():
            self.revision += begun.take(estimator, judged)

    def add(self, estimates: TissueEstimates) -> None:
        """Take estimates of one estimator, in any order.

        Left out are those that claim a value without a finite number and a positive variance, those
        of samples that are not known, and those that were made outside every dwell.
        """
        anew = _begins(estimates)
        for dwell in self._timeline:
            end = min(dwell.end, *anew[anew > dwell.begin][:1].tolist(), _OPEN_END)
            inside = (estimates.stamp >= dwell.begin) & (estimates.stamp < end)
            rows = np.flatnonzero(inside)
            newest_first = rows[np.argsort(-estimates.stamp[rows], kind="stable")]
            found = (_row(estimates, row) for row in newest_first)
            last = next((judged for judged in found if judged.is_sound), None)
            if last is not None:
                self.revision += dwell.take(estimates.estimator, last)

    def add_one(
        self, estimator: str, status: int, estimate: Estimate, sequence: int = 0
    ) -> Dwell | None:
        """Take one estimate as ``add`` does; cheap enough for every message of a live run.

        Those of an estimator come in their order. ``sequence`` is the number of its sample since
        activation; always 0 where samples are not counted. Return the dwell in which it is now the
        estimator's last; None if it changes nothing.
        """
        judged = Judged(status, estimate)
        run = self._runs.setdefault(estimator, _Run(estimate.stamp, sequence))
        anew = run.begins_anew(estimate.stamp, sequence)
        dwell = next((d for d in reversed(self._timeline) if d.begin <= estimate.stamp), None)
        if dwell is None or estimate.stamp >= dwell.end:
            return None
        if anew and estimate.stamp > dwell.begin:
            dwell.leave(estimator)
        if not judged.is_sound:
            return None
        if not dwell.take(estimator, judged):
            return None
        self.revision += 1
        return dwell

    def results(self, *, under_way: bool = True) -> list[SiteResult]:
        """Return what each dwell found that has ended, in order of time.

        A place that is visited again has several: none replaces another. Where ``under_way``, a
        dwell that has an estimate counts before it has ended, too.
        """
        repeats = {id(d): n for visits in self._visits.values() for n, d in enumerate(visits)}
        return [
            _result(dwell, repeats[id(dwell)])
            for dwell in self._timeline
            if dwell.ended or (under_way and dwell.last())
        ]

    def map(self) -> StiffnessMapData:
        """Return the map as known now, each cell fused over its estimators.

        Stiffness and damping are averaged by inverse variance, each by its own; the covariance
        trace with the weights of the stiffness. For the standard deviations see ``fuse_stddev``.

        Raises
        ------
        ValueError
            If no site was announced, or the sites lie on no square grid.
        """
        grid, cells = self._sites.cells()
        layers = np.full((5, *grid.shape), np.nan)
        verdicts = np.full(grid.shape, CellVerdict.NOT_PALPATED, dtype=np.uint8)
        begins = np.zeros(grid.shape, dtype=np.int64)
        stamp = 0
        for place, cell in cells.items():
            dwell = _choose_shown(self._visits.get(place, []))
            if dwell is None:
                continue
            last = dwell.last()
            verdicts[cell] = dwell.verdict()
            begins[cell] = dwell.begin
            stamp = max(stamp, *(each.estimate.stamp for each in last.values()), _known_end(dwell))
            usable = [each.estimate for each in last.values() if each.is_usable]
            if usable:
                layers[(slice(None), *cell)] = _fuse(usable)
        k, beta, trace, k_stddev, beta_stddev = layers
        return StiffnessMapData(
            grid, stamp, k, beta, trace, k_stddev, beta_stddev, verdicts, begins
        )


def _result(dwell: Dwell, repeat: int) -> SiteResult:
    last = dwell.last()
    usable = [each.estimate for each in last.values() if each.is_usable]
    values = map(float, _fuse(usable) if usable else (math.nan,) * 5)
    stiffness, damping, trace, stiffness_stddev, damping_stddev = values
    site = dwell.site
    x, y, z = map(float, site.position)
    return SiteResult(
        site.site,
        repeat,
        site.stamp,
        (x, y, z),
        site.normal,
        stiffness,
        damping,
        trace,
        stiffness_stddev,
        damping_stddev,
        dwell.verdict(),
        dwell.leaving,
    )


#: Verdicts by which an estimator has said something of the tissue.
_JUDGEMENTS = {
    CellVerdict.MEASURED,
    CellVerdict.DISTURBED,
    CellVerdict.NO_CONTACT,
    CellVerdict.MODEL_REJECTED,
}


def _choose_shown(visits: list[Dwell]) -> Dwell | None:
    """Return the dwell that a cell shows: see ``MapBuilder``."""
    known = [dwell for dwell in visits if dwell.ended or dwell.last()]
    judged = (dwell for dwell in reversed(known) if dwell.verdict() in _JUDGEMENTS)
    return next(judged, known[-1] if known else None)


def _known_end(dwell: Dwell) -> int:
    """Return a time that the samples of a dwell have reached, where no estimate tells one."""
    return dwell.until if dwell.ended and not dwell.last() else 0


def _begins(estimates: TissueEstimates) -> IntArray:
    """Return the stamps at which another run of samples begins, ascending [ns since the epoch]."""
    order = np.argsort(estimates.stamp, kind="stable")
    stamp = estimates.stamp[order]
    sequence = estimates.sequence[order].astype(np.int64)
    step = sequence[1:] - sequence[:-1]
    gap = stamp[1:] - stamp[:-1]
    usual = np.concatenate([gap[:1], gap[:-1]])
    return stamp[1:][begin_anew(gap, usual, step)]


def _row(estimates: TissueEstimates, row: int) -> Judged:
    values = (getattr(estimates, name)[row].item() for name in Estimate._fields)
    return Judged(int(estimates.status[row]), Estimate(*values))


def _fuse(estimates: list[Estimate]) -> tuple[float, float, float, float, float]:
    """Return stiffness, damping, covariance trace, stddev of stiffness and of damping."""
    _, stiffness, damping, trace, stiffness_variance, damping_variance, _ = np.array(estimates).T
    stiffness_weights = inverse_variance_weights(stiffness_variance)
    damping_weights = inverse_variance_weights(damping_variance)
    return (
        stiffness_weights @ stiffness,
        damping_weights @ damping,
        stiffness_weights @ trace,
        fuse_stddev(stiffness_weights, stiffness, stiffness_variance),
        fuse_stddev(damping_weights, damping, damping_variance),
    )
