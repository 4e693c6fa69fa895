"""Samples, and the sites of a scan, as a recording of the suite, written without ROS.

Contents: MCAP from samples that no node published.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tissue_probe.recording.bags.decoding import SAMPLES, SITE
from tissue_probe.recording.bags.definitions import message_definition, share_folders
from tissue_probe.recording.writing.writer import McapWriter
from tissue_probe.signals import NANOSECONDS, PalpationSite, SampleBlock

SAMPLES_TOPIC, SITES_TOPIC = "/probe/samples", "/probe/palpation_site"
SAMPLES_IN_MESSAGE = 100
"""Samples in one message."""


def write_samples_bag(
    path: str | Path,
    blocks: SampleBlock | Sequence[SampleBlock],
    sites: Sequence[PalpationSite] = (),
) -> None:
    """Write samples to a new MCAP file, as ``ProbeSamples`` on ``/probe/samples``.

    Parameters
    ----------
    path : path
        The file to create.
    blocks : SampleBlock or sequence of SampleBlock
        The samples, in the order of their stamps.
    sites : sequence of PalpationSite
        Announcements of a scan's sites, on ``/probe/palpation_site``.

    Raises
    ------
    FileExistsError
        If the file exists: a recording is never overwritten.
    FileNotFoundError
        If the suite's messages are not installed.
    OSError
        If the file cannot be written.
    """
    store = get_typestore(Stores.EMPTY)
    definitions = {name: message_definition(name, share_folders()) for name in (SAMPLES, SITE)}
    for name, definition in definitions.items():
        store.register(get_types_from_msg(definition, name))
    blocks = [blocks] if isinstance(blocks, SampleBlock) else blocks
    entries = [(SAMPLES_TOPIC, SAMPLES, *each) for each in _samples(store.types, blocks)]
    entries += [(SITES_TOPIC, SITE, site.stamp, _site(store.types, site)) for site in sites]
    with McapWriter(path, {}) as writer:
        topics = {topic: name for topic, name, *_ in entries}
        channels = {
            topic: writer.add_topic(topic, name, definitions[name], "")
            for topic, name in topics.items()
        }
        for topic, name, stamp, message in sorted(entries, key=lambda entry: entry[2]):
            data = bytes(store.serialize_cdr(message, name))
            writer.write(channels[topic], stamp, stamp, data)


def _samples(types: Any, blocks: Sequence[SampleBlock]) -> Iterator[tuple[int, Any]]:
    for block in blocks:
        for first in range(0, len(block), SAMPLES_IN_MESSAGE):
            part = block[first : first + SAMPLES_IN_MESSAGE]
            message = types[SAMPLES](
                _header(types, part.stamp, "probe"),
                part.sequence,
                part.sample_period,
                part.position,
                part.force,
                part.command,
            )
            yield part.stamp, message


def _site(types: Any, site: PalpationSite) -> Any:
    point = types["geometry_msgs/msg/Point"](*map(float, site.position))
    normal = types["geometry_msgs/msg/Vector3"](*map(float, site.normal))
    header, why = _header(types, site.stamp, "stage"), int(site.leaving)
    return types[SITE](header, site.site, point, normal, int(site.phase), why)


def _header(types: Any, stamp: int, frame: str) -> Any:
    time = types["builtin_interfaces/msg/Time"](*divmod(stamp, NANOSECONDS))
    return types["std_msgs/msg/Header"](time, frame)
