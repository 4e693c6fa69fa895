"""Bags: how many combinations of MCAP's features are read rightly, what damage does, what it costs.

Contents: making the bags, reading them, counting.
"""

from __future__ import annotations

import logging
import random
import struct
import tempfile
from collections.abc import Iterator
from pathlib import Path
from time import process_time

import numpy as np
from mcap.reader import NonSeekingReader
from mcap.records import Message, Metadata
from mcap.writer import Writer
from rich.table import Table
from rosbags.typesys import Stores, get_typestore

from benchmarks.mcap_variants import Variant, variants, write
from benchmarks.memory import memory_to_read
from tissue_probe.recording.bags.mcap_bag import McapBag
from tissue_probe.recording.errors import RecordingError

CORRUPTIONS = 400
MESSAGES = 400_000
#: Of 10^7 messages: three columns of float64, three times [MB].
MEMORY = 720.0
PARAMETERS = {"driver": {"tip_mass": "0.04", "excitation": "sine"}}


def measure() -> dict[str, object]:
    """Read bags of each make; returns counts, and cost of a long one."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        return {
            "conformance": _conformance(folder),
            "corruption": _corruption(folder),
            "cost": _cost(folder / "long.mcap"),
        }


def tables(results: dict[str, object]) -> Iterator[Table]:
    """Yield what was measured as a table."""
    conformance, damage, cost = (results[key] for key in ("conformance", "corruption", "cost"))
    table = Table("bags", "measured", "to reach", title="Reading bags")
    table.add_row("MCAP's combinations read rightly", *(str(n) for n in conformance.values()))
    for name, count in damage.items():
        table.add_row(f"{CORRUPTIONS} corruptions: {name.replace('_', ' ')}", str(count), "")
    table.add_row(f"memory of {MESSAGES} messages [MB]", f"{cost['memory']:.0f}", "")
    table.add_row("of 10^7, by two lengths [MB]", f"{cost['of_ten_million']:.0f}", f"{MEMORY:.0f}")
    table.add_row("to open it [s]", f"{cost['open']:.1f}", "")
    table.add_row("to read one topic of two of it, bytes [s]", f"{cost['bytes']:.1f}", "")
    table.add_row("the same by mcap's NonSeekingReader [s]", f"{cost['mcap']:.1f}", "")
    yield table


def _conformance(folder: Path) -> dict[str, int]:
    path = folder / "variant.mcap"
    right = []
    for variant in variants():
        path.write_bytes(write(variant))
        right.append(_is_read_rightly(path, variant))
    return {"right": sum(right), "of": len(right)}


def _is_read_rightly(path: Path, variant: Variant) -> bool:
    bag = McapBag(path)
    read = [(m.log_time, m.publish_time, m.data) for m in bag.messages({"example"})]
    written = [
        (m.log_time, m.publish_time, m.data) for m in variant.records if isinstance(m, Message)
    ]
    noted = {m.name: m.metadata for m in variant.records if isinstance(m, Metadata)}
    return read == written and bag.metadata == noted and not bag.truncated


class _Warnings(logging.Handler):
    """Counts what is told."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0

    def emit(self, record: logging.LogRecord) -> None:
        self.count += 1


def _corruption(folder: Path) -> dict[str, int]:
    """Damage a bag in one to four bytes, many times; count what is read wrongly, or not told."""
    path = folder / "run.mcap"
    _write_long(path, 600, chunk=2000)
    whole = path.read_bytes()
    original = _content(path)
    assert original is not None
    counts = {
        "wrong_messages": 0, "silently_missing": 0, "metadata_silently_changed": 0, "refused": 0,
        "told": 0,
    }  # fmt: skip
    heard = _Warnings()
    logger = logging.getLogger("tissue_probe.recording")
    logger.addHandler(heard)
    logger.propagate = False
    generator = random.Random(0)
    for _ in range(CORRUPTIONS):
        damaged = bytearray(whole)
        for _ in range(generator.choice([1, 1, 1, 4])):
            damaged[generator.randrange(8, len(whole))] ^= generator.randrange(1, 256)
        path.write_bytes(damaged)
        heard.count = 0
        found = _content(path)
        if found is None:
            counts["refused"] += 1
            continue
        told = heard.count > 0
        counts["told"] += told
        counts["wrong_messages"] += bool(found[0] - original[0])
        counts["silently_missing"] += bool(original[0] - found[0]) and not told
        counts["metadata_silently_changed"] += found[1] != original[1] and not told
    logger.removeHandler(heard)
    logger.propagate = True
    return counts


