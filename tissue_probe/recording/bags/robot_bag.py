"""The samples that the node ``adapter`` makes of a robot's topics, out of a bag of these.

Contents: bringing a bag's messages to ``robot.adapter``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from tissue_probe.recording.bags.bag import Bag, by_log_time
from tissue_probe.recording.bags.decoding import Decoder
from tissue_probe.recording.columns.source import Progress
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.robot.adapter import Adapter
from tissue_probe.recording.robot.settings import RobotDescription
from tissue_probe.signals import Recording, SampleBlock, join

MESSAGES_TOGETHER = 4096
"""Messages between two looks at new poses and forces: each look costs as much as some tens of them,
and as many wait in memory."""


def read_robot_bag(
    bag: Bag, path: Path, settings: RobotDescription, progress: Progress = lambda share: None
) -> tuple[Recording, tuple[str, ...]]:
    """Return the samples that the node makes of the same messages, bit for bit, and notes.

    Parameters
    ----------
    bag : Bag
        Of ROS 1 or 2.
    path : path
        Its name in messages.
    settings : RobotDescription
        By which the node ran, or would.
    progress : callable
        Told the share that is read, from 0 to 1.

    Raises
    ------
    RecordingError
        If a topic is missing or of another type, or no samples come of them; says why.
    """
    adapter = Adapter(settings)
    blocks = join(_blocks(bag, path, adapter, settings, progress))
    faults = [*adapter.position.faults.values(), *adapter.force.faults.values()]
    told = [f"{fault.sentence} ({fault.count} in all)" for fault in faults]
    if not blocks:
        why = "; ".join(told) or "they were never recorded at the same time"
        raise RecordingError(
            f"{path}: {settings.position} and {settings.force} make no samples: {why}"
        )
    read = (
        f"{path}: {adapter.grid.samples} samples in {adapter.grid.runs} "
        f"run{'s' if adapter.grid.runs > 1 else ''}, of {settings.position} and {settings.force} "
        "as the node adapter makes them"
    )
    return Recording(tuple(blocks)), (read, *told)


def _blocks(
    bag: Bag, path: Path, adapter: Adapter, settings: RobotDescription, progress: Progress
) -> Iterator[SampleBlock]:
    """Yield samples as they become known; messages come in the order of their log times."""
    pose = "sensor_msgs/msg/JointState" if settings.joint else "geometry_msgs/msg/PoseStamped"
    takers: dict[str, tuple[Decoder, Callable[[Any], None]]] = {
        settings.position: (_decoder(bag, path, settings.position, pose), adapter.take_position),
        settings.force: (
            _decoder(bag, path, settings.force, "geometry_msgs/msg/WrenchStamped"),
            adapter.take_force,
        ),
    }
    for number, raw in enumerate(by_log_time(bag, list(takers), progress)):
        decoder, take = takers[raw.topic]
        for _ in decoder.decode([raw], take):
            pass
        if number % MESSAGES_TOGETHER == MESSAGES_TOGETHER - 1:
            yield from adapter.samples()
    yield from adapter.samples()


def _decoder(bag: Bag, path: Path, name: str, typename: str) -> Decoder:
    topics = {topic.name: topic for topic in bag.topics}
    if name not in topics:
        there = ", ".join(topics) or "none"
        raise RecordingError(f"{path} has no topic {name}; its topics are {there}")
    # ROS 1 leaves the middle of a type's name out.
    if topics[name].typename.replace("/msg/", "/") != typename.replace("/msg/", "/"):
        raise RecordingError(
            f"{path}: {name} has {topics[name].typename}, and the adapter takes {typename}"
        )
    return Decoder(topics[name], path)
