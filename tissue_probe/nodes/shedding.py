"""When single samples are left out so that acquisition keeps its deadlines.

Contents: the decision, from times that were measured.
"""

from __future__ import annotations

import math
from collections import deque
from statistics import median

#: Largest part of its time in which the acquisition loop may publish. Liu and Layland (1973): tasks
#: that together take less than ln 2 of a processor keep their deadlines however many they are; the
#: rest is for waking up, reading and judging the samples.
MOST = math.log(2.0)
#: Below this part single samples come back. A load that varies by a third is not shed again at
#: once.
RESUMING_SHARE = 0.5
#: A part is measured over so much of the samples' time [s], as long as a usual block.
SLICE = 0.005
#: So many slices decide, by their median: one that was interrupted by something else does not count
#: against the samples, and fewer than five late ones in a row stay below the limits.
DECIDING = 9
#: While nothing is published singly, one slice is in so much time [s], to see the time that it
#: would take.
TRIAL_INTERVAL = 1.0
#: So many trials decide, by their median.
TRIALS = 5


class Shedding:
    """Decides whether single samples go out, from the time that publishing takes.

    Attributes
    ----------
    active : bool
        Whether single samples are shed now.
    share : float
        Part of the loop's time that publishing took lately, single samples included; 0 before
        anything is known.
    """

    def __init__(self) -> None:
        self.active = False
        self.share = 0.0
        self._shares: deque[float] = deque(maxlen=DECIDING)
        self._spent = self._due = self._since_trial = 0.0

    @property
    def allows(self) -> bool:
        """Whether the next sample may go out by itself; while shedding, in a trial."""
        return not self.active or self._since_trial >= TRIAL_INTERVAL

    def note(self, spent: float, due: float, *, singly: bool) -> None:
        """Note how long publishing took.

        Parameters
        ----------
        spent : float
            Time that it took [s].
        due : float
            Time between these samples and the next ones, within which it has to be done [s].
        singly : bool
            Whether they were published one by one, too.
        """
        if not singly:
            self._since_trial += due
            return
        self._spent += spent
        self._due += due
        if self._due < SLICE:
            return
        self._shares.append(self._spent / self._due)
        self._spent = self._due = self._since_trial = 0.0
        if len(self._shares) == self._shares.maxlen:
            self._decide()

    def _decide(self) -> None:
        self.share = median(self._shares)
        change = self.share < RESUMING_SHARE if self.active else self.share > MOST
        if change:
            self.active = not self.active
            self._shares = deque(maxlen=TRIALS if self.active else DECIDING)
