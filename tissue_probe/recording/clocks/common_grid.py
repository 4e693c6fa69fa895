"""Two topics, each at its own rate and stamps, as samples of one even grid: live as in a bag.

Contents: the grid, which of its points both topics cover, the runs of samples.
"""

from __future__ import annotations

from bisect import bisect_left

import numpy as np

from tissue_probe.recording.clocks.channel import MessageChannel, Piece
from tissue_probe.recording.clocks.local_cubic import local_cubic
from tissue_probe.signals import NANOSECONDS, FloatArray, SampleBlock, begin_anew


class CommonGrid:
    """Samples at the whole multiples of a period since the epoch, as far as both topics are known.

    The samples do not depend, to the last bit, on when they are asked for, nor on how the messages
    of the two topics come between one another: a point of the grid is a function of the two
    messages of each topic before it and of the two after it. Points in a hole of either topic have
    no sample. Numbers go on with the grid across holes; after a silence (``signals.begin_anew``), a
    jump, or a clock that was set back, another run begins at 0.

    Parameters
    ----------
    period : int
        Time between two samples [ns].
    position : Channel
        Rows of the displacement u [m], then the direction of pressing, shape (1 + c,).
    force : Channel
        Rows of the force in the same axes [N], shape (c,).

    Attributes
    ----------
    samples, runs : int
        How many there were so far.
    """

    def __init__(self, period: int, position: MessageChannel, force: MessageChannel) -> None:
        self._period = period
        self._position, self._force = position, force
        self._next = 0
        self._last: tuple[tuple[int, int, int], int] | None = None
        self._origin = 0
        self.samples = self.runs = 0

    @property
    def clocks_apart(self) -> bool:
        """Whether the clock of one topic was set back, and that of the other was not."""
        return self._position.pieces[-1].clock != self._force.pieces[-1].clock

    def take(self) -> list[SampleBlock]:
        """Return the samples that have become known since the last call."""
        blocks = []
        going_on = True
        while going_on:
            position, force = self._position.pieces[0], self._force.pieces[0]
            if position.clock != force.clock:
                behind = self._position if position.clock < force.clock else self._force
                going_on = behind.next_piece()
                self._next = 0
                continue
            after = max(position.span[0], force.span[0])
            until = min(position.span[1], force.span[1])
            first, last = max(self._next, after // self._period + 1), until // self._period
            if first <= last:
                blocks.append(self._block(position, force, first, last))
                self._next = last + 1
            going_on = self._leave_used(position, force)
        for channel in (self._position, self._force):
            self._forget_used(channel.pieces[0])
            channel.forget_oldest()
        return blocks

    def _leave_used(self, position: Piece, force: Piece) -> bool:
        """Leave the piece that ends first, if it has ended; return whether one has."""
        ends = position.span[1], force.span[1]
        if position.closed and ends[0] <= ends[1]:
            return self._position.next_piece()
        if force.closed and ends[1] <= ends[0]:
            return self._force.next_piece()
        return False

    def _forget_used(self, piece: Piece) -> None:
        """Let go of messages that no further sample needs."""
        used = bisect_left(piece.stamps, self._next * self._period) - 2
        if used > 0:
            piece.forget(used)

    def _block(self, position: Piece, force: Piece, first: int, last: int) -> SampleBlock:
        at = np.arange(first, last + 1, dtype=np.int64) * self._period
        moved, felt = (_values(piece, at) for piece in (position, force))
        along = np.zeros(at.size)
        for column in range(felt.shape[1]):
            along += moved[:, 1 + column] * felt[:, column]
        self._number((position.clock, position.jumps, force.jumps), first, last)
        self.samples += at.size
        return SampleBlock(
            stamp=first * self._period,
            sequence=first - self._origin,
            sample_period=self._period / NANOSECONDS,
            position=moved[:, 0],
            force=along,
            command=np.full(at.size, np.nan),
        )

    def _number(self, run: tuple[int, int, int], first: int, last: int) -> None:
        """Begin to number anew where another run begins."""
        gap = (first - self._last[1]) * self._period if self._last else 0
        if self._last is None or run != self._last[0] or begin_anew(gap, self._period, 1):
            self._origin = first
            self.runs += 1
        self._last = run, last


def _values(piece: Piece, at: np.ndarray) -> FloatArray:
    """Return a piece's rows at times within its span."""
    begin = max(bisect_left(piece.stamps, int(at[0])) - 2, 0)
    stop = bisect_left(piece.stamps, int(at[-1])) + 2
    stamps = np.array(piece.stamps[begin:stop], dtype=np.int64)
    return local_cubic(stamps, np.array(piece.rows[begin:stop]), at)
