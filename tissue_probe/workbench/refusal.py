"""A request that cannot be done, in one sentence for the page.

Contents: that alone, of any error that tells the user something to mend.
"""

from __future__ import annotations

import re
from pathlib import Path

from tissue_probe.errors import TissueProbeError
from tissue_probe.one_line import sentence

_NAMED = re.compile(r"`([a-z][a-z_]*)`")


class RequestRefused(TissueProbeError):
    """Something that the user can mend; parameters stand in backticks."""

    @property
    def fields(self) -> list[str]:
        """The parameters that the sentence names: beside their fields it is shown."""
        return list(dict.fromkeys(_NAMED.findall(str(self))))


def describe_refusal(error: TissueProbeError | OSError) -> RequestRefused:
    """Return an error as a page is told it: a file of this machine by its name, not its path."""
    if isinstance(error, RequestRefused):
        return error
    if isinstance(error, OSError) and error.filename and error.strerror:
        return RequestRefused(f"{Path(str(error.filename)).name}: {error.strerror}")
    return RequestRefused(sentence(error))
