"""How samples leave the driver: as blocks, and one by one for surgical stacks."""

from __future__ import annotations

import time

import numpy as np
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.duration import Duration
from rclpy.node import Node

from tissue_probe.devices.device import Samples
from tissue_probe.nodes.cdr import pose_to_cdr, samples_to_cdr, wrench_to_cdr
from tissue_probe.nodes.qos import PER_SAMPLE, SAMPLE_BLOCKS
from tissue_probe.nodes.shedding import Shedding
from tissue_probe.signals import NANOSECONDS, SampleBlock
from tissue_probe_msgs.msg import ProbeSamples

#: Longest wait for the last blocks to reach everyone. Who has them says so at the next of DDS's
#: heartbeats, and lost ones are sent again then: by default 3 s apart, 0.1 s by discovery.xml.
LONGEST_DELIVERY = Duration(seconds=5)


class SamplePublisher:
    """Numbers and stamps samples, and publishes them.

    Sample n of an activation is stamped ``start + n * sample_period``: stamps are exactly
    equidistant and never step, also where the wall clock does.

    ``measured_cp`` carries the coil's displacement u [m] as position.z, ``measured_cf`` the
    load-cell force F [N] (positive in compression) as force.z, in the probe's frame. They are sent
    only while someone subscribes to them, and while that leaves acquisition its time.

    Attributes
    ----------
    published : int
        Samples published in blocks since ``begin``.
    shed : int
        Samples since ``begin`` that should have gone out singly, too, and did not.
    shedding : Shedding
        Whether, and why.
    """

    def __init__(self, node: Node, frame_id: str, block_size: int) -> None:
        self._node = node
        self._frame_id = frame_id
        self._block_size = block_size
        self._blocks = node.create_publisher(ProbeSamples, "samples", SAMPLE_BLOCKS)
        self._poses = node.create_publisher(PoseStamped, "measured_cp", PER_SAMPLE)
        self._wrenches = node.create_publisher(WrenchStamped, "measured_cf", PER_SAMPLE)
        self.published = self.shed = 0
        self.shedding = Shedding()

    @property
    def subscribers(self) -> int:
        """How many subscriptions the blocks reach."""
        return self._blocks.get_subscription_count()

    @property
    def missing(self) -> int:
        """How many samples the present block still wants."""
        return self._block_size - self._pending_count

    @property
    def goes_singly(self) -> bool:
        """Whether the next sample goes out by itself: it is wanted, and there is time for it."""
        return self._wanted_singly and self.shedding.allows

    @property
    def _wanted_singly(self) -> bool:
        return self._pose_wanted or self._wrench_wanted

    def begin(self, start: int, sample_period: float) -> None:
        """Begin to number samples at 0, sample 0 stamped ``start`` [ns since the epoch]."""
        self._start = start
        self._period = sample_period
        self._pending: list[Samples] = []
        self._pending_count = 0
        self.published = self.shed = 0
        self.shedding = Shedding()
        self._look_for_subscribers()

    def add(self, samples: Samples) -> bool:
        """Publish samples one by one now, and the block if they complete it; return if they did."""
        if not self._wanted_singly:
            return self._add_to_block(samples)
        began = time.perf_counter()
        first, count, singly = self.published + self._pending_count, len(samples.position), True
        if self.shedding.allows:
            for i in range(count):
                self._publish_one(first + i, samples.position[i], samples.force[i])
        else:
            self.shed += count
            singly = False
        complete = self._add_to_block(samples)
        self.shedding.note(time.perf_counter() - began, count * self._period, singly=singly)
        return complete

    def is_own(self, block: SampleBlock) -> bool:
        """Whether a block is one of this activation: no other has its stamps."""
        return block.stamp == self._stamp(block.sequence)

    def _add_to_block(self, samples: Samples) -> bool:
        self._pending.append(samples)
        self._pending_count += samples.position.size
        complete = self._pending_count >= self._block_size
        if complete:
            self.flush()
        return complete

    def flush(self) -> None:
        """Publish the samples of an incomplete block."""
        if not self._pending:
            return
        parts, self._pending, self._pending_count = self._pending, [], 0
        block = SampleBlock(
            stamp=self._stamp(self.published),
            sequence=self.published,
            sample_period=self._period,
            position=np.concatenate([part.position for part in parts]),
            force=np.concatenate([part.force for part in parts]),
            command=np.concatenate([part.command for part in parts]),
        )
        self._blocks.publish(samples_to_cdr(block, self._frame_id))
        self.published += len(block)
        self._look_for_subscribers()

    def deliver(self) -> None:
        """Wait until everyone has the last block, at most ``LONGEST_DELIVERY``."""
        self._blocks.wait_for_all_acked(LONGEST_DELIVERY)

    def destroy(self) -> None:
        """Let go of the publishers."""
        for publisher in (self._blocks, self._poses, self._wrenches):
            self._node.destroy_publisher(publisher)

    def _stamp(self, number: int) -> int:
        return self._start + round(number * self._period * NANOSECONDS)

    def _look_for_subscribers(self) -> None:
        self._pose_wanted = self._poses.get_subscription_count() > 0
        self._wrench_wanted = self._wrenches.get_subscription_count() > 0
        if self.shedding.active and not self._wanted_singly:
            self.shedding = Shedding()  # the next subscriber finds it as it is then

    def _publish_one(self, number: int, position: float, force: float) -> None:
        stamp = self._stamp(number)
        if self._pose_wanted:
            self._poses.publish(pose_to_cdr(stamp, position, self._frame_id))
        if self._wrench_wanted:
            self._wrenches.publish(wrench_to_cdr(stamp, force, self._frame_id))
