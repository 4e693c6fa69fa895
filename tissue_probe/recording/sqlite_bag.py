"""Reading the SQLite files of ROS 2 (``.db3``), through ``rosbags``.

What belongs here: messages as bytes out of such a file.
What does not: the messages' content (``decoding``).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import cast

from rosbags.interfaces import Connection, ConnectionExtRosbag2, MessageDefinitionFormat
from rosbags.rosbag2 import Reader, ReaderError

from tissue_probe.recording.bag import RawMessage, Topic
from tissue_probe.recording.errors import RecordingError

_ENCODINGS = {
    MessageDefinitionFormat.MSG: "ros2msg",
    MessageDefinitionFormat.IDL: "ros2idl",
    MessageDefinitionFormat.NONE: "",
}


class SqliteBag:
    """A ``.db3`` file (``bag.Bag``).

    Publish times are not kept by ``rosbags``: they are the log times.

    Raises
    ------
    RecordingError
        If ``rosbags`` cannot read it.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.profile = "ros2"
        self.metadata: dict[str, dict[str, str]] = {}
        self.truncated = False
        try:
            with Reader(path) as reader:
                self.topics = tuple(dict.fromkeys(_topic(entry) for entry in reader.connections))
        except ReaderError as error:
            raise RecordingError(
                f"{path} is damaged ({error}); sqlite3's .recover may save what is left"
            ) from error

    def messages(self, topics: Collection[str]) -> Iterator[RawMessage]:
        """Yield the messages of the topics so named, in the order of their log times."""
        with Reader(self._path) as reader:
            chosen = [entry for entry in reader.connections if entry.topic in topics]
            if not chosen:  # to rosbags, no choice means all
                return
            for connection, time, data in reader.messages(chosen):
                yield RawMessage(connection.topic, connection.msgtype, time, time, bytes(data))


def _topic(connection: Connection) -> Topic:
    return Topic(
        connection.topic,
        connection.msgtype,
        connection.msgdef.data,
        _ENCODINGS[connection.msgdef.format],
        cast(ConnectionExtRosbag2, connection.ext).serialization_format,
    )
