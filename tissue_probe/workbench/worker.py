"""The process in which everything runs that may take long: reading, fits, searches, reports.

Contents: its loop, and how it tells its progress.

It has no threads, so that a diagnosis may have a copy of it do half of the work; and it is stopped
by being ended, copy and all, since it leads a group of processes.
"""

from __future__ import annotations

import os
import struct
import sys
from typing import BinaryIO

from tissue_probe.errors import TissueProbeError
from tissue_probe.one_line import sentence
from tissue_probe.workbench.messages import as_json

#: A frame: its kind, and how many bytes follow.
FRAME = struct.Struct("<cQ")
WORK_TOLD, DONE, WORK_FAILED = b"t", b"d", b"f"
#: A pipe takes so many bytes at once, or none, with any number of writers: a copy of the process
#: tells, too (POSIX's PIPE_BUF is 512 at least).
PIPE_BYTES = 512


def main() -> None:
    """Do the tasks that come through standard input, until it ends."""
    given, answer = sys.stdin.buffer, os.dup(1)
    # Text that a user's own effect prints is no answer.
    os.dup2(2, 1)

    def tell(told: dict[str, object]) -> None:
        text = as_json(told).encode()
        if FRAME.size + len(text) <= PIPE_BYTES:
            os.write(answer, FRAME.pack(WORK_TOLD, len(text)) + text)

    while (work := read_frame(given)) is not None:
        kind, content = _do_job(work[1], tell)
        _write_all(answer, FRAME.pack(kind, len(content)) + content)


def read_frame(file: BinaryIO) -> tuple[bytes, bytes] | None:
    """Return the next frame's kind and content; None at the end."""
    head = file.read(FRAME.size)
    if len(head) < FRAME.size:
        return None
    kind, size = FRAME.unpack(head)
    content = file.read(size)
    return (kind, content) if len(content) == size else None


def _do_job(content: bytes, tell: object) -> tuple[bytes, bytes]:
    from tissue_probe.workbench import work

    try:
        return DONE, work.do(content, tell)
    except (TissueProbeError, OSError) as error:
        return WORK_FAILED, sentence(error).encode()
    except MemoryError:
        return WORK_FAILED, b"this takes more memory than there is; give a shorter recording"
    except Exception as error:
        import traceback

        traceback.print_exc()
        told = f"an error of the program itself: {type(error).__name__}: {error}"
        return WORK_FAILED, " ".join(told.split()).encode()


def _write_all(descriptor: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(descriptor, view) :]


if __name__ == "__main__":
    main()
