"""The signals of one run, as checked arrays in SI units.

Contents: samples as the probe measured them, where it measured them, and the estimates made of
them; every other part of the package exchanges these.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import IntEnum, StrEnum
from itertools import pairwise, zip_longest
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
#: Of texts; NumPy has no type of such an array.
TextArray = NDArray[Any]
#: Type of the elements of an array of texts, of any lengths.
TEXT = np.dtypes.StringDType()

NANOSECONDS = 1_000_000_000

#: Longest silence of the samples within a dwell [ns]. A scan that goes on ends a dwell when it
#: hears none for so long; a driver stops them when it has heard no sign of the scan for so long.
LONGEST_SILENCE = NANOSECONDS // 2


@overload
def begin_anew(gap: int, usual: int, step: int) -> bool: ...
@overload
def begin_anew(gap: IntArray, usual: IntArray, step: IntArray) -> BoolArray: ...
def begin_anew(
    gap: int | IntArray, usual: int | IntArray, step: int | IntArray
) -> bool | BoolArray:
    """Whether samples are the first of another run of the probe than those before them.

    They are after a silence, and where their numbers step back, as at a new activation. A dwell is
    a part of one run. The events that end a dwell without a word (the scan dies or hangs, the
    driver is in FAULT, is ended or activated anew) end the run too, since the driver stops its
    samples: so the samples alone tell it, at any later time as well as live.

    Parameters
    ----------
    gap : int or array of int
        From the sample before to this one [ns].
    usual : int or array of int
        The same of the sample before: blocks may be long [ns].
    step : int or array of int
        From the number of the sample before to that of this one.
    """
    return (gap > LONGEST_SILENCE + usual) | (step < 0)


@dataclass(frozen=True, slots=True)
class SampleBlock:
    """Consecutive samples of the probe, one every ``sample_period``.

    Parameters
    ----------
    stamp : int
        Time of the first sample [ns since the epoch].
    sequence : int
        Number of the first sample since the probe was activated (0 for the very first).
    sample_period : float
        Time between two samples [s], positive.
    position : array, shape (n,)
        Displacement u of the coil [m], positive into the tissue.
    force : array, shape (n,)
        Load-cell force F [N], positive in compression.
    command : array, shape (n,)
        Voltage commanded to the coil [V]; NaN where it is not known.

    Raises
    ------
    ValueError
        If the arrays are not one-dimensional and of one length of at least 1, the period is
        not positive and finite, or the sequence is negative. Values that are NaN or infinite
        are accepted: they were measured so, and the estimators state their use of them.
    """

    stamp: int
    sequence: int
    sample_period: float
    position: FloatArray
    force: FloatArray
    command: FloatArray

    def __post_init__(self) -> None:
        for name in ("position", "force", "command"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=np.float64))
        shape = self.position.shape
        if len(shape) != 1 or shape[0] == 0:
            raise ValueError(f"position has shape {shape}; give one value a sample, at least one")
        if self.force.shape != shape or self.command.shape != shape:
            raise ValueError(
                f"position, force and command have {shape[0]}, {self.force.size} and "
                f"{self.command.size} values; give one of each for every sample"
            )
        if not 0.0 < self.sample_period < float("inf"):
            raise ValueError(f"sample_period is {self.sample_period} s; it must be positive")
        if self.sequence < 0:
            raise ValueError(f"sequence is {self.sequence}; samples are numbered from 0")

    def __len__(self) -> int:
        return self.position.size

    @property
    def stamps(self) -> IntArray:
        """Time of each sample [ns since the epoch], shape (n,)."""
        return self.stamp + sample_offsets(len(self), self.sample_period)

    @property
    def end(self) -> int:
        """Time at which the sample after the last one is due [ns since the epoch]."""
        return self.stamp + round(len(self) * self.sample_period * NANOSECONDS)

    def __getitem__(self, samples: slice) -> SampleBlock:
        """Cut consecutive samples out of the block (a slice of step 1)."""
        first, stop, step = samples.indices(len(self))
        if step != 1:
            raise ValueError("a block holds consecutive samples: slice it with step 1")
        return SampleBlock(
            stamp=self.stamp + round(first * self.sample_period * NANOSECONDS),
            sequence=self.sequence + first,
            sample_period=self.sample_period,
            position=self.position[first:stop],
            force=self.force[first:stop],
            command=self.command[first:stop],
        )

    def continues(self, other: SampleBlock) -> bool:
        """Whether this block's first sample is the one after the last of ``other``."""
        return self._begins_after(len(other), other)

    def _begins_after(self, count: int, first: SampleBlock) -> bool:
        """Whether this block begins ``count`` samples after ``first`` does.

        Both stamps are rounded, so they may disagree by a nanosecond.
        """
        due = first.stamp + round(count * self.sample_period * NANOSECONDS)
        return (
            self.sequence == first.sequence + count
            and self.sample_period == first.sample_period
            and abs(self.stamp - due) <= 1
        )


