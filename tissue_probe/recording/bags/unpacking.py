"""Unpacking the packed parts of a bag, within bounds.

Contents: zstd, LZ4 and bzip2 as bags use them, and how much may come out of them.
"""

from __future__ import annotations

import bz2
from pathlib import Path
from typing import BinaryIO

import zstandard
from lz4.frame import LZ4FrameDecompressor

from tissue_probe.recording.errors import RecordingError

LARGEST_UNPACKED = 256 * 2**20
"""Most that one chunk or message may unpack to [bytes]. A writer holds a chunk in memory until it
is full, 1 to 4 MiB as writers come; so does a reader."""

TOTAL, LARGEST_RATIO = 4 * 2**30, 200
"""Most that a file may unpack to: so many bytes, or so many times its size if that is more.
Messages differ at least in their times, of which no packing leaves much less than a hundredth."""

UNPACKING_ERRORS = (zstandard.ZstdError, RuntimeError, EOFError, OSError, ValueError)
"""Errors of unpacking damaged bytes."""

_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
_BLOCK = 2**20
#: Bytes of a chunk that was cut off which are unpacked at once: no more come out than memory holds.
_PIECE_UNPACKED = 2**10


def unpack(name: object, packing: str, data: bytes, size: int) -> bytes:
    """Unpack one chunk.

    Parameters
    ----------
    name : path
        The file's name in messages.
    packing : {"", "none", "zstd", "lz4", "bz2"}
        How it is packed.
    data : bytes
        The packed bytes.
    size : int
        How large it says that it is unpacked [bytes].

    Raises
    ------
    RecordingError
        If more than ``LARGEST_UNPACKED`` would come out of it.
    UNPACKING_ERRORS
        If it is damaged, or another size than it says.
    """
    most = min(size, LARGEST_UNPACKED) + 1  # one more tells that there is more
    match packing:
        case "" | "none":
            return data
        case "zstd":
            found = zstandard.ZstdDecompressor().stream_reader(data).read(most)
        case "lz4":
            found = LZ4FrameDecompressor().decompress(data, most)
        case "bz2":
            found = bz2.BZ2Decompressor().decompress(data, most)
        case _:
            raise ValueError(f"it is packed as '{packing}', which is not known")
    if len(found) > LARGEST_UNPACKED:
        raise _too_large(name, f"a chunk of it unpacks to more than {LARGEST_UNPACKED >> 20} MiB")
    if len(found) != size:
        raise ValueError(f"it says that it unpacks to {size} bytes, and does not")
    return found


def unpack_beginning(name: object, packing: str, data: bytes) -> bytes:
    """Unpack the complete blocks of a chunk that was cut off.

    Parameters
    ----------
    name, packing
        As ``unpack`` has them; nothing comes out of a packing that is not known.
    data : bytes
        The beginning of the packed bytes.

    Raises
    ------
    RecordingError
        If more than ``LARGEST_UNPACKED`` would come out of it.
    """
    if packing in ("", "none"):
        return data
    streams = {
        "zstd": lambda: zstandard.ZstdDecompressor().decompressobj(),
        "lz4": LZ4FrameDecompressor,
        "bz2": bz2.BZ2Decompressor,
    }
    if packing not in streams:
        return b""
    stream, found = streams[packing](), bytearray()
    for begin in range(0, len(data), _PIECE_UNPACKED):
        try:
            found += stream.decompress(data[begin : begin + _PIECE_UNPACKED])
        except UNPACKING_ERRORS:
            break
        if len(found) > LARGEST_UNPACKED:
            raise _too_large(
                name, f"a chunk of it unpacks to more than {LARGEST_UNPACKED >> 20} MiB"
            )
    return bytes(found)


def unpack_message(name: object, data: bytes, budget: Budget) -> bytes:
    """Return a message in CDR, unpacked if ``ros2 bag`` packed it by itself.

    CDR begins with a zero, and never as zstd does.

    Raises
    ------
    RecordingError
        If more would come out of it than a message or the file may hold, or it is damaged.
    """
    if not data.startswith(_ZSTD_MAGIC):
        return data
    try:
        found = zstandard.ZstdDecompressor().stream_reader(data).read(LARGEST_UNPACKED + 1)
    except zstandard.ZstdError as error:
        raise RecordingError(f"{name}: a message that is packed by zstd is damaged") from error
    if len(found) > LARGEST_UNPACKED:
        raise _too_large(name, f"a message of it unpacks to more than {LARGEST_UNPACKED >> 20} MiB")
    budget.spend(len(found))
    return found


def is_packed(head: bytes) -> bool:
    """Return whether a file that begins so is packed by zstd."""
    return head.startswith(_ZSTD_MAGIC)


def unpack_file(path: Path, to: BinaryIO) -> None:
    """Unpack a file as a whole.

    Raises
    ------
    RecordingError
        If more would come out of it than a file may hold, or it is damaged.
    """
    budget = Budget(path)
    with path.open("rb") as file:
        packed = zstandard.ZstdDecompressor().stream_reader(file, read_across_frames=True)
        try:
            while block := packed.read(_BLOCK):
                budget.spend(len(block))
                to.write(block)
        except zstandard.ZstdError as error:
            raise RecordingError(
                f"{path} is packed by zstd, and damaged ({error}); 'zstd -d' may save its beginning"
            ) from error


class Budget:
    """The bytes that may still be unpacked of one file.

    Parameters
    ----------
    path : path
        The file.
    name : path, optional
        Its name in messages, if otherwise.
    """

    def __init__(self, path: Path, name: object = None) -> None:
        self._name = name or path
        self._most = max(TOTAL, LARGEST_RATIO * path.stat().st_size)
        self._left = self._most

    def spend(self, size: int) -> None:
        """Count bytes that were unpacked.

        Raises
        ------
        RecordingError
            If they are more than the file may hold.
        """
        self._left -= size
        if self._left < 0:
            raise _too_large(self._name, f"it unpacks to more than {self._most >> 20} MiB")


def _too_large(name: object, said: str) -> RecordingError:
    return RecordingError(
        f"{name} is not read: {said}, as no measurement does; if it is one, write it anew in "
        "smaller chunks, or unpacked"
    )
