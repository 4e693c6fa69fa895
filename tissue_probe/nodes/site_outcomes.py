"""The mapper's message on each visit, on ``sites``."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from rclpy.node import Node

from tissue_probe.mapping.site_result import SiteResult
from tissue_probe.mapping.verdict import CellVerdict
from tissue_probe.nodes.conversions import from_time
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.qos import LATCHED
from tissue_probe.signals import Leaving, sound_normal, sound_position
from tissue_probe_msgs import msg

TOPIC = "sites"


class SiteOutcomes:
    """Keeps the results of every visit that the mapper told last.

    Parameters
    ----------
    node : Node
        Whose names the topic is relative to.
    inbox : Inbox
        Where messages are kept until the owner empties it.
    """

    def __init__(self, node: Node, inbox: Inbox) -> None:
        self._node = node
        self._results: dict[int, SiteResult] = {}
        inbox.subscribe(msg.SiteResults, TOPIC, LATCHED, self._on_results)

    def of(self, begins: Collection[int]) -> list[SiteResult]:
        """Return the results of the dwells that began at these stamps and have ended [ns]."""
        found = (self._results.get(begin) for begin in begins)
        return [one for one in found if one is not None and one.leaving != Leaving.UNTOLD]

    def have_all(self, begins: Collection[int]) -> bool:
        """Whether each of these dwells has a result, or nobody publishes any."""
        return len(self.of(begins)) == len(begins) or self.nobody_maps()

    def unknown(self, begins: Collection[int]) -> str:
        """Say why nothing is known of any of these dwells; nothing if the mapper tells."""
        if begins and not self.of(begins):
            topic = self._node.resolve_topic_name(TOPIC)
            return f"no result of them was heard on {topic}: is the mapper running?"
        return ""

    def nobody_maps(self) -> bool:
        """Whether nobody publishes results."""
        return not self._node.count_publishers(TOPIC)

    def _on_results(self, message: msg.SiteResults, info: dict[str, int]) -> None:
        try:
            results = [_result(each) for each in message.results]
        except ValueError as error:
            self._node.get_logger().error(
                f"results of sites are left out: {error}", throttle_duration_sec=1.0
            )
            return
        self._results = {one.stamp: one for one in results}


def _result(message: msg.SiteResult) -> SiteResult:
    place, normal = message.position, message.normal
    return SiteResult(
        site=message.site,
        repeat=message.repeat,
        stamp=from_time(message.header.stamp),
        position=sound_position((place.x, place.y, place.z)),
        normal=sound_normal((normal.x, normal.y, normal.z)),
        stiffness=message.stiffness,
        damping=message.damping,
        covariance_trace=np.nan,
        stiffness_stddev=message.stiffness_stddev,
        damping_stddev=message.damping_stddev,
        verdict=CellVerdict(message.verdict),
        leaving=Leaving(message.leaving),
    )
