"""A bag: recorded messages by topic, whatever the file format.

What belongs here: the shape that every format's reader gives them.
What does not: the formats (``mcap_bag``, ``sqlite_bag``, ``folder_bag``), the messages' content
(``decoding``).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple, Protocol


class Topic(NamedTuple):
    """A recorded topic.

    ``definition`` is the type's full text in the encoding ``schema_encoding`` (``ros2msg``, ...;
    empty where the bag has none); ``message_encoding`` is that of its messages (``cdr``, ...).
    """

    name: str
    typename: str
    definition: str
    schema_encoding: str
    message_encoding: str


class RawMessage(NamedTuple):
    """One recorded message, its content still encoded; times in ns since the epoch.

    ``log_time`` is when the recorder received it, ``publish_time`` when it was published.
    """

    topic: str
    typename: str
    log_time: int
    publish_time: int
    data: bytes


class Bag(Protocol):
    """Recorded messages."""

    @property
    def topics(self) -> Sequence[Topic]:
        """What was recorded."""

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
        """Yield the messages of the topics so named, in the order of their log times."""
