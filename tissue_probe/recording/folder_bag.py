"""A bag that ``ros2 bag`` split over the files of a folder.

What belongs here: putting the files together.
What does not: reading them (``mcap_bag``, ``sqlite_bag``).

``rosbags`` reads folders too, but silently leaves out every topic whose QoS is written otherwise
in ``metadata.yaml`` than in the file, which converted bags often have.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from heapq import merge
from operator import attrgetter

from tissue_probe.recording.bag import Bag, RawMessage


class FolderBag:
    """Bags, at least one, as one (``bag.Bag``)."""

    def __init__(self, bags: Sequence[Bag]) -> None:
        self._bags = bags
        self.profile = bags[0].profile
        self.topics = tuple(dict.fromkeys(topic for bag in bags for topic in bag.topics))
        self.metadata = {name: values for bag in bags for name, values in bag.metadata.items()}
        self.truncated = any(bag.truncated for bag in bags)

    def messages(self, topics: Collection[str]) -> Iterator[RawMessage]:
        """Yield the messages of the topics so named, in the order of their log times."""
        return merge(*(bag.messages(topics) for bag in self._bags), key=attrgetter("log_time"))
