"""Parts of a long benchmark: where one fails, the others go on.

Contents: that alone.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable

from tissue_probe.errors import TissueProbeError

#: Of the suite, of a process of its own, of numbers, files and arguments.
FAILURES = TissueProbeError, subprocess.SubprocessError, ArithmeticError, OSError, ValueError


def results_of(
    part: Callable[[], dict[str, float]], say: Callable[[str], None]
) -> dict[str, float]:
    """Return the results of a part; none where it fails, and say why."""
    try:
        return part()
    except FAILURES as error:
        say(f"failed, and the rest goes on: {error}")
        return {}
