"""What a row depends on, as texts: the question with the version, and the file's bytes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tissue_probe
from tissue_probe.recording.digest import digest


def key_of_question(task: str, question: Mapping[str, Any]) -> str:
    """Return the key of a task, its keywords, and the version of the package.

    Files that the question names (a model, effects) count by their bytes, not by their path.

    Raises
    ------
    OSError
        If a file cannot be read.
    """
    asked = {name: _plain(given) for name, given in question.items()}
    text = json.dumps([tissue_probe.__version__, task, asked], sort_keys=True, default=repr)
    return hashlib.sha256(text.encode()).hexdigest()


def key_of(path: Path, of_question: str) -> str:
    """Return the key of a row: another one where the row could be another.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    return hashlib.sha256(f"{digest(path)} {of_question}".encode()).hexdigest()


def _plain(given: Any) -> Any:
    if isinstance(given, Path) or (isinstance(given, str) and Path(given).is_file()):
        return digest(Path(given))
    if isinstance(given, (list, tuple)):
        return [_plain(each) for each in given]
    return given
