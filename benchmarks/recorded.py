"""What a recorded run tells of its own speed and losses.

Contents: everything that is measured by messages, since each is recorded with the time at which it
was published.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.suite import ESTIMATORS
from tissue_probe.recording.bags.decoding import Decoder
from tissue_probe.recording.bags.decoding import samples as samples_of
from tissue_probe.recording.bags.open_bag import open_bag
from tissue_probe.recording.bags.reader import iterate_raw, read_recording
from tissue_probe.signals import NANOSECONDS

MEDIAN = "median lateness in the last second [ms]"
HIGH = "99th percentile of lateness in the last second [ms]"
WORST = "worst lateness in the last second [ms]"

_STAMP = struct.Struct("<iI")  # seconds, nanoseconds: a message with a header begins so
_ENCAPSULATION = 4  # bytes before a CDR message


def percentiles_ms(seconds: np.ndarray) -> dict[str, float]:
    """Return median, 99th percentile and largest of some times, in ms."""
    median, high = np.percentile(seconds, (50, 99))
    return {"p50_ms": 1e3 * median, "p99_ms": 1e3 * high, "max_ms": 1e3 * seconds.max()}


def delays(bag: Path, topic: str) -> np.ndarray:
    """Return from each message of a topic its time of publication minus its stamp [s]."""
    messages = list(iterate_raw(bag, [topic]))
    stamps = (_STAMP.unpack_from(message.data, _ENCAPSULATION) for message in messages)
    sampled = np.array([second * NANOSECONDS + rest for second, rest in stamps])
    published = np.array([message.publish_time for message in messages])
    return (published - sampled) / NANOSECONDS


def latencies(bag: Path) -> dict[str, dict[str, float]]:
    """Return each estimator's latency: from a block's last sample to its published estimate.

    An estimate carries the stamp of the last sample in it. The first sample of its block has
    waited longer, by the duration of the block less one period; ``first_p99_ms`` counts from it.
    """
    size, period = _block(bag)
    found = {name: percentiles_ms(delays(bag, f"/probe/{name}/estimate")) for name in ESTIMATORS}
    for latency in found.values():
        latency["first_p99_ms"] = latency["p99_ms"] + 1e3 * (size - 1) * period
    return found


def lateness(bag: Path) -> dict[str, float]:
    """Return the lateness of the sampling loop's wake-ups, which the driver sums up each second.

    Median and 99th percentile are the medians of those of all seconds, the largest is that of all.
    """
    seconds = [values for values in diagnostics(bag, "/probe/driver") if MEDIAN in values]
    return {
        "p50_ms": float(np.median([float(values[MEDIAN]) for values in seconds])),
        "p99_ms": float(np.median([float(values[HIGH]) for values in seconds])),
        "max_ms": max(float(values[WORST]) for values in seconds),
    }


def published(bag: Path) -> int:
    """Return how many samples the driver says it has published."""
    return int(diagnostics(bag, "/probe/driver")[-1]["samples published"])


def counts(bag: Path, estimators: Sequence[str] = ESTIMATORS) -> list[dict[str, object]]:
    """Return for each node how many samples or estimates were published, received, and lost.

    The driver counts what it publishes; an estimate is due for each block. The estimators count
    samples by their sequence numbers, as the bag's are counted for the recorder.
    """
    samples = published(bag)
    estimates = len(estimators) * math.ceil(samples / _block(bag)[0])
    mapped = int(diagnostics(bag, "/probe/mapper")[-1]["estimates received"])
    recorded = sum(len(delays(bag, f"/probe/{name}/estimate")) for name in estimators)
    return [
        *(count(name, "samples", samples, _received(bag, name)) for name in estimators),
        count("mapper", "estimates", estimates, mapped),
        count("recorder", "samples", samples, len(read_recording(bag))),
        count("recorder", "estimates", estimates, recorded),
    ]


def count(node: str, what: str, sent: int, received: int) -> dict[str, object]:
    """Return one row of what was published, received and lost."""
    return {
        "node": node,
        "what": what,
        "published": sent,
        "received": received,
        "lost": sent - received,
    }


def count_single(bag: Path, received: int, nanoseconds: int) -> dict[str, object]:
    """Return the row of the subscriber, who counted samples one by one for some time."""
    _, period = _block(bag)
    sent = 1 + round(nanoseconds / (period * NANOSECONDS))
    return count("subscriber", "singles", sent, received)


def diagnostics(bag: Path, node: str) -> list[dict[str, str]]:
    """Return the values that a node told on /diagnostics, in the order of time."""
    opened = open_bag(bag)
    topic = next(topic for topic in opened.topics if topic.name == "/diagnostics")
    statuses = (
        status
        for message in Decoder(topic, bag).decode(
            opened.messages([topic.name]), lambda message: message
        )
        for status in message.status
    )
    return [
        {pair.key: pair.value for pair in status.values}
        for status in statuses
        if status.name == node
    ]


def _received(bag: Path, estimator: str) -> int:
    return int(diagnostics(bag, f"/probe/{estimator}")[-1]["samples received"])


def _block(bag: Path) -> tuple[int, float]:
    """Return the samples of one block, and their period [s]."""
    topic = next(topic for topic in open_bag(bag).topics if topic.name == "/probe/samples")
    first = next(Decoder(topic, bag).decode(iterate_raw(bag, [topic.name]), samples_of))
    return len(first), first.sample_period
