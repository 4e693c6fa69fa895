"""Reading the SQLite files of ROS 2 (``.db3``).

Contents: messages as bytes out of such a file.

``rosbags`` reads them too, but as if nothing lay beside: messages that a killed recorder left in
its write-ahead log are missing then, silently.
"""

from __future__ import annotations

import logging
import shutil
import sqlite3
from collections.abc import Collection, Iterator
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory

from tissue_probe.recording.bags.bag import RawMessage, Topic
from tissue_probe.recording.bags.unpacking import Budget, unpack_message
from tissue_probe.recording.errors import RecordingError

_log = logging.getLogger(__name__)

_LOGS = ("-wal", "-journal")
"""Files that a killed recorder leaves beside its own; SQLite puts the two together."""


class SqliteBag:
    """A ``.db3`` file (``bag.Bag``), with the write-ahead log that lies beside it.

    Publish times are not in it: they are the log times. SQLite keeps no checksums.

    Parameters
    ----------
    path : path
        The file.
    name : path, optional
        Its name in messages, if otherwise.

    Raises
    ------
    RecordingError
        If it is damaged, or no bag.
    """

    def __init__(self, path: Path, name: object = None) -> None:
        self._path = path
        self._name = name or path
        self.profile = "ros2"
        self.metadata: dict[str, dict[str, str]] = {}
        self._merged: TemporaryDirectory[str] | None = None
        logs = [log for suffix in _LOGS if (log := Path(f"{path}{suffix}")).is_file()]
        self.truncated = any(log.stat().st_size for log in logs)
        if self.truncated:
            self._merge(logs)
        try:
            with closing(self._connection()) as connection:
                self._check(connection)
                self._topics = _topics(connection)
        except (sqlite3.Error, UnicodeDecodeError, OverflowError) as error:
            raise self._report_damage(error) from error
        self.topics = tuple(dict.fromkeys(self._topics.values()))

    def messages(self, topics: Collection[str]) -> Iterator[RawMessage]:
        """Yield the messages of the topics so named, in the order in which they were stored."""
        wanted = self._find_wanted(topics)
        query = f"SELECT topic_id, timestamp, data FROM messages {_of(wanted)} ORDER BY id"
        budget = Budget(self._path, self._name)
        try:
            with closing(self._connection()) as connection:
                for number, time, data in connection.execute(query, tuple(wanted)):
                    if not isinstance(time, int) or not isinstance(data, bytes):
                        raise sqlite3.DatabaseError("a message without time or content")
                    content = unpack_message(self._name, data, budget)
                    yield RawMessage(wanted[number], time, time, content)
        except sqlite3.Error as error:
            raise self._report_damage(error) from error

    def count(self, topics: Collection[str]) -> int:
        """Return how many messages of the topics so named there are."""
        wanted = self._find_wanted(topics)
        query = f"SELECT COUNT(*) FROM messages {_of(wanted)}"
        try:
            with closing(self._connection()) as connection:
                count: int = connection.execute(query, tuple(wanted)).fetchone()[0]
                return count
        except sqlite3.Error as error:
            raise self._report_damage(error) from error

    def _find_wanted(self, topics: Collection[str]) -> dict[int, Topic]:
        return {number: topic for number, topic in self._topics.items() if topic.name in topics}

    def _connection(self) -> sqlite3.Connection:
        # Immutable: the recording is not touched, whichever files lie beside it.
        uri = f"{self._path.absolute().as_uri()}?immutable=1"
        return sqlite3.connect(uri, uri=True)

    def _merge(self, logs: list[Path]) -> None:
        """Let SQLite put file and log together in a copy: it writes while it does."""
        self._merged = TemporaryDirectory(prefix="tissue_probe")
        copies = [Path(self._merged.name, file.name) for file in (self._path, *logs)]
        for file, copy in zip((self._path, *logs), copies, strict=True):
            shutil.copyfile(file, copy)
        self._path = copies[0]
        try:
            with closing(sqlite3.connect(self._path)) as connection:
                connection.execute("PRAGMA journal_mode=DELETE")
        except sqlite3.Error as error:
            raise self._report_damage(error) from error
        _log.warning(
            "%s was not closed by its recorder; read with %s beside it",
            self._name,
            " and ".join(log.name for log in logs),
        )

    def _check(self, connection: sqlite3.Connection) -> None:
        """Warn of inconsistent pages: lost pages are lost silently."""
        (said,) = connection.execute("PRAGMA quick_check(1)").fetchone()
        if said != "ok":
            _log.warning(
                "%s is damaged, messages may be missing (%s)", self._name, " ".join(said.split())
            )

    def _report_damage(self, error: Exception) -> RecordingError:
        said = " ".join(str(error).split())  # it may quote a definition, of many lines
        return RecordingError(
            f"{self._name} is damaged ({said}); sqlite3's .recover may save the remaining messages"
        )


def _of(topics: Collection[int]) -> str:
    return f"WHERE topic_id IN ({','.join('?' * len(topics))})"


def _topics(connection: sqlite3.Connection) -> dict[int, Topic]:
    """Return topics by their numbers; definitions are there since ROS 2 Iron."""
    tables = {
        name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type='table'")
    }
    if not {"topics", "messages"} <= tables:
        raise sqlite3.DatabaseError("no bag: its tables are missing")
    definitions = {}
    if "message_definitions" in tables:
        rows = connection.execute(
            "SELECT topic_type, encoded_message_definition, encoding FROM message_definitions"
        )
        definitions = {name: (str(text), str(encoding)) for name, text, encoding in rows}
    rows = connection.execute("SELECT id, name, type, serialization_format FROM topics ORDER BY id")
    return {
        number: Topic(str(name), str(kind), *definitions.get(kind, ("", "")), str(encoding))
        for number, name, kind, encoding in rows
    }
