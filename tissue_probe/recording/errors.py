"""The one error of reading a recording."""

from __future__ import annotations

from tissue_probe.errors import TissueProbeError


class RecordingError(TissueProbeError):
    """A recording cannot be read; the message says what is wrong, where, and what to do.

    It names parameters in backticks, `sample_rate` for one: whoever shows it may write them as its
    user states them.
    """
