"""YAML of files and recordings, which may come from anywhere, read within bounds.

Contents: how large, how deep and how much repeated a document may be, and the error of one that
cannot be read.

Every reader of YAML in the package is this one. libyaml scans: PyYAML's own scanner takes minutes
for a hundred thousand brackets.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from tissue_probe.errors import TissueProbeError

#: Longest document [characters], as it stands and with its aliases written out: four times a
#: calibration with a thousand tares, the longest that the suite writes. It is read in a second.
LONGEST_YAML = 250_000
#: Deepest nesting: the suite's deepest document has five levels, and a function that reads or
#: prints one goes down by a few of the interpreter's 1000 calls a level.
DEEPEST_YAML = 50
#: Longest whole number [characters]: a stamp in ns has 19, and the time that longer ones take grows
#: with the square.
MOST_DIGITS = 100


class YamlError(TissueProbeError):
    """A text that is not read; the message goes on after "it", and has no name of a file."""


def read(path: str | Path) -> Any:
    """Return the content of a file in YAML, of plain types: dict, list, str, numbers, dates, None.

    Raises
    ------
    OSError
        If the file cannot be read.
    YamlError
        If it is not YAML, or beyond a bound.
    """
    return parse(read_text(path))


def read_text(path: str | Path) -> str:
    """Return the text of a file that is to be YAML.

    Raises
    ------
    OSError
        If the file cannot be read.
    YamlError
        If it is no text, or longer than a document may be.
    """
    with Path(path).open("rb") as file:
        content = file.read(
            4 * LONGEST_YAML + 1
        )  # no more bytes than that many characters may take
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if len(content) > 4 * LONGEST_YAML:  # the cut fell into a character
            raise _too_long() from None
        raise YamlError(f"is not YAML (byte {error.start} is no UTF-8)") from None


def parse(text: str) -> Any:
    """Return the content of a text in YAML, as ``read`` does of a file.

    Raises
    ------
    YamlError
        If it is not YAML, or beyond a bound.
    """
    if len(text) > LONGEST_YAML:
        raise _too_long()
    try:
        _measure(text)
        return yaml.load(text, _Loader)
    except yaml.YAMLError as error:
        raise YamlError(f"is not YAML{_where(error)}") from None
    except YamlError:
        raise
    except ValueError as error:  # of a value, such as the day 2026-13-45
        raise YamlError(f"is not YAML ({' '.join(str(error).split())})") from None
    except Exception:  # PyYAML lets any error of a tagged value, such as !!bool x, pass
        raise YamlError("is not YAML (a value is not of the type in its tag)") from None


def _too_long() -> YamlError:
    return YamlError(
        f"has more than {LONGEST_YAML} characters, so it is none of this suite's files"
    )


def _where(error: yaml.YAMLError) -> str:
    mark = getattr(error, "problem_mark", None)
    return f" (line {mark.line + 1}: {error.problem})" if mark else ""


class _Level:
    """A list or a mapping that is being measured."""

    def __init__(self, anchor: str | None, is_mapping: bool) -> None:
        self.anchor = anchor
        self.length = 1
        self._keys: set[object] | None = set() if is_mapping else None
        self._is_key = True

    def take(self, key: object) -> bool:
        """Take one more node; return whether it is a key that is there already."""
        if self._keys is None:
            return False
        is_key, self._is_key = self._is_key, not self._is_key
        if not is_key or key is None:
            return False
        twice = key in self._keys
        self._keys.add(key)
        return twice


def _measure(text: str) -> None:
    """Raise a YamlError for a document that is too deep, repeats too much, or names a key twice.

    It is scanned, not built: the target of an alias is counted each time that the alias stands
    there.
    """
    lengths: dict[str | None, int | None] = {}  # of an anchor's target; None before its end
    levels = [_Level(None, is_mapping=False)]
    for event in yaml.parse(text, _Loader):
        line = event.start_mark.line + 1
        if isinstance(event, yaml.NodeEvent):
            key = _key(event)
            if levels[-1].take(key) and key is not None:
                raise YamlError(f"has the key {key[0]!r:.60} twice (line {line}): leave one out")
        if isinstance(event, yaml.CollectionStartEvent):
            levels.append(_Level(event.anchor, isinstance(event, yaml.MappingStartEvent)))
            lengths[event.anchor] = None
            if len(levels) > DEEPEST_YAML + 1:
                raise YamlError(f"is nested more than {DEEPEST_YAML} levels deep (line {line})")
        elif isinstance(event, yaml.CollectionEndEvent):
            level = levels.pop()
            lengths[level.anchor] = level.length
            levels[-1].length += level.length
        elif isinstance(event, yaml.ScalarEvent):
            lengths[event.anchor] = 1 + len(event.value)
            levels[-1].length += 1 + len(event.value)
        elif isinstance(event, yaml.AliasEvent):
            length = lengths.get(event.anchor, 0)  # that there is none, the loader tells
            if length is None:
                raise YamlError(f"holds itself: *{event.anchor} (line {line}) stands within it")
            levels[-1].length += length
        if sum(level.length for level in levels) > LONGEST_YAML:
            raise YamlError(
                f"has more than {LONGEST_YAML} characters with its aliases written out (line "
                f"{line})"
            )


def _key(event: yaml.NodeEvent) -> tuple[str, str | None, bool] | None:
    """Return the part of a key that tells it from others; None for one that is not a mere word."""
    if not isinstance(event, yaml.ScalarEvent):
        return None
    return event.value, event.tag, event.implicit[0]


class _Loader(yaml.CSafeLoader):  # type: ignore[misc]  # PyYAML has no types
    """PyYAML's loader of plain types, with whole numbers of a sensible length."""

    def whole_number(self, node: yaml.ScalarNode) -> int:
        """Return a whole number.

        Raises
        ------
        yaml.constructor.ConstructorError
            If it is too long.
        """
        if len(node.value) > MOST_DIGITS:
            raise yaml.constructor.ConstructorError(
                None, None, f"a number has more than {MOST_DIGITS} digits", node.start_mark
            )
        return int(self.construct_yaml_int(node))


_Loader.add_constructor("tag:yaml.org,2002:int", _Loader.whole_number)
