"""From the parameters that an error names to the options that a user gives."""

from __future__ import annotations

import re
from collections.abc import Mapping

#: Options that are called otherwise than the parameter.
OTHERWISE: Mapping[str, str] = {
    "samples_topic": "--topic",
    "settings": "--set",
    "course": "--input",
    "constants": "--constant",
}

_NAMED = re.compile(r"`([a-z][a-z_]*)`")


def with_options(text: str) -> str:
    """Write every parameter in backticks as the option that states it: `sample_rate`."""
    return _NAMED.sub(
        lambda found: OTHERWISE.get(found[1], f"--{found[1].replace('_', '-')}"), text
    )
