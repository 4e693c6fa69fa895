"""Writing a recording: MCAP with the profile ``ros2``, safe against the writer's sudden death.

Contents: how messages reach the disk.

No ``rosbag2`` metadata record is written: ``ros2 bag`` takes topics, types, counts and times from
the summary, and without that record reads QoS policies by name, as in its newest format.
"""

from __future__ import annotations

import errno
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event, Lock, Thread
from types import TracebackType
from typing import BinaryIO

from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

FLUSH_PERIOD = 0.5
"""Longest time that a message waits in memory [s]: a killed recorder loses so much."""


class McapWriter:
    """Write CDR messages to a new MCAP file.

    Every ``FLUSH_PERIOD`` a thread closes the current chunk and hands it to the operating
    system, however few messages there are: that survives a SIGKILL. The first failure to store
    (a full disk) is raised once, by whichever method is called next, and closes the file; messages
    flushed before stay readable. All methods may be called from any thread.

    Parameters
    ----------
    path : path
        The file to create.
    metadata : mapping
        The run's parameters, excitation, ...: text by key, by name. Each name becomes one
        metadata record at the head of the file, so it is there even if the run dies.

    Raises
    ------
    FileExistsError
        If the file exists: a recording is never overwritten.
    OSError
        If the file cannot be created or its head not be stored.
    """

    def __init__(self, path: str | Path, metadata: Mapping[str, Mapping[str, str]]) -> None:
        self._path = Path(path)
        self._stream = _create(self._path)
        self._writer = Writer(self._stream, compression=CompressionType.ZSTD, enable_data_crcs=True)
        self._schemas: dict[tuple[str, str], int] = {}
        self._lock = Lock()
        self._failure: OSError | None = None
        with self._guard_storing():
            self._write_head(metadata)
        self._closing = Event()
        self._flusher = Thread(target=self._flush_regularly, name="mcap flush", daemon=True)
        self._flusher.start()

    def add_topic(self, topic: str, typename: str, definition: str, qos_yaml: str) -> int:
        """Announce a topic and return the channel to write its messages to.

        Parameters
        ----------
        topic : str
            Full name, such as ``/probe/samples``.
        typename : str
            Such as ``tissue_probe_msgs/msg/ProbeSamples``.
        definition : str
            The type's full definition (``message_definition``).
        qos_yaml : str
            The publishers' QoS as ``ros2 bag`` writes it: a YAML list with, for each, history,
            depth, reliability, durability, deadline, lifespan, liveliness,
            liveliness_lease_duration, avoid_ros_namespace_conventions; policies by name
            (``reliable``). Empty where it is not known.

        Raises
        ------
        ValueError
            If the writer is closed.
        OSError
            If storing failed before.
        """
        metadata = {
            "offered_qos_profiles": qos_yaml,
            "topic_type_hash": _type_hash(typename, definition),
        }
        with self._guard_storing():
            schema = self._schema(typename, definition)
            return self._writer.register_channel(topic, "cdr", schema, metadata)

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Store a metadata record; a reader takes the last of those of one name.

        Parameters
        ----------
        name : str
            Such as a node's full name.
        values : mapping
            Text by key.

        Raises
        ------
        ValueError
            If the writer is closed.
        OSError
            If it, or something earlier, could not be stored.
        """
        with self._guard_storing():
            self._writer.add_metadata(name, dict(values))

    def write(self, channel: int, log_time: int, publish_time: int, data: bytes) -> None:
        """Store one message.

        Parameters
        ----------
        channel : int
            The number that ``add_topic`` returned.
        log_time, publish_time : int
            When it was received and published [ns since the epoch].
        data : bytes
            The message as CDR, with its four bytes of encapsulation.

        Raises
        ------
        ValueError
            If the writer is closed.
        OSError
            If it, or an earlier message, could not be stored.
        """
        with self._guard_storing():
            self._writer.add_message(channel, log_time, data, publish_time)

    def flush(self) -> None:
        """Hand everything written so far to the operating system (raises like ``write``)."""
        with self._guard_storing():
            self._writer.flush()

    def close(self) -> None:
        """Write the summary and close the file; once closed, do nothing.

        Raises
        ------
        OSError
            If the rest could not be stored, or an earlier failure was not yet told.
        """
        self._closing.set()
        self._flusher.join()
        with self._lock:
            self._tell_failure()
            if not self._stream.closed:
                with self._stopping_on_failure():
                    self._writer.finish()
                    self._stream.close()

    def __enter__(self) -> McapWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def _write_head(self, metadata: Mapping[str, Mapping[str, str]]) -> None:
        self._writer.start(profile="ros2")
        for name, values in metadata.items():
            self._writer.add_metadata(name, dict(values))
        self._writer.flush()

    def _schema(self, typename: str, definition: str) -> int:
        key = typename, definition
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(
                typename, "ros2msg", definition.encode()
            )
        return self._schemas[key]

    def _flush_regularly(self) -> None:
        while not self._closing.wait(FLUSH_PERIOD):
            with self._lock:
                if self._stream.closed:
                    return
                try:
                    with self._stopping_on_failure():
                        self._writer.flush()
                except OSError as error:
                    self._failure = error  # raised at the next call
                    return

    @contextmanager
    def _guard_storing(self) -> Iterator[None]:
        with self._lock:
            self._tell_failure()
            if self._stream.closed:
                raise ValueError(f"{self._path} is closed")
            with self._stopping_on_failure():
                yield

    def _tell_failure(self) -> None:
        if self._failure:
            failure, self._failure = self._failure, None
            raise failure

    @contextmanager
    def _stopping_on_failure(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            with suppress(OSError):  # tries once more to store the rest, and fails once more
                self._stream.close()
            raise OSError(
                error.errno,
                f"{error.strerror}; the recording ends here, messages stored before stay readable",
                str(self._path),
            ) from error


def _create(path: Path) -> BinaryIO:
    try:
        return path.open("xb")
    except FileExistsError:
        raise FileExistsError(
            errno.EEXIST, "a recording is never overwritten, choose another name", str(path)
        ) from None


def _type_hash(typename: str, definition: str) -> str:
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(definition, typename))
    return store.hash_rihs01(typename)
