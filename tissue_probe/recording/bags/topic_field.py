"""A field of a topic, such as ``/ft_sensor.wrench.force.z``, and its values over time.

Contents: finding the field, and the stamp of each message.
"""

from __future__ import annotations

import re
from array import array
from dataclasses import dataclass
from typing import Any

import numpy as np

from tissue_probe.recording.bags.bag import Bag, Topic, report_progress
from tissue_probe.recording.bags.decoding import Decoder
from tissue_probe.recording.columns.source import Progress
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import NANOSECONDS, FloatArray, IntArray

FORCE_FIELDS = {"WrenchStamped": "wrench.force.z", "Wrench": "force.z"}
"""Which field of a message is meant where none is named, by the type's name: force."""

POSITION_FIELDS = {
    "PoseStamped": "pose.position.z",
    "Pose": "position.z",
    "TransformStamped": "transform.translation.z",
    "PointStamped": "point.z",
    "Point": "z",
    "Vector3Stamped": "vector.z",
    "JointState": "position[0]",
    "Float64Stamped": "data",
    "Float32Stamped": "data",
    "Float64": "data",
    "Float32": "data",
}
"""The same of position."""

INPUT2_FIELDS = {
    "FluidPressure": "fluid_pressure",
    "Temperature": "temperature",
    "Float64Stamped": "data",
    "Float32Stamped": "data",
    "Float64": "data",
    "Float32": "data",
}
"""The same of a further channel."""

_LATEST = 2**63 - 1  # ns; in 292 years from 1970: a later time is damage
_STEP_PATTERN = re.compile(r"\.?(\w+)|\[([^\]]+)\]")


@dataclass(frozen=True)
class FieldValues:
    """Values of a field; arrays have shape (n,), in the order stored.

    ``name`` is the field's in full; ``logged`` is when each message was recorded, ``stamped`` the
    time in its header (None where no message has a stamp) [ns since the epoch]. ``notes`` tells in
    sentences which messages were left out.
    """

    name: str
    logged: IntArray
    stamped: IntArray | None
    values: FloatArray
    notes: tuple[str, ...] = ()


def read_field(
    bag: Bag,
    path: object,
    name: str,
    defaults: dict[str, str],
    progress: Progress = lambda share: None,
    share: tuple[float, float] = (0.0, 1.0),
) -> FieldValues:
    """Read a field of all messages of a topic, in the order stored.

    Messages without any content are left out.

    Parameters
    ----------
    bag : Bag
        Where the topic is.
    path : path
        The bag's name in messages.
    name : str
        ``/topic.field.field[index]``; the index of a JointState may be the name of a joint. With no
        field, that which ``defaults`` has for the type. Where several sensors publish on the topic,
        ``@`` and the ``frame_id`` of one of them: ``/topic.field@frame``.
    defaults : dict
        Field by the name of the type.
    progress, share
        Told how much is read, between these two of all.

    Raises
    ------
    RecordingError
        If there is no such topic, field or message, the field is no number, or several sensors
        publish on the topic and none is chosen.
    """
    name, _, frame = name.partition("@")
    topic, asked = _find(bag, path, name)
    decoder = Decoder(topic, path)
    steps: dict[Topic, list[tuple[str, str]]] = {}
    logged, stamps, values = array("q"), array("q"), array("d")
    frames: set[str] = set()
    empty = 0
    for raw in report_progress(bag, [topic.name], progress, share):
        if not raw.data:
            empty += 1
            continue
        (message,) = decoder.decode([raw], lambda content: content)
        header = getattr(message, "header", None)
        frames.add(own := getattr(header, "frame_id", ""))
        if frame and own != frame:
            continue
        if raw.channel not in steps:
            steps[raw.channel] = _STEP_PATTERN.findall(
                asked or _default(path, raw.channel, defaults)
            )
        logged.append(min(raw.log_time, _LATEST))
        stamps.append(header.stamp.sec * NANOSECONDS + header.stamp.nanosec if header else 0)
        values.append(_value(path, message, steps[raw.channel], topic))
    _refuse_several(path, topic, frames, frame)
    if not logged:
        raise RecordingError(f"{path} has no message on {topic.name}; record again")
    stamped = np.frombuffer(stamps, dtype=np.int64)
    notes = [f"{empty} messages of {topic.name} have no content, and are left out"] if empty else []
    return FieldValues(
        f"{topic.name}.{asked or _default(path, topic, defaults)}{'@' if frame else ''}{frame}",
        np.frombuffer(logged, dtype=np.int64),
        stamped if stamped.any() else None,
        np.frombuffer(values, dtype=np.float64),
        tuple(notes),
    )


def candidates(bag: Bag, fields: dict[str, str]) -> list[str]:
    """Return the fields of a bag's topics that a type's default names."""
    found = {topic.name: fields.get(_kind(topic)) for topic in bag.topics}
    return [f"{name}.{field}" for name, field in found.items() if field is not None]


def _find(bag: Bag, path: object, name: str) -> tuple[Topic, str]:
    """Return the topic, and which field is asked for; empty where none is."""
    topic_name, _, asked = name.partition(".")
    topics = {topic.name: topic for topic in bag.topics}
    if topic_name not in topics:
        if not topics:
            raise RecordingError(
                f"{path} has no topics, as a recorder leaves it that heard none: record again"
            )
        raise RecordingError(f"{path} has no topic {topic_name}; give one of {', '.join(topics)}")
    return topics[topic_name], asked


def _default(path: object, topic: Topic, defaults: dict[str, str]) -> str:
    if found := defaults.get(_kind(topic)):
        return found
    raise RecordingError(
        f"{path}: {topic.name} is of type {topic.typename}: name its field too, such as "
        f"{topic.name}.data"
    )


def _refuse_several(path: object, topic: Topic, frames: set[str], chosen: str) -> None:
    there = " and ".join(sorted(frames))
    if chosen and chosen not in frames:
        raise RecordingError(f"{path} has no message of {chosen} on {topic.name}; there is {there}")
    if len(frames) > 1 and not chosen:
        raise RecordingError(
            f"{path}: several sensors publish on {topic.name}, by their frame_id {there}; choose "
            f"one, such as {topic.name}@{min(frames)}"
        )


def _kind(topic: Topic) -> str:
    return topic.typename.rpartition("/")[2]


def _value(path: object, message: Any, steps: list[tuple[str, str]], topic: Topic) -> float:
    found = message
    try:
        for field, index in steps:
            if field:
                found = getattr(found, field)
            else:
                found = found[int(index) if index.isdigit() else message.name.index(index)]
        return float(found)
    except (AttributeError, IndexError, ValueError, TypeError) as error:
        asked = "".join(f".{field}" if field else f"[{index}]" for field, index in steps)
        raise RecordingError(
            f"{path}: {topic.name} has no number at {asked[1:]}; {_what_there_is(found)}"
        ) from error


def _what_there_is(found: Any) -> str:
    fields = getattr(found, "__dataclass_fields__", {})
    names = [name for name in fields if not name.startswith("__")]
    if names:
        return f"there are {', '.join(names)}"
    return f"there are {len(found)} elements" if hasattr(found, "__len__") else "it ends there"
