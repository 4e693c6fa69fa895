"""A driver for which each single sample takes long to publish, as for many or slow readers.

Run as a program with the driver's arguments. COSTS is the time that each takes [s].
"""

from __future__ import annotations

import os
import time

from tissue_probe.nodes.sample_publisher import SamplePublisher


class CostlyPublisher(SamplePublisher):
    """The real one, kept busy beside each message."""

    def _publish_one(self, *sample) -> None:
        end = time.perf_counter() + float(os.environ["COSTS"])
        super()._publish_one(*sample)
        while time.perf_counter() < end:
            pass


if __name__ == "__main__":
    from tissue_probe.nodes import driver

    driver.SamplePublisher = CostlyPublisher
    raise SystemExit(driver.main())