def _content(path: Path) -> tuple[set, dict] | None:
    try:
        bag = McapBag(path)
        names = {topic.name for topic in bag.topics}
        return {(m.topic, m.log_time, m.data) for m in bag.messages(names)}, dict(bag.metadata)
    except RecordingError:
        return None


def _cost(path: Path) -> dict[str, float]:
    grown = []
    for count in (MESSAGES // 2, MESSAGES):
        _write_long(path, count)
        stated = {"position": "/pose", "force": "/ft", "force_polarity": "compression"}
        grown.append(memory_to_read(path, stated))
    begin = process_time()
    bag = McapBag(path)
    opened = process_time()
    ours = sum(1 for _ in bag.messages({"/ft"}))
    read = process_time()
    with path.open("rb") as file:
        theirs = NonSeekingReader(file).iter_messages(topics="/ft", log_time_order=False)
        assert ours == sum(1 for _ in theirs)
    return {
        "memory": grown[1],
        "of_ten_million": grown[1] + (grown[1] - grown[0]) * (10_000_000 / (MESSAGES / 2) - 2),
        "open": opened - begin,
        "bytes": read - opened,
        "mcap": process_time() - read,
    }


def _write_long(path: Path, count: int, chunk: int = 2**20) -> None:
    """Write a force and a position at 2 kHz each, so many messages in all."""
    store = get_typestore(Stores.LATEST)
    types = store.types
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](0, 0), "tool")
    zero = types["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
    turned = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 2.0)
    one = types["geometry_msgs/msg/Vector3"](0.0, 0.0, 1.0)
    place = types["geometry_msgs/msg/Pose"](types["geometry_msgs/msg/Point"](0.0, 0.0, 1.0), turned)
    made = {
        "/ft": types["geometry_msgs/msg/WrenchStamped"](
            header, types["geometry_msgs/msg/Wrench"](one, zero)
        ),
        "/pose": types["geometry_msgs/msg/PoseStamped"](header, place),
    }
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=chunk, enable_data_crcs=True)
        writer.start(profile="ros2")
        for name, values in PARAMETERS.items():
            writer.add_metadata(name, values)
        templates = {}
        for topic, message in made.items():
            kind = message.__msgtype__
            text = store.generate_msgdef(kind, ros_version=2)[0].encode()
            schema = writer.register_schema(kind, "ros2msg", text)
            data = bytearray(store.serialize_cdr(message, kind))
            at = bytes(data).index(struct.pack("<d", 1.0))
            templates[topic] = writer.register_channel(topic, "cdr", schema), data, at
        seconds = np.arange(count // 2) * 5e-4
        noise = 1e-6 * np.random.default_rng(0).normal(size=seconds.size)
        values = {
            "/ft": 0.3 * np.sin(20.0 * seconds + 0.02) + noise,
            "/pose": 1e-3 * np.sin(20.0 * seconds) + noise,
        }
        for number in range(count // 2):
            stamp = 1_700_000_000 * 10**9 + number * 500_000
            for topic, (channel, data, at) in templates.items():
                struct.pack_into("<iI", data, 4, *divmod(stamp, 10**9))
                struct.pack_into("<d", data, at, values[topic][number])
                writer.add_message(channel, stamp + 200_000, bytes(data), stamp)
        writer.finish()
