"""The mapper node: estimates of each site become a stiffness map."""

from __future__ import annotations

import numpy as np
from pydantic import BaseModel
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header

from tissue_probe.mapping.fusion import MapBuilder
from tissue_probe.mapping.grid import Grid
from tissue_probe.nodes.cdr import estimate_from_cdr
from tissue_probe.nodes.conversions import cloud_message, site_from_message, to_time
from tissue_probe.nodes.diagnostics import OK, STALE, Diagnostics, Health, Rate
from tissue_probe.nodes.grid_settings import GridSettings
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.parameters import declare, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import ANNOUNCEMENTS, BLOCKS, LATCHED
from tissue_probe.nodes.timers import every
from tissue_probe.settings import setting
from tissue_probe_msgs.msg import PalpationSite, StiffnessMap, TissueEstimate

#: Time between two looks at what has arrived [s].
INTERVAL = 0.1


class MapperSettings(BaseModel):
    """Whose estimates make the map."""

    estimators: list[str] = setting(
        ["robust_ekf", "ekf", "ukf", "afekf"],
        "",
        "estimators to fuse, by the names of their topics",
    )
    frame_id: str = setting("stage", "", "frame of the map")


class Mapper(Node):
    """Fuses the converged estimates of each site and publishes the map whenever it changes."""

    def __init__(self) -> None:
        super().__init__("mapper")
        declare(self, MapperSettings)
        declare(self, GridSettings, "grid.")
        settings = read(self, MapperSettings)
        self._frame_id = settings.frame_id
        self._builder = MapBuilder(read(self, GridSettings, "grid.").make())
        self._published_revision = -1
        self.received = 0
        self._rate = Rate()
        self._maps = self.create_publisher(StiffnessMap, "stiffness_map", LATCHED)
        self._clouds = self.create_publisher(PointCloud2, "stiffness_cloud", LATCHED)
        self._inbox = Inbox(self)
        self._inbox.subscribe(PalpationSite, "palpation_site", ANNOUNCEMENTS, self._on_site)
        for name in settings.estimators:
            topic = f"{name}/estimate"
            self._inbox.subscribe(TissueEstimate, topic, BLOCKS, self._on_estimate, raw=True)
        every(INTERVAL, self, self._update)
        Diagnostics(self, self._examine)

    def destroy_node(self) -> None:
        """Let go of everything."""
        self._inbox.destroy()
        super().destroy_node()

    def _on_site(self, message: PalpationSite, info: dict) -> None:
        try:
            self._builder.announce(site_from_message(message))
        except ValueError as error:
            self.get_logger().error(f"site {message.site} is not on the map: {error}")

    def _on_estimate(self, message: bytes, info: dict) -> None:
        self.received += 1
        try:
            self._builder.add_one(*estimate_from_cdr(message))
        except ValueError as error:
            self.get_logger().error(f"an estimate is left out: {error}", throttle_duration_sec=1.0)

    def _update(self) -> None:
        self._inbox.empty()
        if self._builder.revision != self._published_revision:
            self._published_revision = self._builder.revision
            self._publish()

    def _publish(self) -> None:
        found = self._builder.map()
        grid: Grid = found.grid
        header = Header(stamp=to_time(found.stamp), frame_id=self._frame_id)
        message = StiffnessMap(header=header, spacing=grid.spacing)
        message.rows, message.columns = grid.shape
        message.origin.x, message.origin.y, message.origin.z = grid.origin
        layers = {
            "stiffness": found.stiffness,
            "damping": found.damping,
            "covariance_trace": found.covariance_trace,
            "stiffness_stddev": found.stiffness_stddev,
        }
        for name, layer in layers.items():
            setattr(message, name, layer.ravel().tolist())
        self._maps.publish(message)
        x, y = np.meshgrid(grid.x, grid.y)
        z = np.full(grid.shape, grid.origin[2])
        points = np.stack([layer.ravel() for layer in (x, y, z, *layers.values())], axis=1)
        self._clouds.publish(cloud_message(header, points, ["x", "y", "z", *layers]))

    def _examine(self) -> Health:
        measured = int(np.isfinite(self._builder.map().stiffness).sum())
        rate = self._rate(self.received)
        told = f"{measured} of {len(self._builder.grid)} cells are measured"
        values = {
            "publishers": self._inbox.publishers(),
            "estimates received": self.received,
            "achieved rate [estimates/s]": f"{rate:.0f}",
        }
        if not rate:
            return Health(STALE, f"{told}; no estimates in the last second", values)
        return Health(OK, told, values)


def main() -> int:
    """Run the mapper node."""
    return run(Mapper)


if __name__ == "__main__":
    raise SystemExit(main())
