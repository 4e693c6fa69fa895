"""What a row depends on: the question with the version, and the file's bytes.

Contents: keys of both, and the state of a file by which its bytes are known without reading them.
"""

from __future__ import annotations

import hashlib
import json
import stat
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


def state_of(path: Path) -> dict[str, int]:
    """Return ``size`` [bytes], ``changed`` [ns since 1970] and ``inode`` of a file.

    A file in the state in which it was read has the bytes that were read, as Git's index supposes,
    too. Of a folder (a bag) it is the size of all its files, the latest change in it, and its own
    inode.

    Raises
    ------
    OSError
        If there is no such file.
    """
    own = path.stat()
    if not stat.S_ISDIR(own.st_mode):
        return {"size": own.st_size, "changed": own.st_mtime_ns, "inode": own.st_ino}
    parts = [each.stat() for each in path.rglob("*")]
    return {
        "size": sum(each.st_size for each in parts if stat.S_ISREG(each.st_mode)),
        "changed": max(each.st_mtime_ns for each in (own, *parts)),
        "inode": own.st_ino,
    }


def _plain(given: Any) -> Any:
    if isinstance(given, Path) or (isinstance(given, str) and Path(given).is_file()):
        return digest(Path(given))
    if isinstance(given, (list, tuple)):
        return [_plain(each) for each in given]
    return given
