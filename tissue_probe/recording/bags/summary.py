"""The contents of a bag, in a few figures.

Contents: the figures of ``tissue_probe info``, of any bag, also a foreign one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from tissue_probe.recording.bags import decoding
from tissue_probe.recording.bags.bag import Bag, by_log_time
from tissue_probe.recording.bags.decoding import Decoder
from tissue_probe.recording.bags.open_bag import open_bag
from tissue_probe.recording.bags.reader import topics_of_type
from tissue_probe.signals import NANOSECONDS, Phase, SampleBlock, join


@dataclass(frozen=True)
class TopicSummary:
    """A topic's name, its type and the number of its messages."""

    name: str
    typename: str
    messages: int


@dataclass(frozen=True)
class SamplesSummary:
    """Samples recorded on one topic, and lost on the way to the recorder by their sequence numbers.

    ``first`` is the number of the first one recorded: above 0, the recording began late.

    A sequence that steps back (the probe was activated anew) loses nothing.
    """

    topic: str
    recorded: int
    lost: int
    first: int


@dataclass(frozen=True)
class BagSummary:
    """A bag in a few figures.

    ``start`` [ns since the epoch] is the first log time, None without messages; ``duration`` [s]
    the time from the first to the last; ``sites`` the numbers of the sites palpated, in order;
    ``truncated`` whether the recorder did not get to close the bag.
    """

    topics: tuple[TopicSummary, ...]
    start: int | None
    duration: float
    samples: tuple[SamplesSummary, ...]
    sites: tuple[int, ...]
    metadata: Mapping[str, Mapping[str, str]]
    truncated: bool


def summarize(path: str | Path) -> BagSummary:
    """Summarize a bag: MCAP of any profile, ``.db3``, or a bag folder.

    Raises
    ------
    RecordingError
        If it is no bag that can be read.
    """
    bag = open_bag(path)
    counts: Counter[tuple[str, str]] = Counter()
    start, end = None, 0
    for message in bag.messages({topic.name for topic in bag.topics}):
        counts[message.channel[:2]] += 1
        start = message.log_time if start is None else min(start, message.log_time)
        end = max(end, message.log_time)
    return BagSummary(
        topics=tuple(
            TopicSummary(name, typename, counts[name, typename])
            for name, typename in dict.fromkeys(topic[:2] for topic in bag.topics)
        ),
        start=start,
        duration=0.0 if start is None else (end - start) / NANOSECONDS,
        samples=tuple(_samples(bag, path)),
        sites=tuple(_sites(bag, path)),
        metadata=bag.metadata,
        truncated=bag.truncated,
    )


def _samples(bag: Bag, path: object) -> Iterator[SamplesSummary]:
    for topic in topics_of_type(bag, decoding.SAMPLES):
        blocks = join(
            Decoder(topic, path).decode_sound(by_log_time(bag, [topic.name]), decoding.samples)
        )
        recorded = sum(len(block) for block in blocks)
        first = blocks[0].sequence if blocks else 0
        yield SamplesSummary(topic.name, recorded, sum(_gaps(blocks)), first)


def _gaps(blocks: list[SampleBlock]) -> Iterator[int]:
    for block, following in pairwise(blocks):
        yield max(0, following.sequence - block.sequence - len(block))


def _sites(bag: Bag, path: object) -> Iterator[int]:
    for topic in topics_of_type(bag, decoding.SITE):
        for site in Decoder(topic, path).decode_sound(
            by_log_time(bag, [topic.name]), decoding.site
        ):
            if site.phase == Phase.DWELL:
                yield site.site
