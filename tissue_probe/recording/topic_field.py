"""A field of a topic, such as ``/ft_sensor.wrench.force.z``, and its values over time.

What belongs here: finding the field, and what each message is stamped.
What does not: which fields make up a recording (``foreign_bag``).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from tissue_probe.recording.bag import Bag, Topic
from tissue_probe.recording.decoding import Decoder
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

_STEP = re.compile(r"\.?(\w+)|\[([^\]]+)\]")


@dataclass(frozen=True)
class FieldValues:
    """Values of a field; arrays have shape (n,).

    ``name`` is the field's in full; ``logged`` is when each message was recorded, ``stamped`` what
    its header says (None where it has no header, or an empty stamp) [ns since the epoch].
    """

    name: str
    logged: IntArray
    stamped: IntArray | None
    values: FloatArray


def read_field(bag: Bag, path: object, name: str, defaults: dict[str, str]) -> FieldValues:
    """Read a field of all messages of a topic, in the order recorded.

    Parameters
    ----------
    bag : Bag
        Where the topic is.
    path : path
        What to call the bag in messages.
    name : str
        ``/topic.field.field[index]``; the index of a JointState may be the name of a joint. With no
        field, that which ``defaults`` has for the type.
    defaults : dict
        Field by the name of the type.

    Raises
    ------
    RecordingError
        If there is no such topic, field or message, or the field is no number.
    """
    topic, steps = _find(bag, path, name, defaults)
    decoder = Decoder(topic)
    logged, stamps, values = [], [], []
    for raw in bag.messages([topic.name]):
        (message,) = decoder.decode([raw], lambda content: content)
        logged.append(raw.log_time)
        stamps.append(_stamp(message))
        values.append(_value(message, steps, topic))
    if not logged:
        raise RecordingError(f"{path} has no message on {topic.name}; record again")
    stamped = np.array(stamps, dtype=np.int64)
    return FieldValues(
        topic.name + "." + steps,
        np.array(logged, dtype=np.int64),
        stamped if stamped.all() else None,
        np.array(values, dtype=np.float64),
    )


def candidates(bag: Bag, fields: dict[str, str]) -> list[str]:
    """Return the fields of a bag's topics that a type's default names."""
    found = {topic.name: fields.get(_kind(topic)) for topic in bag.topics}
    return [f"{name}.{field}" for name, field in found.items() if field is not None]


def _find(bag: Bag, path: object, name: str, defaults: dict[str, str]) -> tuple[Topic, str]:
    topic_name, _, steps = name.partition(".")
    topics = {topic.name: topic for topic in bag.topics}
    if topic_name not in topics:
        raise RecordingError(
            f"{path} has no topic {topic_name}; it has {', '.join(topics) or 'none'}"
        )
    topic = topics[topic_name]
    steps = steps or defaults.get(_kind(topic), "")
    if not steps:
        raise RecordingError(
            f"{topic_name} is of type {topic.typename}: name its field too, such as "
            f"{topic_name}.data"
        )
    return topic, steps


def _kind(topic: Topic) -> str:
    return topic.typename.rpartition("/")[2]


def _value(message: Any, steps: str, topic: Topic) -> float:
    found = message
    try:
        for field, index in _STEP.findall(steps):
            if field:
                found = getattr(found, field)
            else:
                found = found[int(index) if index.isdigit() else message.name.index(index)]
        return float(found)
    except (AttributeError, IndexError, ValueError, TypeError) as error:
        raise RecordingError(
            f"{topic.name} has no number at {steps}; {_what_there_is(found)}"
        ) from error


def _what_there_is(found: Any) -> str:
    fields = getattr(found, "__dataclass_fields__", {})
    names = [name for name in fields if not name.startswith("__")]
    if names:
        return f"there are {', '.join(names)}"
    return f"there are {len(found)} elements" if hasattr(found, "__len__") else "it ends there"


def _stamp(message: Any) -> int:
    """Return what the header says [ns]; 0 where there is none."""
    header = getattr(message, "header", None)
    if header is None:
        return 0
    return header.stamp.sec * NANOSECONDS + header.stamp.nanosec
