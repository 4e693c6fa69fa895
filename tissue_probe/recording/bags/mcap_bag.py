"""Reading MCAP files, complete, cut off or damaged.

Contents: the file's records, down to messages as bytes, and its checksums.

Records are parsed by ``mcap``. Its readers are not used: they end in an error where the file was
cut off or is damaged, and messages behind are lost. No index is used either: the data count, and an
index that says otherwise cannot mislead.
"""

from __future__ import annotations

import logging
import struct
import zlib
from collections import Counter
from collections.abc import Callable, Collection, Iterator
from io import SEEK_END, BytesIO
from pathlib import Path
from struct import Struct
from typing import BinaryIO, NamedTuple, TypeVar

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    Schema,
    Statistics,
)
from mcap.writer import MCAP0_MAGIC

from tissue_probe.recording.bags.bag import RawMessage, Topic
from tissue_probe.recording.bags.unpacking import (
    LARGEST_UNPACKED,
    UNPACKING_ERRORS,
    Budget,
    unpack,
    unpack_beginning,
    unpack_message,
)
from tissue_probe.recording.errors import RecordingError

#: A record of one of MCAP's kinds.
_Record = TypeVar("_Record", bound=McapRecord)

_log = logging.getLogger(__name__)

_PREFIX = Struct("<BQ")  # opcode, length
_MESSAGE = Struct("<HIQQ")  # channel, sequence, log time, publish time
_CHANNEL = Struct("<H")  # of a message
_CHUNK = Struct("<QQQII")  # its times, size and checksum unpacked, length of its packing's name
_LENGTH = Struct("<Q")  # of the packed bytes
_UP_TO_CRC = 16  # bytes of a footer before the summary's checksum, which counts them too
_BLOCK = 2**20
_NO_SCHEMA = Schema(id=0, data=b"", encoding="", name="")
_MCAP_ERRORS = (McapError, struct.error, ValueError, OverflowError)  # errors of parsing damage
_MAY_STAND_ALONE = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)  # or in a chunk


class _Part(NamedTuple):
    """Messages that lie together in the file: a chunk, or records outside of any."""

    begin: int
    end: int
    chunk: bool
    channels: frozenset[int] = frozenset()
    cut: bool = False


class _Summary(NamedTuple):
    """A closed file's summary: where it repeats definitions, and its counts."""

    definitions: tuple[tuple[int, int, int], ...] = ()
    statistics: Statistics | None = None