#: Bounds of a message's values, for its receivers: outside them it is refused, since
#: no probe measures so, and a node that took it could hang, or fail later.

#: Shortest sample period [s]: stamps are whole nanoseconds, and below it their rounding would be
#: more than a thousandth of the period.
SHORTEST_PERIOD = 1e-6
#: Longest sample period [s]: twice that of the slowest device, whose clock may not divide exactly.
LONGEST_PERIOD = 2.0
#: Most samples of one message: ten times the longest block that the driver sends.
MOST_SAMPLES = 20_000
#: Last stamp [ns since the epoch]: a ROS time ends at 2^31 s; a day before that, any time made of
#: it (the end of a dwell lies an hour ahead at the most) can still be said.
LAST_STAMP = (2**31 - 86_400) * NANOSECONDS
#: Last number of a sample: arrays of them hold 64 bits, with sign.
LAST_SEQUENCE = 2**63 - 1
#: Farthest place [m] from the origin, along each axis: no robot that carries a probe reaches it.
FARTHEST_PLACE = 100.0


def sound_block(block: SampleBlock) -> SampleBlock:
    """Return a block that came as a message, if it lies within the bounds above.

    Raises
    ------
    ValueError
        If its period, length, numbers or stamps lie outside them; the message says which.
    """
    if not SHORTEST_PERIOD <= block.sample_period <= LONGEST_PERIOD:
        raise ValueError(
            f"sample_period is {block.sample_period:g} s; samples come every {SHORTEST_PERIOD:g} "
            f"to {LONGEST_PERIOD:g} s"
        )
    if len(block) > MOST_SAMPLES:
        raise ValueError(f"it has {len(block)} samples; one message holds up to {MOST_SAMPLES}")
    if block.sequence + len(block) > LAST_SEQUENCE:
        raise ValueError(f"sequence is {block.sequence}; samples are numbered up to 2^63 - 1")
    sound_stamp(block.stamp)
    sound_stamp(block.end)
    return block


def sound_stamp(stamp: int) -> int:
    """Return a stamp [ns since the epoch] that came in a message.

    Raises
    ------
    ValueError
        If it lies before 1970 or within the last day that a ROS time can say, in 2038.
    """
    if not 0 <= stamp <= LAST_STAMP:
        raise ValueError(
            f"the stamp {stamp / NANOSECONDS:.0f} s is no time from 0 to "
            f"{LAST_STAMP // NANOSECONDS} s since the epoch"
        )
    return stamp


