"""A recording's bytes, told in a line: the same bytes give the same line.

Contents: the SHA-256 of a file, and of a folder.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

#: Read at once: a long recording does not fill the memory.
_BYTES_AT_ONCE = 1 << 20


def digest(path: Path) -> str:
    """Return the SHA-256 of a file's bytes, or of all files in a folder with their names.

    Raises
    ------
    OSError
        If a file cannot be read.
    """
    found = hashlib.sha256()
    if not path.is_dir():
        with path.open("rb") as file:
            while piece := file.read(_BYTES_AT_ONCE):
                found.update(piece)
        return found.hexdigest()
    for part in sorted(each for each in path.rglob("*") if each.is_file()):
        found.update(f"{part.relative_to(path)} {digest(part)}".encode())
    return found.hexdigest()
