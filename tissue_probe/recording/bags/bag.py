"""A bag: recorded messages by topic, of any file format.

Contents: the shape that every format's reader gives them, and their order.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from heapq import heappop, heappush
from typing import NamedTuple, Protocol

import numpy as np

from tissue_probe.recording.columns.source import Progress

TOLD_EVERY = 1024
"""Messages between two reports of how much is read."""


class Topic(NamedTuple):
    """A recorded topic.

    ``definition`` is the type's full text in the encoding ``schema_encoding`` (``ros2msg``, ...;
    empty where the bag has none); ``message_encoding`` is that of its messages (``cdr``, ...).
    Several of one name are one topic on which messages of several definitions were published.
    """

    name: str
    typename: str
    definition: str
    schema_encoding: str
    message_encoding: str


class RawMessage(NamedTuple):
    """One recorded message, its content still encoded; times in ns since the epoch.

    ``channel`` is the topic, with the definition of this message; ``log_time`` is when the recorder
    received it, ``publish_time`` when it was published.
    """

    channel: Topic
    log_time: int
    publish_time: int
    data: bytes

    @property
    def topic(self) -> str:
        """Name of the topic."""
        return self.channel.name

    @property
    def typename(self) -> str:
        """Name of the message's type."""
        return self.channel.typename


class Bag(Protocol):
    """Recorded messages."""

    @property
    def topics(self) -> Sequence[Topic]:
        """The recorded topics."""

    @property
    def metadata(self) -> Mapping[str, Mapping[str, str]]:
        """Text by key, by name."""

    @property
    def profile(self) -> str:
        """Which framework recorded (``ros2``, ...)."""

    @property
    def truncated(self) -> bool:
        """Whether the recorder did not get to close the bag."""

    def messages(self, topics: Collection[str]) -> Iterator[RawMessage]:
        """Yield the messages of the topics so named, in the order in which they were stored."""

    def count(self, topics: Collection[str]) -> int:
        """Return how many messages of the topics so named there are, as far as the bag tells."""


def report_progress(
    bag: Bag, topics: Collection[str], progress: Progress, share: tuple[float, float] = (0.0, 1.0)
) -> Iterator[RawMessage]:
    """Yield messages as ``bag.messages`` does, and tell how much is read.

    ``share`` is between which two of all reading these lie: a bag may be passed several times.
    """
    begin, end = share
    count = max(bag.count(topics), 1)
    for number, message in enumerate(bag.messages(topics)):
        if number % TOLD_EVERY == 0:
            progress(begin + (end - begin) * min(number / count, 1.0))
        yield message
    progress(end)


def by_log_time(
    bag: Bag, topics: Collection[str], progress: Progress = lambda share: None
) -> Iterator[RawMessage]:
    """Yield the messages of the topics so named, in the order of their log times.

    Only as many wait in memory as lie before an earlier one.
    """
    first = report_progress(bag, topics, progress, (0.0, 0.5))
    times = np.fromiter((message.log_time for message in first), np.uint64)
    earliest_after = np.minimum.accumulate(times[::-1])[::-1]
    waiting: list[tuple[int, int, RawMessage]] = []
    for number, message in enumerate(report_progress(bag, topics, progress, (0.5, 1.0)), start=1):
        heappush(waiting, (message.log_time, number, message))
        # A recorder may go on writing in between: messages behind the counted ones come last.
        after = earliest_after[number] if number < times.size else None
        while waiting and (after is None or waiting[0][0] <= after):
            yield heappop(waiting)[2]