class McapBag:
    """An MCAP file (``bag.Bag``); of one that was cut off, everything before the cut.

    Of a packed chunk that the cut goes through, the blocks of the packing that are complete.

    It is read through once when it is opened. Records that its checksums contradict are told by a
    warning, and left out where it can be told which records are meant. The caller has checked that
    the file begins as an MCAP file does.

    Parameters
    ----------
    path : path
        The file.
    name : path, optional
        Its name in messages, if otherwise.

    Raises
    ------
    RecordingError
        If more would be unpacked than a measurement holds, or no record can be read.
    """

    def __init__(self, path: Path, name: object = None) -> None:
        self._path = path
        self._name = name or path
        self.profile = ""
        self.metadata: dict[str, dict[str, str]] = {}
        self.truncated = True
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Topic] = {}
        self._counts: Counter[int] = Counter()
        self._parts: list[_Part] = []
        with path.open("rb") as file:
            summary = self._scan(file)
            self._examine_parts(file)
            for opcode, begin, end in summary.definitions:  # topics without a message are here only
                self._learn(opcode, _content(file, begin, end))
        self._compare(summary.statistics)
        self.topics = tuple(dict.fromkeys(self._channels.values()))

    def messages(self, topics: Collection[str]) -> Iterator[RawMessage]:
        """Yield the messages of the topics so named, in the order in which they were stored."""
        wanted = {number: topic for number, topic in self._channels.items() if topic.name in topics}
        budget = Budget(self._path, self._name)
        with self._path.open("rb") as file:
            for part in self._parts:
                if part.channels.isdisjoint(wanted):
                    continue
                data = self._unpack_part(file, part)
                for begin, end in _messages(data):
                    channel, _, log_time, publish_time = _MESSAGE.unpack_from(data, begin)
                    if topic := wanted.get(channel):
                        content = data[begin + _MESSAGE.size : end]
                        if topic.message_encoding == "cdr":
                            content = unpack_message(self._name, content, budget)
                        yield RawMessage(topic, log_time, publish_time, content)

    def count(self, topics: Collection[str]) -> int:
        """Return how many messages of the topics so named there are."""
        return sum(self._counts[n] for n, topic in self._channels.items() if topic.name in topics)

    def _scan(self, file: BinaryIO) -> _Summary:
        """Note the place of each part in the data, and return the summary, if it holds."""
        complete = len(MCAP0_MAGIC)
        for opcode, begin, end in _records_in_file(file, complete):
            if opcode == Opcode.DATA_END:
                self._check_data(file, begin, end)
                return self._read_summary(file, end)
            if opcode == Opcode.FOOTER:
                self.truncated = False
                _log.warning(
                    "%s is damaged: the record that ends its data is missing, and with it their "
                    "checksum",
                    self._name,
                )
                return _Summary()
            self._take(opcode, file, begin, end)
            complete = end
        if complete == len(MCAP0_MAGIC):
            raise RecordingError(
                f"{self._name} begins as an MCAP file does, and nothing that follows can be read: "
                "it was cut off at once, or is damaged; give another recording"
            )
        self._take_beginning(file, complete)
        self._warn_of_end(file, complete)
        return _Summary()

    def _read_summary(self, file: BinaryIO, summary_begin: int) -> _Summary:
        definitions: list[tuple[int, int, int]] = []
        statistics, complete = None, summary_begin
        for opcode, begin, end in _records_in_file(file, summary_begin):
            if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                definitions.append((opcode, begin, end))
            elif opcode == Opcode.STATISTICS:
                statistics = self._parse_record(Statistics, file, begin, end)
            elif opcode == Opcode.FOOTER:
                self.truncated = False
                if self._summary_holds(file, summary_begin, begin, end):
                    return _Summary(tuple(definitions), statistics)
                return _Summary()
            complete = end
        self._warn_of_end(file, complete)
        return _Summary()

    def _take(self, opcode: int, file: BinaryIO, begin: int, end: int) -> None:
        if opcode == Opcode.HEADER:
            if header := self._parse_record(Header, file, begin, end):
                self.profile = header.profile
        elif opcode == Opcode.METADATA:
            if record := self._parse_record(Metadata, file, begin, end):
                self.metadata[record.name] = record.metadata
        elif opcode == Opcode.CHUNK:
            self._parts.append(_Part(begin, end, chunk=True))
        elif opcode in _MAY_STAND_ALONE:
            begin -= _PREFIX.size
            last = self._parts[-1] if self._parts else None
            if last and not last.chunk and last.end == begin and end - last.begin < _BLOCK:
                self._parts[-1] = last._replace(end=end)
            else:
                self._parts.append(_Part(begin, end, chunk=False))

    def _take_beginning(self, file: BinaryIO, begin: int) -> None:
        """Note the chunk that a cut goes through: its complete messages are read, too."""
        prefix = _content(file, begin, begin + _PREFIX.size)
        if len(prefix) < _PREFIX.size or _is_closed(file):
            return
        if _PREFIX.unpack(prefix)[0] == Opcode.CHUNK:
            self._parts.append(_Part(begin + _PREFIX.size, _size(file), chunk=True, cut=True))

    def _examine_parts(self, file: BinaryIO) -> None:
        """Learn from each part which topics there are, and which are in it."""
        budget = Budget(self._path, self._name)
        for number, part in enumerate(self._parts):
            data = self._unpack_part(file, part)
            budget.spend(len(data) if part.chunk else 0)
            counts: Counter[int] = Counter()
            complete = 0
            for opcode, begin, end in _records(data):
                if opcode == Opcode.MESSAGE and end - begin >= _MESSAGE.size:
                    counts[_CHANNEL.unpack_from(data, begin)[0]] += 1
                elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                    self._learn(opcode, data[begin:end])
                complete = end
            if complete != len(data) and not part.cut:
                self._warn_of_damage(part, f"its records end at byte {complete} of {len(data)}")
            self._counts.update(counts)
            self._parts[number] = part._replace(channels=frozenset(counts))

    def _learn(self, opcode: int, data: bytes) -> None:
        """Take in a schema or a channel; leave out, with a warning, one that is damaged."""
        try:
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(_stream(data))
                self._schemas[schema.id] = schema
            else:
                channel = Channel.read(_stream(data))
                topic = self._topic(channel)
                if self._channels.setdefault(channel.id, topic) != topic:
                    _log.warning(
                        "%s describes channel %d twice and differently; the first holds: %s",
                        self._name, channel.id, self._channels[channel.id].name,
                    )  # fmt: skip
        except _MCAP_ERRORS as error:
            _log.warning("%s: skipping a damaged definition (%s)", self._name, error)

    def _topic(self, channel: Channel) -> Topic:
        schema = self._schemas.get(channel.schema_id, _NO_SCHEMA)
        return Topic(
            channel.topic,
            schema.name,
            schema.data.decode(errors="replace"),
            schema.encoding,
            channel.message_encoding,
        )

    def _unpack_part(self, file: BinaryIO, part: _Part) -> bytes:
        """Return a part's records; none, with a warning, of a chunk that is damaged."""
        if not part.chunk:
            return _content(file, part.begin, part.end)
        try:
            if part.end - part.begin > LARGEST_UNPACKED:
                raise ValueError(f"it is longer than {LARGEST_UNPACKED >> 20} MiB")
            content = _content(file, part.begin, part.end)
            if part.cut:
                return _read_beginning(self._name, content)
            chunk = Chunk.read(_stream(content))
            data = unpack(self._name, chunk.compression, chunk.data, chunk.uncompressed_size)
            if chunk.uncompressed_crc and chunk.uncompressed_crc != zlib.crc32(data):
                raise ValueError("it does not have the checksum that it carries")
            return data
        except RecordingError:
            raise
        except (*UNPACKING_ERRORS, *_MCAP_ERRORS) as error:
            self._warn_of_damage(part, str(error))
            return b""

    def _parse_record(
        self, kind: type[_Record], file: BinaryIO, begin: int, end: int
    ) -> _Record | None:
        """Return a record; None, with a warning, of one that is damaged."""
        try:
            if end - begin > LARGEST_UNPACKED:
                raise ValueError(f"it is longer than {LARGEST_UNPACKED >> 20} MiB")
            # The base class does not say that each of them reads a record of its own kind.
            read: Callable[[ReadDataStream], _Record] = kind.read  # type: ignore[attr-defined]
            return read(_stream(_content(file, begin, end)))
        except _MCAP_ERRORS as error:
            _log.warning(
                "%s: skipping the damaged %s at byte %d (%s)",
                self._name, kind.__name__.lower(), begin, error,
            )  # fmt: skip
            return None

    def _check_data(self, file: BinaryIO, begin: int, end: int) -> None:
        record = self._parse_record(DataEnd, file, begin, end)
        expected = record.data_section_crc if record else 0
        if expected and expected != _checksum(file, 0, begin - _PREFIX.size):
            _log.warning(
                "%s is damaged: its data do not have the checksum that they carry; data without "
                "a checksum (the run's parameters, messages outside of chunks) may be wrong",
                self._name,
            )

    def _summary_holds(self, file: BinaryIO, summary_begin: int, begin: int, end: int) -> bool:
        footer = self._parse_record(Footer, file, begin, end)
        if footer is None:
            return False
        if not footer.summary_crc:
            return True
        holds = footer.summary_crc == _checksum(file, summary_begin, begin + _UP_TO_CRC)
        if not holds:
            _log.warning(
                "%s: its summary does not have the checksum that it carries, and is not used; the "
                "messages are read without it",
                self._name,
            )
        return bool(holds)

    def _compare(self, said: Statistics | None) -> None:
        """Warn if messages are missing, or of unknown kind."""
        found = sum(self._counts.values())
        if said and said.message_count != found:
            _log.warning(
                "%s has %d messages, but its summary says %d", self._name, found, said.message_count
            )
        unknown = sum(n for number, n in self._counts.items() if number not in self._channels)
        if unknown:
            _log.warning(
                "%s: leaving out %d messages of topics that it does not describe",
                self._name, unknown,
            )  # fmt: skip

    def _warn_of_damage(self, part: _Part, said: str) -> None:
        what = "the damaged chunk" if part.chunk else "damaged records"
        _log.warning("%s: skipping %s at byte %d (%s)", self._name, what, part.begin, said)

    def _warn_of_end(self, file: BinaryIO, complete: int) -> None:
        whole = sum(part.chunk and not part.cut for part in self._parts)
        if any(part.cut for part in self._parts):
            _log.warning(
                "%s was not closed by its recorder; reading its %d complete chunks and the part "
                "of the next that there is",
                self._name, whole,
            )  # fmt: skip
            return
        size = _size(file)
        closed = _is_closed(file) and complete < size
        _log.warning(
            "%s %s; reading its %d complete chunks, leaving out the last %d bytes",
            self._name,
            f"is damaged at byte {complete}" if closed else "was not closed by its recorder",
            whole,
            size - complete,
        )


