"""Files that are dropped on the page, copied into the server's own folder.

Contents: their name and their size.
"""

from __future__ import annotations

import re
import secrets
import shutil
from collections.abc import AsyncIterator
from pathlib import Path

from tissue_probe.workbench.refusal import RequestRefused

#: Most bytes of one file: a day of 2 kHz as text has some 6 GB, an hour 0.3 GB.
LARGEST_UPLOAD = 2**31
#: Space that must stay free on the disk [bytes]: a fit and the system need some.
SPARE = 2**28
#: Most bytes of a name: file systems take 255, and some more are put before or behind.
LONGEST_NAME = 120
_PLAIN = re.compile(r"[^\w .()+,@=-]")


async def keep(name: str, parts: AsyncIterator[bytes], folder: Path) -> Path:
    """Write a file that comes in parts; return its path, in a folder of its own.

    Raises
    ------
    Refused
        If it is larger than ``LARGEST_UPLOAD`` or than the disk bears.
    """
    own = folder / secrets.token_hex(8)
    own.mkdir(parents=True)
    path, size = own / plain(name), 0
    most = min(LARGEST_UPLOAD, shutil.disk_usage(folder).free - SPARE)
    try:
        with path.open("wb") as file:
            async for part in parts:
                size += len(part)
                if size > most:
                    raise RequestRefused(
                        f"{path.name} has more than {most / 1e6:.0f} MB; start `tissue_probe "
                        "workbench` with the file's name instead, which copies nothing"
                    )
                file.write(part)
    except BaseException:
        shutil.rmtree(own, ignore_errors=True)
        raise
    return path


def plain(name: str) -> str:
    """Return a file's name that is nothing but a name."""
    last = _PLAIN.sub("_", name.replace("\\", "/").rpartition("/")[2])
    # By bytes, as file systems count; the ending tells its kind.
    kept = last.encode()[-LONGEST_NAME:].decode(errors="ignore")
    return kept.strip(". ") or "recording"
