"""The decoder chip as its digital lines show it."""

from __future__ import annotations

OE, SEL1, SEL2 = 1, 2, 4
#: How far to shift the latch for each selection.
SHIFTS = {SEL2: 24, SEL1 | SEL2: 16, 0: 8, SEL1: 0}


class Chip:
    """Latches its count while its output is enabled, and shows the selected byte."""

    def __init__(self) -> None:
        self._latch = 0
        self._control = OE

    def set_control(self, control: int, count: int) -> None:
        """Take new levels of OE, SEL1 and SEL2; ``count`` is what the encoder stands at now."""
        if self._control & OE and not control & OE:
            self._latch = count % 2**32
        self._control = control

    @property
    def data(self) -> int:
        """Levels of D0 to D7; floating, here high, while the output is disabled."""
        if self._control & OE:
            return 0xFF
        return self._latch >> SHIFTS[self._control & (SEL1 | SEL2)] & 0xFF
