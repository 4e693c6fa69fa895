"""The mapper node: estimates of each site become results, and these a map."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from tissue_probe.devices.limits import PALPATION_LEASE
from tissue_probe.mapping import site_results
from tissue_probe.mapping.kept_map import KeptMap
from tissue_probe.mapping.site_result import SiteResult
from tissue_probe.mapping.stiffness_map import StiffnessMapData
from tissue_probe.mapping.verdict import CellVerdict
from tissue_probe.nodes.cdr import estimate_from_cdr
from tissue_probe.nodes.conversions import site_from_message, to_time
from tissue_probe.nodes.diagnostics import OK, STALE, Diagnostics, Health, Rate
from tissue_probe.nodes.erring_sites import ErringSites
from tissue_probe.nodes.fused_estimators import FusedEstimators
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.live_posterior import LivePosterior
from tissue_probe.nodes.map_messages import (
    inclusions_message,
    markers_message,
    results_message,
    surface_cloud,
)
from tissue_probe.nodes.parameters import declare, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATCHED, SAMPLE_BLOCKS
from tissue_probe.nodes.scan_watch import ScanWatch
from tissue_probe.nodes.timers import every
from tissue_probe.settings import setting
from tissue_probe.signals import LONGEST_SILENCE
from tissue_probe_msgs.msg import (
    Inclusions,
    PalpationSite,
    SiteResults,
    StiffnessMap,
    TissueEstimate,
)

#: Time between two looks at the messages that arrived [s].
ESTIMATE_LOOK_INTERVAL = 0.1


class MapperSettings(FusedEstimators, ErringSites):
    """Whose estimates make the map, and where results are kept."""

    frame_id: str = setting("stage", "", "frame of the map")
    results_file: str = setting(
        "",
        "",
        "file that keeps each site's results for a mapper that is started again in the same scan; "
        "empty for one of this node's name and domain in ~/.local/state/tissue_probe",
    )


class Mapper(Node):
    """Fuses the estimates of each site and publishes the map whenever it changes.

    The grid is that through the announced sites: it grows with the scan, by the same rule as off
    line.
    """

    def __init__(self) -> None:
        super().__init__("mapper")
        declare(self, MapperSettings)
        settings = read(self, MapperSettings)
        self._frame_id = settings.frame_id
        file = Path(settings.results_file) if settings.results_file else self._stock_results_file()
        self._map = KeptMap(site_results.SiteResults(file), self.get_logger().error)
        self._published_revision = 0
        self._found: StiffnessMapData | None = None
        self._ended: list[SiteResult] = []
        self._posterior = LivePosterior(settings.outliers)
        self.received = 0
        self._malformed = 0
        self._rate = Rate()
        self._maps = self.create_publisher(StiffnessMap, "stiffness_map", LATCHED)
        self._sites = self.create_publisher(SiteResults, "sites", LATCHED)
        self._inclusions = self.create_publisher(Inclusions, "inclusions", LATCHED)
        self._clouds = self.create_publisher(PointCloud2, "stiffness_cloud", LATCHED)
        self._markers = self.create_publisher(MarkerArray, "inclusion_markers", LATCHED)
        self._inbox = Inbox(self)
        self._inbox.subscribe(PalpationSite, "palpation_site", ANNOUNCEMENTS, self._on_site)
        for name in settings.estimators:
            topic = f"{name}/estimate"
            self._inbox.subscribe(TissueEstimate, topic, SAMPLE_BLOCKS, self._on_estimate, raw=True)
        # As long as a scan may be silent by its own promise; a scan that was only late says so.
        self._scan_watch = ScanWatch(self, PALPATION_LEASE, self._on_silent_scan)
        every(ESTIMATE_LOOK_INTERVAL, self, self._update)
        Diagnostics(self, self._examine)

    def _stock_results_file(self) -> Path:
        state = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local/state")
        name = self.get_fully_qualified_name().strip("/").replace("/", ".")
        return state / "tissue_probe" / f"{name}.{self.context.get_domain_id()}.jsonl"

    def destroy_node(self) -> None:
        """Let go of everything."""
        self._inbox.destroy()
        self._posterior.close()
        super().destroy_node()

    def _on_site(self, message: PalpationSite, info: dict[str, int]) -> None:
        try:
            self._map.announce(site_from_message(message), info["source_timestamp"])
        except ValueError as error:
            self._leave_out(f"an announcement is left out: {error}")

    def _on_estimate(self, message: bytes, info: dict[str, int]) -> None:
        self.received += 1
        try:
            self._map.add_one(*estimate_from_cdr(message))
        except ValueError as error:
            self._leave_out(f"an estimate is left out: {error}")

    def _on_silent_scan(self, reason: str) -> None:
        self._inbox.empty()  # the estimates so far tell the time
        self._map.fall_silent(LONGEST_SILENCE)
        self.get_logger().warning(f"{reason}; nothing that is measured since counts for the site")

    def _leave_out(self, reason: str) -> None:
        self._malformed += 1
        self.get_logger().error(reason, throttle_duration_sec=1.0)

    def _update(self) -> None:
        self._inbox.empty()
        if self._map.revision != self._published_revision:
            self._published_revision = self._map.revision
            self._publish_grid()
            self._publish_sites()
        self._publish_posterior()

    def _publish_sites(self) -> None:
        """Publish the dwells' results; have the map made of those that have ended."""
        results = self._map.results()
        if results:
            self._sites.publish(results_message(self._header(results), results))
        ended = self._map.results(under_way=False)
        # Values that are NaN are unequal to themselves: texts are compared.
        if repr(ended) != repr(self._ended):
            self._ended = ended
            self._posterior.ask(ended)

    def _publish_posterior(self) -> None:
        found = self._posterior.take()
        if found is None:
            return
        if isinstance(found, str):
            self.get_logger().info(f"no inclusions are told yet: {found}")
            return
        told = self._header(found.results), found.map, found.lift
        self._inclusions.publish(inclusions_message(*told))
        self._clouds.publish(surface_cloud(*told))
        self._markers.publish(markers_message(*told))

    def _header(self, results: Sequence[SiteResult]) -> Header:
        newest = max(result.stamp for result in results)
        return Header(stamp=to_time(newest), frame_id=self._frame_id)

    def _publish_grid(self) -> None:
        """Publish the cells, where the sites lie on a square grid."""
        try:
            self._found = self._map.map()
        except ValueError as error:
            self.get_logger().info(f"there are no cells: {error}", throttle_duration_sec=10.0)
            return
        # Before any sample is known of, a map would have no time.
        if self._found.stamp:
            self._publish(self._found)

    def _publish(self, found: StiffnessMapData) -> None:
        grid = found.grid
        header = Header(stamp=to_time(found.stamp), frame_id=self._frame_id)
        message = StiffnessMap(header=header, spacing=grid.spacing)
        message.rows, message.columns = grid.shape
        message.origin.x, message.origin.y, message.origin.z = grid.origin
        layers: dict[str, NDArray[Any]] = {
            "stiffness": found.stiffness,
            "damping": found.damping,
            "covariance_trace": found.covariance_trace,
            "stiffness_stddev": found.stiffness_stddev,
            "verdict": found.verdict,
            "dwell_begin": found.dwell_begin,
        }
        for name, layer in layers.items():
            setattr(message, name, layer.ravel().tolist())
        self._maps.publish(message)

    def _examine(self) -> Health:
        rate = self._rate(self.received)
        verdicts = self._found.verdict if self._found is not None else np.zeros(0, np.uint8)
        measured = int(self._found.measured.sum()) if self._found is not None else 0
        told = f"{measured} of {verdicts.size} cells are measured"
        values = {
            "publishers": self._inbox.publishers(),
            "estimates received": self.received,
            "messages malformed": self._malformed,
            "achieved rate [estimates/s]": f"{rate:.0f}",
            **{
                f"cells {verdict.name}": int((verdicts == verdict).sum())
                for verdict in CellVerdict
                if verdict != CellVerdict.NOT_PALPATED
            },
        }
        if not rate:
            return Health(STALE, f"{told}; no estimates in the last second", values)
        return Health(OK, told, values)


def main() -> int:
    """Run the mapper node."""
    return run(Mapper)


if __name__ == "__main__":
    raise SystemExit(main())
