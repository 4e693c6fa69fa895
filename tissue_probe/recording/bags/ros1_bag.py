"""Reading the bags of ROS 1 (``.bag``), through ``rosbags``.

Contents: messages as bytes out of such a file.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from rosbags.rosbag1 import Reader, ReaderError
from rosbags.rosbag1.reader import Header, IndexData, RecordType, decompressors

from tissue_probe.recording.bags.bag import RawMessage, Topic
from tissue_probe.recording.bags.unpacking import UNPACKING_ERRORS, Budget, unpack
from tissue_probe.recording.errors import RecordingError

# Errors of rosbags on damaged content.
_ROS1_ERRORS = (
    ReaderError,
    struct.error,
    AssertionError,
    LookupError,
    OverflowError,
    *UNPACKING_ERRORS,
)
_PACKINGS = {decompressor: packing for packing, decompressor in decompressors.items()}


class Ros1Bag:
    """A ``.bag`` file (``bag.Bag``).

    Publish times are not kept in it: they are the log times. It has no checksums.

    Parameters
    ----------
    path : path
        The file.
    name : path, optional
        Its name in messages, if otherwise.

    Raises
    ------
    RecordingError
        If ``rosbags`` cannot read it.
    """

    def __init__(self, path: Path, name: object = None) -> None:
        self._path = path
        self._name = name or path
        self.profile = "ros1"
        self.metadata: dict[str, dict[str, str]] = {}
        self.truncated = False
        with self._reader() as reader:
            self.topics = tuple(
                dict.fromkeys(
                    Topic(entry.topic, entry.msgtype, entry.msgdef.data, "ros1msg", "ros1")
                    for entry in reader.connections
                )
            )

    def messages(self, topics: Collection[str]) -> Iterator[RawMessage]:
        """Yield the messages of the topics so named, in the order in which they were stored."""
        with self._reader() as reader:
            chosen = [entry for entry in reader.connections if entry.topic in topics]
            if not chosen:  # to rosbags, no choice means all
                return
            channels = {
                entry.id: Topic(entry.topic, entry.msgtype, entry.msgdef.data, "ros1msg", "ros1")
                for entry in chosen
            }
            for connection, time, data in reader.messages(chosen):
                yield RawMessage(channels[connection.id], time, time, bytes(data))

    def count(self, topics: Collection[str]) -> int:
        """Return how many messages of the topics so named there are."""
        with self._reader() as reader:
            return sum(entry.msgcount for entry in reader.connections if entry.topic in topics)

    @contextmanager
    def _reader(self) -> Iterator[Reader]:
        """Open ``rosbags``' reader: bounded, and in the order in which messages were stored."""
        try:
            with Reader(self._path) as reader:
                self._bound_chunks(reader)
                reader.indexes = {
                    number: sorted(_Stored(*entry) for entry in entries)
                    for number, entries in reader.indexes.items()
                }
                yield reader
        except RecordingError:
            raise
        except _ROS1_ERRORS as error:
            raise RecordingError(
                f"{self._name} is damaged ({error}); 'rosbag reindex {self._name}' of ROS 1 may "
                "mend it"
            ) from error

    def _bound_chunks(self, reader: Reader) -> None:
        """Let chunks unpack to their stated size, within bounds."""
        budget = Budget(self._path, self._name)
        for place, chunk in reader.chunks.items():
            assert reader.bio is not None
            reader.bio.seek(place)
            size = Header.read(reader.bio, RecordType.CHUNK).get_uint32("size")
            budget.spend(size)
            packing = _PACKINGS[chunk.decompressor]
            unpacked = partial(unpack, self._name, packing, size=size)
            reader.chunks[place] = chunk._replace(decompressor=unpacked)


class _Stored(IndexData):
    """Where a message is; ``rosbags`` merges by time, this by the place in the file."""

    def __lt__(self, other: tuple[int, ...]) -> bool:
        return self[1:] < other[1:]
