"""MCAP files with and without each feature that the format leaves to the writer.

Inputs and features, and which of them go together, are those of the MCAP project's conformance
suite (github.com/foxglove/mcap, tests/conformance): 416 combinations.
"""

import zlib
from itertools import compress, product
from typing import NamedTuple

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC

NEEDS = {  # by feature: of what kind a record must be in the data, and which other features
    "ch": ((Message, Channel, Schema), ()),
    "mx": ((Message, Channel, Schema), ("ch",)),
    "st": ((), ()),
    "rsh": ((Schema,), ()),
    "rch": ((Channel,), ()),
    "ax": ((Attachment,), ()),
    "mdx": ((Metadata,), ()),
    "chx": ((Message, Channel, Schema), ("ch",)),
    "sum": ((), ()),
    "pad": ((), ()),
}
SUMMARIZED = {"chx", "rsh", "rch", "mdx", "ax", "st"}
UNPADDED = (Opcode.FOOTER, Opcode.MESSAGE, Opcode.CHUNK, Opcode.DATA_END)

SCHEMA = Schema(id=1, name="Example", encoding="c", data=b"\4\5\6")
CHANNEL = Channel(id=1, topic="example", message_encoding="a", metadata={"foo": "bar"}, schema_id=1)
BARE = Channel(id=1, topic="example", message_encoding="text", metadata={}, schema_id=0)
ONE = Message(channel_id=1, log_time=2, publish_time=1, sequence=10, data=b"\1\2\3")
TEN = [
    Message(channel_id=1, log_time=time, publish_time=time, sequence=number, data=b"\1\2\3")
    for number, time in enumerate([0, 2, 1, 3, 3, 5, 4, 7, 8, 9])
]
FILE = Attachment(
    name="myFile", media_type="application/octet-stream", log_time=2, create_time=1, data=b"\1\2\3"
)
INPUTS = {
    "NoData": [],
    "OneSchemalessMessage": [BARE, ONE],
    "OneMessage": [SCHEMA, CHANNEL, ONE],
    "OneAttachment": [FILE],
    "OneMetadata": [Metadata(name="myMetadata", metadata={"foo": "bar"})],
    "TenMessages": [SCHEMA, CHANNEL, *TEN],
}


class Variant(NamedTuple):
    """Records of one input, and how they are written."""

    name: str
    records: list
    features: frozenset


def variants():
    """Yield each combination that makes sense."""
    for name, records in INPUTS.items():
        for chosen in product((False, True), repeat=len(NEEDS)):
            features = frozenset(compress(NEEDS, chosen))
            if all(_possible(feature, features, records) for feature in features):
                yield Variant("-".join([name, *sorted(features)]), records, features)


def _possible(feature, features, records):
    kinds, others = NEEDS[feature]
    return (
        (not kinds or any(isinstance(record, kinds) for record in records))
        and features.issuperset(others)
        and (feature != "sum" or not SUMMARIZED.isdisjoint(features))
    )


class _File:
    def __init__(self, padded):
        self.bytes = MCAP0_MAGIC
        self._padded = padded

    def add(self, record):
        """Append a record; return where it begins and how long it is."""
        data = encoded(record)
        if self._padded and data[0] not in UNPADDED:
            content = data[9:] + b"\x01\xff\xff"
            data = data[:1] + len(content).to_bytes(8, "little") + content
        self.bytes += data
        return len(self.bytes) - len(data), len(data)


def encoded(record):
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()


def write(variant):
    """Return the file's bytes."""
    _, records, features = variant
    file = _File("pad" in features)
    file.add(Header("", ""))
    in_chunk = [r for r in records if "ch" in features and not isinstance(r, Attachment | Metadata)]
    attached, noted, chunked = [], [], []
    for record in records:
        if record in in_chunk:
            continue
        begin, length = file.add(record)
        if isinstance(record, Attachment):
            data, kind = len(record.data), record.media_type
            attached.append(
                AttachmentIndex(
                    begin, length, record.log_time, record.create_time, data, record.name, kind
                )
            )
        elif isinstance(record, Metadata):
            noted.append(MetadataIndex(begin, length, record.name))
    if in_chunk:
        chunked.append(_add_chunk(file, in_chunk, "mx" in features))
    file.add(DataEnd(zlib.crc32(file.bytes)))
    return _ended(file, variant, attached, noted, chunked)


def _add_chunk(file, records, indexed):
    data, index, times = b"", [], [r.log_time for r in records if isinstance(r, Message)]
    for record in records:
        if isinstance(record, Message):
            index.append((record.log_time, len(data)))
        data += encoded(record)
    first, last = min(times), max(times)
    begin, length = file.add(Chunk("", data, last, first, zlib.crc32(data), len(data)))
    at, indexes_length = file.add(MessageIndex(1, index)) if indexed else (0, 0)
    offsets = {1: at} if indexed else {}
    return ChunkIndex(length, begin, "", len(data), last, indexes_length, offsets, first, len(data))


def _ended(file, variant, attached, noted, chunked):
    """Add summary, footer and magic."""
    _, records, features = variant
    messages = [r for r in records if isinstance(r, Message)]
    counts = {kind: sum(isinstance(r, kind) for r in records) for kind in map(type, records)}
    times = [message.log_time for message in messages] or [0]
    statistics = Statistics(
        counts.get(Attachment, 0), counts.get(Channel, 0), {1: len(messages)} if messages else {},
        len(chunked), len(messages), max(times), min(times), counts.get(Metadata, 0),
        counts.get(Schema, 0),
    )  # fmt: skip
    groups = {
        "rsh": [r for r in records if isinstance(r, Schema)],
        "rch": [r for r in records if isinstance(r, Channel)],
        "st": [statistics],
        "mdx": noted,
        "ax": attached,
        "chx": chunked,
    }
    begin, offsets = len(file.bytes), []
    for feature, group in groups.items():
        if feature in features and group:
            first = len(file.bytes)
            for record in group:
                file.add(record)
            opcode = file.bytes[first]
            offsets.append(SummaryOffset(opcode, first, len(file.bytes) - first))
    summary_begin = begin if len(file.bytes) > begin else 0
    offsets_begin = len(file.bytes) if "sum" in features else 0
    for offset in offsets if offsets_begin else []:
        file.add(offset)
    footer = encoded(Footer(summary_begin, offsets_begin, 0))
    checksum = zlib.crc32(file.bytes[begin:] + footer[:-4])
    file.add(Footer(summary_begin, offsets_begin, checksum))
    return file.bytes + MCAP0_MAGIC
