"""Message definitions as a recording carries them: a type's text and that of all it uses.

Contents: finding ``.msg`` files and joining them as ``ros2 bag`` does.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

_BUILT_IN = {
    *("bool", "byte", "char", "string", "wstring", "float32", "float64"),
    *("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"),
}
_FIELD = re.compile(r"^\s*(\w+(?:/\w+)*)[^#\n]*?\s+\w", re.MULTILINE)
_SEPARATOR = "\n" + 80 * "=" + "\n"


def share_folders() -> list[Path]:
    """Return where packages keep their definitions: sourced prefixes, and that of PyPI wheels."""
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(prefix, "share") for prefix in [*prefixes, sys.prefix] if prefix]


def message_definition(typename: str, share_folders: Sequence[str | Path]) -> str:
    """Return the full definition of a message type (schema encoding ``ros2msg``).

    The original text with its comments, so with its units, then each type it uses, once,
    after a line of 80 ``=`` and a line ``MSG: package/Name``; the order is that of ``ros2 bag``.

    Parameters
    ----------
    typename : str
        Such as ``tissue_probe_msgs/msg/ProbeSamples``.
    share_folders : sequence of paths
        Folders that hold ``<package>/msg/<Name>.msg``; the first that has the file counts.

    Raises
    ------
    FileNotFoundError
        If the type, or one that it uses, is in none of the folders.
    """
    text = _read(typename, share_folders)
    parts = [text]
    _append_used(typename, text, share_folders, parts, seen=set())
    return "".join(parts)


def _append_used(
    typename: str,
    text: str,
    share_folders: Sequence[str | Path],
    parts: list[str],
    seen: set[str],
) -> None:
    for name in _used_types(text, package=typename.split("/")[0]):
        if name not in seen:
            seen.add(name)
            used = _read(name, share_folders)
            parts.append(f"{_SEPARATOR}MSG: {name}\n{used}")
            _append_used(name, used, share_folders, parts, seen)


def _used_types(text: str, package: str) -> Iterable[str]:
    names = set(_FIELD.findall(text)) - _BUILT_IN
    return sorted(name if "/" in name else f"{package}/{name}" for name in names)


def _read(typename: str, share_folders: Sequence[str | Path]) -> str:
    package, *_, name = typename.split("/")
    for folder in share_folders:
        file = Path(folder, package, "msg", f"{name}.msg")
        if file.is_file():
            return file.read_text(encoding="utf-8")
    searched = ", ".join(str(folder) for folder in share_folders) or "no folder at all"
    raise FileNotFoundError(
        f"no definition of {typename} ({package}/msg/{name}.msg) in {searched}; "
        f"install {package} or source the workspace that has it"
    )
