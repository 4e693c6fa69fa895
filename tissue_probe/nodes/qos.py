"""Qualities of service: reliable everywhere, since a CRTK client subscribes reliably."""

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

from tissue_probe.devices.limits import PALPATION_LEASE

#: Sample blocks and estimates: five seconds at 200 Hz.
SAMPLE_BLOCKS = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)

#: One message a sample: one second at 2 kHz.
PER_SAMPLE = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)

#: Poses and states of a stage or robot: only the latest matters, but that may be no number.
POSES = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)

#: For messages that a late joiner must still learn: the map.
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

#: The same from a scan node, which promises to show while a scan goes on that it is alive: only its
#: own word counts, not that its process exists. Who does not ask for that hears it as before.
SCAN_ANNOUNCEMENTS = QoSProfile(
    depth=ANNOUNCEMENTS.depth,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
    liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
    liveliness_lease_duration=Duration(seconds=PALPATION_LEASE),
)

#: The latest word of a node on a loan of the excitation, with the same promise while it lasts.
LOANS = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
    liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
    liveliness_lease_duration=Duration(seconds=PALPATION_LEASE),
)


def announcement_quality(timeout: float) -> QoSProfile:
    """Return the watch's quality of service: the latest announcement, a sign in ``timeout`` [s].

    Who promises less is not heard, and told as incompatible.
    """
    return QoSProfile(
        depth=1,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
        liveliness_lease_duration=Duration(seconds=timeout),
    )