def sound_position(position: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return a place (x, y, z) [m] that came in a message.

    Raises
    ------
    ValueError
        If a coordinate is not finite, or farther away than ``FARTHEST_PLACE``.
    """
    if not all(abs(each) <= FARTHEST_PLACE for each in position):
        raise ValueError(f"{position} m is no place within {FARTHEST_PLACE:g} m of the origin")
    return position


def sound_normal(normal: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return a normal at length 1; all 0, as who does not know it says, is along z.

    Raises
    ------
    ValueError
        If it is not finite.
    """
    length = math.hypot(*normal)
    if not math.isfinite(length):
        raise ValueError(f"the normal {normal} is not finite")
    if length == 0.0:
        return UP
    x, y, z = normal
    return x / length, y / length, z / length


def sample_offsets(count: int, sample_period: float) -> IntArray:
    """Time of each of ``count`` samples after the first [ns], rounded one by one (no drift)."""
    found: IntArray = np.rint(np.arange(count) * (sample_period * NANOSECONDS)).astype(np.int64)
    return found


def join(blocks: Iterable[SampleBlock]) -> list[SampleBlock]:
    """Join blocks that continue one another; at a gap, repeat or step back a new block begins."""
    joined: list[SampleBlock] = []
    run: list[SampleBlock] = []
    count = 0
    for block in blocks:
        # Held against the first, so that a nanosecond a block cannot add up to a drift.
        if run and not block._begins_after(count, run[0]):
            joined.append(_concatenate(run))
            run, count = [], 0
        run.append(block)
        count += len(block)
    if run:
        joined.append(_concatenate(run))
    return joined


def _concatenate(run: Sequence[SampleBlock]) -> SampleBlock:
    first = run[0]
    return SampleBlock(
        stamp=first.stamp,
        sequence=first.sequence,
        sample_period=first.sample_period,
        position=np.concatenate([block.position for block in run]),
        force=np.concatenate([block.force for block in run]),
        command=np.concatenate([block.command for block in run]),
    )


class Phase(IntEnum):
    """The probe's action at a palpation site (the constants of ``PalpationSite.msg``)."""

    APPROACH = 0
    DWELL = 1
    LIFTED = 2


#: The normal of a surface that lies flat under the stage.
UP = (0.0, 0.0, 1.0)


class Leaving(IntEnum):
    """Why a dwell ended, or there was none (the constants of ``PalpationSite.msg``)."""

    UNTOLD = 0
    TOLD_ENOUGH = 1
    LONGEST = 2
    STOPPED = 3
    NO_CONTACT = 4
    IN_CONTACT = 5
    FORCE_LIMIT = 6


#: Why there was no dwell: contact was searched by force, and no surface was found.
NOT_TOUCHED = (Leaving.NO_CONTACT, Leaving.IN_CONTACT, Leaving.FORCE_LIMIT)


@dataclass(frozen=True, slots=True)
class PalpationSite:
    """One announcement of where the probe palpates.

    ``stamp`` [ns since the epoch] is when the phase begins; it may lie in the future.
    ``site`` numbers the sites of a scan from 0; ``position`` is the site's (x, y, z) [m] in the
    stage's frame, z being the height of the tissue's surface. ``leaving`` tells with LIFTED why the
    dwell ended; ``normal`` is the surface's outward one, of length 1.
    """

    stamp: int
    site: int
    position: tuple[float, float, float]
    phase: Phase
    leaving: Leaving = Leaving.UNTOLD
    normal: tuple[float, float, float] = UP

    @property
    def is_visit(self) -> bool:
        """Whether a dwell begins, or there is none since no surface was found."""
        return self.phase == Phase.DWELL or (
            self.phase == Phase.LIFTED and self.leaving in NOT_TOUCHED
        )


@dataclass(frozen=True)
class OwnTimes:
    """Samples at the times at which they were taken, where these are not even.

    Attributes
    ----------
    stamp : int
        Of the times' zero [ns since the epoch].
    time : array, shape (n,)
        Ascending [s].
    position, force : array, shape (n,)
        [m], [N]; NaN where not known.
    """

    stamp: int
    time: FloatArray
    position: FloatArray
    force: FloatArray

    def between(self, first: int, last: int) -> OwnTimes:
        """Return the samples that are known from one stamp on, and before another."""
        begin, end = ((stamp - self.stamp) / NANOSECONDS for stamp in (first, last))
        rounding = 1.0 / NANOSECONDS
        inside = (self.time >= begin - rounding) & (self.time < end - rounding)
        inside &= np.isfinite(self.position) & np.isfinite(self.force)
        return OwnTimes(self.stamp, self.time[inside], self.position[inside], self.force[inside])


@dataclass(frozen=True)
class Channel:
    """A further channel of a run, at its own times.

    Attributes
    ----------
    name : str
        Of the column or field.
    stamp : int
        Of the times' zero [ns since the epoch].
    time : array, shape (n,)
        Ascending [s].
    values : array, shape (n,)
        In the channel's unit; finite.
    """

    name: str
    stamp: int
    time: FloatArray
    values: FloatArray

    def at(self, stamp: int, offsets: FloatArray) -> FloatArray:
        """Return the values at times [s] after a stamp: straight between samples, held beyond."""
        return np.interp((stamp - self.stamp) / NANOSECONDS + offsets, self.time, self.values)


@dataclass(frozen=True)
class EstimatorModel:
    """The model by which an estimator went on, from one sample on.

    Attributes
    ----------
    stamp : int
        Time of the first sample estimated by it [ns since the epoch].
    sequence : int
        Number of that sample since activation.
    estimator : str
        Name of the estimator.
    model : str
        As ``TissueEstimates`` have it.
    file : str
        Its file, as the estimator was told; empty for Kelvin-Voigt tissue.
    content : str
        Content of that file.
    effects : tuple of str
        Python files with effects of the user's own that it needs, as the estimator was told.
    """

    stamp: int
    sequence: int
    estimator: str
    model: str
    file: str = ""
    content: str = ""
    effects: tuple[str, ...] = ()


#: The signals of a file of columns that are scaled to SI.
SCALED = ("position", "force")


class UnitFrom(StrEnum):
    """What tells the unit of a file's column."""

    FILE = "file"
    #: The user's: the file tells none.
    STATEMENT = "statement"
    #: The user's, where the file tells another.
    OVERRULED = "statement against the file"
    #: Nobody: the column is called as this suite calls it, whose columns are in SI units.
    NAME = "name"


@dataclass(frozen=True)
class Recording:
    """Everything measured in one run.

    ``blocks`` in the order recorded, joined where they continue one another; ``sites`` as
    announced; ``metadata`` as text by name (parameters, excitation, phantom, ... of the run);
    ``time_doubt`` is by how much position and force may be apart in time [s], which nothing tells;
    ``noise`` is white noise of variance 1, resampled as the force was; None where that was not;
    ``own`` has the samples as they were before that; ``input2`` is a further channel, where asked;
    ``units_from`` is what tells the units of position and force, of files of columns; ``models``
    are those by which estimators ran, in the order recorded.
    """

    blocks: tuple[SampleBlock, ...]
    sites: tuple[PalpationSite, ...] = ()
    metadata: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    time_doubt: float = 0.0
    noise: FloatArray | None = None
    own: OwnTimes | None = None
    input2: Channel | None = None
    units_from: Mapping[str, UnitFrom] = field(default_factory=dict)
    models: tuple[EstimatorModel, ...] = ()

    def __len__(self) -> int:
        return sum(len(block) for block in self.blocks)

    @property
    def stamps(self) -> IntArray:
        """Time of each sample [ns since the epoch]."""
        return np.concatenate([block.stamps for block in self.blocks])

    @property
    def position(self) -> FloatArray:
        """Displacement of the coil at each sample [m]."""
        return np.concatenate([block.position for block in self.blocks])

    @property
    def force(self) -> FloatArray:
        """Load-cell force at each sample [N]."""
        return np.concatenate([block.force for block in self.blocks])

    @property
    def command(self) -> FloatArray:
        """Commanded coil voltage at each sample [V]."""
        return np.concatenate([block.command for block in self.blocks])

    def dwells(self) -> Iterator[tuple[PalpationSite, int]]:
        """Yield each dwell's announcement and the time it ended [ns since the epoch].

        A dwell ends when the next announcement's phase begins, and with the run of samples in which
        it began (``begin_anew``).
        """
        last = self.blocks[-1].end if self.blocks else 0
        breaks = list(self._breaks())
        for site, following in zip_longest(self.sites, self.sites[1:]):
            if site.phase == Phase.DWELL:
                announced = following.stamp if following else last
                run = next((end for end, begin in breaks if begin > site.stamp), announced)
                yield site, min(announced, max(run, site.stamp))

    def _breaks(self) -> Iterator[tuple[int, int]]:
        """Yield when each run of samples ended, and when the next one began [ns]."""
        for before, after in pairwise(self.blocks):
            period = round(before.sample_period * NANOSECONDS)
            gap = after.stamp - before.end + period
            if begin_anew(gap, period, after.sequence - before.sequence):
                yield before.end, after.stamp


class Status(IntEnum):
    """The trust in an estimate (the constants of ``TissueEstimate.msg``).

    Stiffness and damping are those at the drive's frequency, and all of this holds if the model is
    right as far as innovations can tell: a delay under a steady sine, for one, shifts the damping
    and leaves them white.

    Attributes
    ----------
    CONVERGING
        Not yet known to 5 %.
    CONVERGED
        Two standard deviations of stiffness and of damping are within 5 %.
    NO_CONTACT
        No tissue under the tip.
    MODEL_REJECTED
        Harmonics of the drive in the innovations contradict the model of the tissue: stiffness and
        damping are not to be used. It holds until the filter starts anew.
    DISTURBED
        As CONVERGED, but a force away from the drive's frequency (hum, more noise than was set) is
        in the innovations: stiffness and damping are usable.
    """

    CONVERGING = 0
    CONVERGED = 1
    NO_CONTACT = 2
    MODEL_REJECTED = 3
    DISTURBED = 4


@dataclass(frozen=True)
class TissueEstimates:
    """Estimates of the tissue, one for each sample; every array has shape (n,).

    Attributes
    ----------
    estimator : str
        Name of the estimator.
    stamp : int64
        Time of the sample [ns since the epoch].
    sequence : int64
        Number of the sample since activation.
    stiffness, damping : float
        k [N/m] and beta [N s/m].
    covariance_trace : float
        Trace of the covariance of the whole state, its units mixed as the paper mixes them.
    stiffness_variance, damping_variance, stiffness_damping_covariance : float
        [N^2/m^2], [N^2 s^2/m^2], [N^2 s/m^2].
    force_offset : float
        Estimated constant offset of the load cell [N]; 0 where the filter has no such state.
    predicted_force : float
        Force predicted from the samples before this one [N], positive in compression.
    innovation, normalized_innovation_squared : float
        nu, measured minus predicted force [N], and nu^2 / S [-]; NaN for a missing sample.
    status : uint8
        A ``Status``.
    model : text
        By which model it was made: tissue and effects, and of a file a digest of its content; empty
        in recordings of versions that did not tell it.
    """

    estimator: str
    stamp: IntArray
    sequence: IntArray
    stiffness: FloatArray
    damping: FloatArray
    covariance_trace: FloatArray
    stiffness_variance: FloatArray
    damping_variance: FloatArray
    stiffness_damping_covariance: FloatArray
    force_offset: FloatArray
    predicted_force: FloatArray
    innovation: FloatArray
    normalized_innovation_squared: FloatArray
    status: NDArray[np.uint8]
    model: TextArray

    def __len__(self) -> int:
        return self.stamp.size

    def __getitem__(self, samples: slice | NDArray[np.bool_]) -> TissueEstimates:
        """Select estimates by a slice or a boolean mask of shape (n,)."""
        columns: list[Any] = [array[samples] for array in self.arrays()]
        return TissueEstimates(self.estimator, *columns)

    def arrays(self) -> list[NDArray[Any]]:
        """Return the arrays in the order of the fields."""
        return [getattr(self, entry.name) for entry in fields(self)[1:]]

    @staticmethod
    def concatenate(parts: Sequence[TissueEstimates]) -> TissueEstimates:
        """Join the estimates of one estimator, in the order given."""
        by_field = zip(*(part.arrays() for part in parts), strict=True)
        columns: list[Any] = [np.concatenate(each) for each in by_field]
        return TissueEstimates(parts[0].estimator, *columns)


def spans_of(marked: BoolArray) -> Iterator[tuple[int, int]]:
    """Yield (first, stop) of each run of marked samples."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marked, [False]]).astype(np.int8)))
    for first, stop in zip(edges[::2], edges[1::2], strict=True):
        yield int(first), int(stop)
