"""The watch of the scan: who has the tip in the tissue must show that it is alive.

The driver puts the coil at zero where it does not, and the mapper ends the dwell.

A scan node shows it on its announcements, from the loop that moves the probe (`lease`). A palpation
without announced sites is not watched, nor one that announces them without that promise: a replay,
for one, which holds no probe.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from rclpy.event_handler import QoSRequestedIncompatibleQoSInfo
from rclpy.node import Node
from rclpy.qos import LivelinessPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from tissue_probe.nodes.hearing import node_name
from tissue_probe.nodes.lease import Lease
from tissue_probe.nodes.timers import every
from tissue_probe_msgs.msg import PalpationSite

#: The action of a scan, by the phase that it announced last.
DOING = {PalpationSite.APPROACH: "on its way to", PalpationSite.DWELL: "in a dwell at"}

#: DDS tells of a publisher at once, and of its node's name in a message of its own, which comes
#: within its discovery period. A publisher that no ROS node made never gets a name [s].
NAMED_WITHIN = 3.0


class ScanWatch:
    """Calls ``on_silence`` with the reason if the scan node falls silent between sites' phases.

    It is watched from the announcement APPROACH of a site to its LIFTED; before and after, silence
    is its right.

    Parameters
    ----------
    node : Node
        Whose executor serves the watch, and relative to whose names ``palpation_site`` is.
    timeout : float
        Longest silence [s].
    on_silence : callable
        Called once for each silence.
    """

    def __init__(self, node: Node, timeout: float, on_silence: Callable[[str], None]) -> None:
        self._node = node
        self._on_silence = on_silence
        self._announced: PalpationSite | None = None
        self._lease = Lease(
            node,
            PalpationSite,
            "palpation_site",
            timeout,
            self._on_site,
            self._on_loss,
            self._on_no_promise,
        )

    def change_timeout(self, timeout: float) -> None:
        """Allow another silence [s] from now on; a scan under way stays watched."""
        self._lease.change_timeout(timeout)

    def _on_site(self, message: PalpationSite) -> None:
        self._announced = message if message.phase in DOING else None

    def _on_loss(self) -> None:
        if self._announced is None:
            return
        site, self._announced = self._announced, None
        self._on_silence(
            f"the scan node fell silent {DOING[site.phase]} site {site.site}: it died, hangs (for "
            f"{self._lease.timeout:g} s), or ended without having lifted the probe"
        )

    def _on_no_promise(self, event: QoSRequestedIncompatibleQoSInfo) -> None:
        """Warn of who announces without the promise, once the graph knows whose publisher it is."""
        topic = self._lease.topic_name
        last = time.monotonic() + NAMED_WITHIN

        def warn() -> None:
            publishers = self._node.get_publishers_info_by_topic(topic)
            names = sorted({node_name(info) for info in publishers if not self._is_promised(info)})
            if "" in names and time.monotonic() < last:
                return
            timer.cancel()
            self._node.destroy_timer(timer)
            self._node.get_logger().warning(
                f"{', '.join(filter(None, names)) or 'a node'} announces sites on {topic} without "
                f"the promise to show within {self._lease.timeout:g} s that it is alive (DDS "
                "liveliness, manual by topic): if it moves a probe, it is not noticed here when it "
                "dies"
            )

        timer = every(0.1, self._node, warn)

    def _is_promised(self, info: TopicEndpointInfo) -> bool:
        """Whether a publisher shows by itself, soon enough, that it is alive."""
        qos = info.qos_profile
        by_itself = qos.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC
        return bool(
            by_itself and qos.liveliness_lease_duration.nanoseconds <= self._lease.timeout * 1e9
        )
