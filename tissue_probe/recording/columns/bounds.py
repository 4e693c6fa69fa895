"""How much a file may become when it is read.

Contents: the limits, and counting the expanded size of a compressed file.
"""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

from tissue_probe.recording.errors import RecordingError

LARGEST_EXPANDED = 2**30
"""Most bytes that a compressed file may expand to.

A sheet of Excel's million rows and ten columns has a tenth of it; a larger one is a program's
error, or meant to fill the memory.
"""

MOST_ROWS = 10**8
"""Most rows that are read: 14 hours at 2 kHz; three columns of it fill 2.4 GB."""

_PIECE = 2**20


def check_rows(path: Path, rows: int) -> None:
    """Refuse a table that is too long.

    Raises
    ------
    RecordingError
        If it has more than ``MOST_ROWS``.
    """
    if rows > MOST_ROWS:
        raise RecordingError(
            f"{path} has {rows} rows, more than the {MOST_ROWS} that are read; cut it into parts"
        )


def check_size(path: Path, size: int) -> None:
    """Refuse a file that would expand to more than ``LARGEST_EXPANDED`` bytes.

    Raises
    ------
    RecordingError
        If it would.
    """
    if size > LARGEST_EXPANDED:
        raise RecordingError(
            f"{path} expands to more than {LARGEST_EXPANDED // 2**20} MiB, the most that is read; "
            "write the columns that are needed to a file of their own"
        )


def check_zip(path: Path, members: zipfile.ZipFile) -> None:
    """Refuse an archive that expands to too much, also where it declares less.

    Raises
    ------
    RecordingError
        If it does, or is damaged.
    """
    total = 0
    try:
        for member in members.infolist():
            if (
                member.compress_size * 1032 < LARGEST_EXPANDED - total
            ):  # deflate never expands by more
                total += min(member.file_size, member.compress_size * 1032)
                continue
            member.file_size = LARGEST_EXPANDED + 2 * _PIECE  # the declared size is not trusted
            with members.open(member) as file:
                while piece := file.read(_PIECE):
                    total += len(piece)
                    check_size(path, total)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError) as error:
        raise RecordingError(f"{path} is damaged: {error}") from error
    check_size(path, total)
