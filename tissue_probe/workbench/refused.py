"""A request that cannot be done, in one sentence for the page.

What belongs here: that alone. What does not: the sentences, which are those of reader and fit.
"""

from __future__ import annotations

import re

from tissue_probe.errors import TissueProbeError

_NAMED = re.compile(r"`([a-z][a-z_]*)`")


class Refused(TissueProbeError):
    """Something that the user can mend; parameters stand in backticks."""

    @property
    def fields(self) -> list[str]:
        """The parameters that the sentence names: beside their fields it is shown."""
        return list(dict.fromkeys(_NAMED.findall(str(self))))
