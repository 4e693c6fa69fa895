"""Qualities of service: reliable everywhere, since a CRTK client subscribes reliably."""

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

#: Sample blocks and estimates: five seconds at 200 Hz.
BLOCKS = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)

#: One message a sample: one second at 2 kHz.
PER_SAMPLE = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)

#: Poses of a stage or robot, of which only the latest matters.
POSES = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)

#: Where only the newest message counts.
LATEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)

#: What a late joiner must still learn: the map.
LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)

#: Announcements of sites: all those of a scan of up to 300 sites, for late joiners too.
ANNOUNCEMENTS = QoSProfile(
    depth=1000,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
