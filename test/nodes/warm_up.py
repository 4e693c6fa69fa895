"""Import all that nodes need but ROS itself, and load the machine code that they use.

``import rclpy`` starts threads of Fast DDS, which a fork would not have: each node imports it.
"""

# ruff: noqa: F401 - the imports are the purpose
from pathlib import Path

import diagnostic_msgs.msg
import kernels
import lifecycle_msgs.srv
import mcap.writer
import rosbags.typesys
import sensor_msgs.msg
import visualization_msgs.msg

import tissue_probe.identification
import tissue_probe.mapping.fusion
import tissue_probe_msgs.action
import tissue_probe_msgs.msg
from tissue_probe.estimation import ESTIMATORS

kernels.simulated()
for name in ESTIMATORS:
    kernels.estimated(name)

assert len(list(Path("/proc/self/task").iterdir())) == 1, "a fork has one thread of many"
