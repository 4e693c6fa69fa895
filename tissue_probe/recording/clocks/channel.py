"""One topic of a robot, message by message: the part of it that may be joined to another topic.

Contents: late and stray messages, holes, jumps, a clock that was set back, a sensor that hangs;
each judged by the messages of this topic alone, and at most one that is to come, so that the answer
is the same live and in a bag.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple

from tissue_probe.signals import LONGEST_SILENCE, NANOSECONDS

SILENT_PERIODS = 2.5
"""Between messages further apart than so many periods nothing is known; one that is lost is
bridged, as in ``even_grid.interpolate``."""

LONGEST_HELD = 10 * NANOSECONDS
"""How long messages wait for those of the other topic [ns]: twice the time that DDS's queues keep
(``nodes.qos.BLOCKS``). Messages that wait longer are dropped, so that a topic that ended fills no
memory."""


class ChannelEntry(NamedTuple):
    """A message: stamp [ns], values to interpolate, and where the robot is, which may not jump."""

    stamp: int
    row: tuple[float, ...]
    place: tuple[float, ...]


@dataclass
class Piece:
    """Messages between which all is known: they follow one another soon, and nothing jumps.

    ``clock`` counts how often the stamps' clock was set back before it, ``jumps`` the jumps of the
    place; ``closed`` once the next piece has begun.
    """

    clock: int
    jumps: int
    stamps: list[int] = field(default_factory=list)
    rows: list[tuple[float, ...]] = field(default_factory=list)
    closed: bool = False

    @property
    def span(self) -> tuple[int, int]:
        """After which stamp, and up to which, two messages are known on either side [ns]."""
        if len(self.stamps) < 4:
            return 0, -1
        return self.stamps[1], self.stamps[-2]

    def forget(self, count: int) -> None:
        """Let the first messages go."""
        del self.stamps[:count], self.rows[:count]


@dataclass(frozen=True)
class Fault:
    """A fault of messages: how often, and of the last of them in a sentence."""

    count: int
    sentence: str


class MessageChannel:
    """Takes the messages of a topic in the order they come, and keeps the usable ones.

    Parameters
    ----------
    name : str
        The topic's name in messages.
    rate : float
        Its messages a second [Hz].
    fastest : float
        The place never moves faster [m/s].
    hangs : bool
        Whether a row that repeats for long, to the last bit, is that of a sensor that hangs; all
        zero is none, as a simulated one says it in the air.

    Attributes
    ----------
    pieces : deque of Piece
        The last one is still going on.
    faults : dict
        By kind.
    taken : int
        Messages that are used.
    latest : Entry or None
        The last of them.
    """

    def __init__(self, name: str, rate: float, fastest: float = math.inf, *, hangs: bool = False):
        self.name = name
        self.period = NANOSECONDS / rate
        self._fastest = fastest / NANOSECONDS
        self._hangs = hangs
        self.pieces: deque[Piece] = deque([Piece(0, 0)])
        self.faults: dict[str, Fault] = {}
        self.taken = 0
        self.latest: ChannelEntry | None = None
        self._doubted: ChannelEntry | None = None
        self._same: ChannelEntry | None = None

    def leave_out(self, kind: str, sentence: str) -> None:
        """Count something that was wrong; the sentence follows the topic's name."""
        before = self.faults[kind].count if kind in self.faults else 0
        self.faults[kind] = Fault(before + 1, f"{self.name} {sentence}")

    def take(self, stamp: int, row: tuple[float, ...], place: tuple[float, ...] = ()) -> None:
        """Take the next message."""
        entry = ChannelEntry(stamp, row, place)
        if self._is_hanging(entry):
            self.leave_out("hanging", "repeats one value to the last bit: does its sensor hang?")
            return
        if self._doubted is not None:
            doubted, self._doubted = self._doubted, None
            self._settle(doubted, entry)
        if self.latest is None or abs(stamp - self.latest.stamp) > LONGEST_SILENCE:
            self._doubted = entry  # the next message tells whether time goes on from here
        else:
            self._use(entry)

    def _is_hanging(self, entry: ChannelEntry) -> bool:
        if not self._hangs:
            return False
        same = self._same
        if same is None or same.row != entry.row or entry.stamp < same.stamp:
            self._same = entry
            return False
        return any(entry.row) and entry.stamp - same.stamp > LONGEST_SILENCE

    def _settle(self, doubted: ChannelEntry, entry: ChannelEntry) -> None:
        """Use a message that was doubted, unless the next one goes on from those before it."""
        stray = (
            entry.stamp <= doubted.stamp
            if self.latest is None
            else abs(entry.stamp - self.latest.stamp) < abs(entry.stamp - doubted.stamp)
        )
        if stray:
            self.leave_out("stray stamps", "has a stamp that is far from those around it: left out")
        else:
            self._use(doubted)

    def _use(self, entry: ChannelEntry) -> None:
        """Add a message to the present piece, or begin another with it."""
        piece, before = self.pieces[-1], self.latest
        if before is not None:
            step = entry.stamp - before.stamp
            if step < -LONGEST_SILENCE:
                said = f"has stamps that go back by {-step / NANOSECONDS:.3g} s: a clock was set"
                self.leave_out("clock set back", said)
                piece = self._begin(Piece(piece.clock + 1, 0))
            elif step <= 0:
                self.leave_out("late", "comes out of order, or twice: stamps must ascend; left out")
                return
            elif (way := math.dist(entry.place, before.place)) > self._way(step):
                said = f"jumps by {1e3 * way:.3g} mm in {step / 1e6:.3g} ms: a new run begins"
                self.leave_out("jumps", said)
                piece = self._begin(Piece(piece.clock, piece.jumps + 1))
            elif step > SILENT_PERIODS * self.period:
                said = f"has no message for {step / NANOSECONDS:.3g} s by its stamps"
                self.leave_out("holes", said)
                piece = self._begin(Piece(piece.clock, piece.jumps))
        piece.stamps.append(entry.stamp)
        piece.rows.append(entry.row)
        self.latest = entry
        self.taken += 1

    def _way(self, step: int) -> float:
        """Return how far the place may move in a step of time; stamps may jitter by a period."""
        return self._fastest * max(step, self.period)

    def _begin(self, piece: Piece) -> Piece:
        self.pieces[-1].closed = True
        self.pieces.append(piece)
        return piece

    def next_piece(self) -> bool:
        """Leave the first piece; return whether there is another. Of the last, messages go."""
        if len(self.pieces) > 1:
            self.pieces.popleft()
            return True
        self.pieces[0].forget(len(self.pieces[0].stamps))
        return False

    def forget_oldest(self) -> None:
        """Let go of messages that have waited for longer than ``LONGEST_HELD``."""
        excess = sum(len(piece.stamps) for piece in self.pieces) - round(LONGEST_HELD / self.period)
        while excess > 0:
            first = self.pieces[0]
            count = min(excess, len(first.stamps))
            excess -= count
            first.forget(count)
            if not first.stamps and first.closed:
                self.pieces.popleft()
