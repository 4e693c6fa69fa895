"""A caller's statements, as the options of the command line that state the same.

Contents: the words of a command.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from shlex import quote
from typing import Any

from tissue_probe.analysis.question_items import ITEMS_BY_NAME

#: Parameters of a file that are options of another name.
TOPIC_OPTION = {"samples_topic": "topic"}


def as_options(stated: Mapping[str, Any]) -> list[str]:
    """Return options with their values, quoted for a shell; a name without a value is left out."""
    return [_option(TOPIC_OPTION.get(name, name), value) for name, value in _write_options(stated)]


def _option(name: str, value: str) -> str:
    called = (ITEMS_BY_NAME[name].option or name) if name in ITEMS_BY_NAME else name
    option = f"--{called.replace('_', '-')}"
    return f"{option} {quote(value)}" if value else option


def _write_options(stated: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield parameters with their values, as the command line takes them, each as often."""
    for name, value in stated.items():
        if isinstance(value, Mapping):
            for key, given in value.items():
                numbers = given if isinstance(given, (tuple, list)) else (given,)
                yield name, f"{key}={'+-'.join(f'{n:g}' for n in numbers)}"
        elif isinstance(value, (list, tuple)):
            yield from ((name, str(each)) for each in value)
        elif value is True:
            yield name, ""
        elif value is not None and value is not False:
            yield name, str(value)