def _stream(data: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(data))


def _size(file: BinaryIO) -> int:
    return file.seek(0, SEEK_END)


def _is_closed(file: BinaryIO) -> bool:
    """Whether a file ends as a closed one does."""
    file.seek(max(_size(file) - len(MCAP0_MAGIC), 0))
    return file.read() == MCAP0_MAGIC


def _read_beginning(name: object, data: bytes) -> bytes:
    """Return the records of a chunk that was cut off, as far as they go.

    Raises
    ------
    ValueError
        If the chunk is not cut off by its own length: then it is damaged.
    """
    data = data.rstrip(b"\0")  # a crashed file system leaves zeros
    if len(data) < _CHUNK.size:
        return b""
    begin = _CHUNK.size + _CHUNK.unpack_from(data)[-1] + _LENGTH.size
    if len(data) < begin:
        return b""
    packing = data[_CHUNK.size : begin - _LENGTH.size].decode()
    (length,) = _LENGTH.unpack_from(data, begin - _LENGTH.size)
    if length <= len(data) - begin:
        raise ValueError("its lengths contradict one another")
    return unpack_beginning(name, packing, data[begin:])


def _content(file: BinaryIO, begin: int, end: int) -> bytes:
    file.seek(begin)
    return file.read(end - begin)


def _checksum(file: BinaryIO, begin: int, end: int) -> int:
    file.seek(begin)
    checksum = 0
    for place in range(begin, end, _BLOCK):
        checksum = zlib.crc32(file.read(min(_BLOCK, end - place)), checksum)
    return checksum


def _records_in_file(file: BinaryIO, offset: int) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, begin and end of each complete record's content."""
    size = _size(file)
    while offset + _PREFIX.size <= size:
        opcode, length = _PREFIX.unpack(_content(file, offset, offset + _PREFIX.size))
        begin = offset + _PREFIX.size
        offset = begin + length
        if opcode == 0 or offset > size:  # a crashed file system leaves zeros
            return
        yield opcode, begin, offset


def _records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, begin and end of each complete record's content."""
    offset, size = 0, len(data)
    while offset + _PREFIX.size <= size:
        opcode, length = _PREFIX.unpack_from(data, offset)
        begin = offset + _PREFIX.size
        offset = begin + length
        if opcode == 0 or offset > size:
            return
        yield opcode, begin, offset


def _messages(data: bytes) -> Iterator[tuple[int, int]]:
    """Yield begin and end of each message's content."""
    for opcode, begin, end in _records(data):
        if opcode == Opcode.MESSAGE and end - begin >= _MESSAGE.size:
            yield begin, end
