"""Which of the palpated sites have an estimate, as the mapper tells it on ``stiffness_map``."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from rclpy.node import Node

from tissue_probe.mapping.grid import Grid
from tissue_probe.nodes.conversions import from_time
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.qos import LATCHED
from tissue_probe_msgs.msg import StiffnessMap

TOPIC = "stiffness_map"
#: Verdicts of cells that have a value.
ESTIMATED = (StiffnessMap.MEASURED, StiffnessMap.DISTURBED)
#: A site is on the map if a cell lies within this part of the spacing of it: as a grid is laid
#: through positions (``Grid.through``).
ON_THE_CELL = 0.01
#: The mapper looks every 0.1 s at what has arrived, and publishes what changed: after two such
#: times without a new map it had nothing to say.
QUIET = 0.2


class SiteVerdicts:
    """Keeps the latest map, and reads in it what became of the sites.

    Parameters
    ----------
    node : Node
        Whose names the topic is relative to.
    inbox : Inbox
        Where maps are kept until the owner empties it.
    """

    def __init__(self, node: Node, inbox: Inbox) -> None:
        self._node = node
        self._map: StiffnessMap | None = None
        self._came = -np.inf
        inbox.subscribe(StiffnessMap, TOPIC, LATCHED, self._on_map)

    def unknown(self) -> str:
        """Say why nothing is known of any site; nothing if the map tells."""
        topic = self._node.resolve_topic_name(TOPIC)
        if self._map is None:
            return f"no map was heard on {topic}: is the mapper running?"
        if len(self._map.verdict) != self._map.rows * self._map.columns:
            return f"the map on {topic} has no verdict for each of its cells"
        return ""

    def nobody_maps(self) -> bool:
        """Whether there is no map, and nobody who could publish one."""
        return self._map is None and not self._node.count_publishers(TOPIC)

    def estimated(self, position: Sequence[float]) -> bool:
        """Whether the map has a value at a site's position [m]."""
        return not self.unknown() and self._verdict(position) in ESTIMATED

    def is_final(self, positions: Sequence[Sequence[float]], since: int) -> bool:
        """Whether nothing more is to be expected of the map.

        Parameters
        ----------
        positions : sequence of positions
            The sites that were palpated [m].
        since : int
            When the last dwell began [ns since the epoch]: an older map cannot have judged it.
        """
        return (
            all(map(self.estimated, positions))
            and from_time(self._map.header.stamp) >= since
            and time.monotonic() - self._came > QUIET
        )

    def _verdict(self, position: Sequence[float]) -> int:
        try:
            row, column = self._grid.nearest(position)
        except ValueError:  # the map's cells are elsewhere
            return StiffnessMap.NOT_PALPATED
        x, y, _ = self._grid.position(self._grid.site(row, column))
        if np.hypot(x - position[0], y - position[1]) > ON_THE_CELL * self._grid.spacing:
            return StiffnessMap.NOT_PALPATED
        return self._map.verdict[row * self._grid.columns + column]

    def _on_map(self, message: StiffnessMap, info: dict) -> None:
        origin = (message.origin.x, message.origin.y, message.origin.z)
        try:
            self._grid = Grid(origin, message.spacing, message.rows, message.columns)
        except ValueError as error:
            self._node.get_logger().error(f"a map is left out: {error}", throttle_duration_sec=1.0)
            return
        self._map = message
        self._came = time.monotonic()
