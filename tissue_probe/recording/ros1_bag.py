"""Reading the bags of ROS 1 (``.bag``), through ``rosbags``.

What belongs here: messages as bytes out of such a file.
What does not: the messages' content (``decoding``).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from rosbags.rosbag1 import Reader, ReaderError

from tissue_probe.recording.bag import RawMessage, Topic
from tissue_probe.recording.errors import RecordingError


class Ros1Bag:
    """A ``.bag`` file (``bag.Bag``).

    Publish times are not kept in it: they are the log times.

    Raises
    ------
    RecordingError
        If ``rosbags`` cannot read it.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.profile = "ros1"
        self.metadata: dict[str, dict[str, str]] = {}
        self.truncated = False
        try:
            with Reader(path) as reader:
                self.topics = tuple(
                    dict.fromkeys(
                        Topic(entry.topic, entry.msgtype, entry.msgdef.data, "ros1msg", "ros1")
                        for entry in reader.connections
                    )
                )
        except ReaderError as error:
            raise RecordingError(
                f"{path} is damaged ({error}); 'rosbag reindex {path}' of ROS 1 may mend it"
            ) from error

    def messages(self, topics: Collection[str]) -> Iterator[RawMessage]:
        """Yield the messages of the topics so named, in the order of their log times."""
        with Reader(self._path) as reader:
            chosen = [entry for entry in reader.connections if entry.topic in topics]
            if not chosen:  # to rosbags, no choice means all
                return
            for connection, time, data in reader.messages(chosen):
                yield RawMessage(connection.topic, connection.msgtype, time, time, bytes(data))
