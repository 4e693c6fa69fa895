"""The one error of reading a recording."""

from __future__ import annotations

from tissue_probe.errors import TissueProbeError


class RecordingError(TissueProbeError):
    """A recording cannot be read; the message says the fault, the place, and the remedy.

    It names parameters in backticks, `sample_rate` for one: a program that shows it may write them
    as its user states them.
    """
