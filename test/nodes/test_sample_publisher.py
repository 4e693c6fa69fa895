"""Stamps and numbers of samples: given once at activation, then counted."""

from __future__ import annotations

import time

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.devices.device import Samples
from tissue_probe.nodes.cdr import samples_from_cdr
from tissue_probe.nodes.sample_publisher import SamplePublisher
from tissue_probe.signals import SampleBlock, join


def blocks_of(node) -> list[SampleBlock]:
    return [samples_from_cdr(data)[0] for data in node.publishers["samples"].published]


class Publisher:
    """Keeps what is published; nobody subscribes."""

    def __init__(self) -> None:
        self.published = []

    def publish(self, message) -> None:
        self.published.append(message)

    def get_subscription_count(self) -> int:
        return 0


class Node:
    """A node without a clock: whoever asks it for the time fails."""

    def create_publisher(self, message_type, topic, qos):
        self.publishers = {**getattr(self, "publishers", {}), topic: Publisher()}
        return self.publishers[topic]


@given(
    reads=st.lists(st.integers(1, 7), min_size=1, max_size=40),
    block_size=st.integers(1, 20),
    rate=st.sampled_from([500.0, 2000.0, 10000.0]),
)
def test_stamps_and_numbers_follow_from_the_activation_alone(reads, block_size, rate):
    node = Node()
    publisher = SamplePublisher(node, "probe", block_size)
    publisher.begin(1_000_000_000_000_000_123, 1.0 / rate)
    for count in reads:
        publisher.add(Samples(*np.random.default_rng(count).normal(size=(3, count))))
    publisher.flush()
    blocks = join(blocks_of(node))
    assert len(blocks) == 1
    assert len(blocks[0]) == sum(reads)
    assert blocks[0].stamp == 1_000_000_000_000_000_123
    assert np.all(np.diff(blocks[0].stamps) == round(1e9 / rate))


def test_a_step_of_the_clock_moves_no_stamp(monkeypatch):
    node = Node()
    publisher = SamplePublisher(node, "probe", 10)
    publisher.begin(1_000, 0.0005)
    publisher.add(Samples(*np.zeros((3, 10))))
    for clock in ("time", "time_ns", "monotonic", "monotonic_ns"):
        monkeypatch.setattr(time, clock, lambda: 1 / 0)
    publisher.add(Samples(*np.zeros((3, 10))))
    first, second = blocks_of(node)
    assert second.continues(first)
