"""On what it was measured: numbers mean little without it."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = ("numpy", "numba", "rosbags", "ros-rclpy", "ros-rmw-fastrtps-cpp")
#: Above this many processes wanting to run, others disturb the measurement.
LITTLE_LOAD = 0.3


def describe() -> dict[str, object]:
    """Return processor, cores, load average of the last minute, and versions."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load_average_at_start": os.getloadavg()[0],
        "system": platform.platform(),
        "python": platform.python_version(),
        **{name: found for name in PACKAGES if (found := _version(name))},
    }


def _processor() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.machine()


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:  # a full ROS 2 install is not made of Python packages
        return None
