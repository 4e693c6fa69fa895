"""From recorded bytes to arrays, by the definition that the bag carries.

Contents: this suite's messages.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from tissue_probe.recording.bags.bag import RawMessage, Topic
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import (
    LAST_SEQUENCE,
    NANOSECONDS,
    TEXT,
    UP,
    EstimatorModel,
    FloatArray,
    IntArray,
    Leaving,
    PalpationSite,
    Phase,
    SampleBlock,
    TissueEstimates,
    sound_block,
    sound_normal,
    sound_position,
    sound_stamp,
)

_log = logging.getLogger(__name__)

SAMPLES = "tissue_probe_msgs/msg/ProbeSamples"
SITE = "tissue_probe_msgs/msg/PalpationSite"
ESTIMATE = "tissue_probe_msgs/msg/TissueEstimate"
ESTIMATOR_MODEL = "tissue_probe_msgs/msg/EstimatorModel"
MAP_MESSAGE = "tissue_probe_msgs/msg/StiffnessMap"

Content = TypeVar("Content")


@dataclass(frozen=True)
class RecordedMap:
    """A stiffness map as it was published; arrays have shape (rows, columns).

    ``stamp`` [ns since the epoch] is that of the newest estimate in it. The cell in row r and
    column c lies at ``origin`` (x, y, z) [m] plus (c, r, 0) times ``spacing`` [m]. ``stiffness``
    [N/m], ``damping`` [N s/m], ``covariance_trace`` and ``stiffness_stddev`` [N/m] are NaN
    where nothing was measured. ``verdict`` holds the numbers of ``StiffnessMap.msg``, and
    ``dwell_begin`` when each cell was measured [ns since the epoch]; None in recordings of versions
    that had none.
    """

    stamp: int
    origin: tuple[float, float, float]
    spacing: float
    stiffness: FloatArray
    damping: FloatArray
    covariance_trace: FloatArray
    stiffness_stddev: FloatArray
    verdict: NDArray[np.uint8] | None
    dwell_begin: IntArray | None


class Decoder:
    """Decodes the messages of one topic, each by its definition in the bag.

    Where the bag has none, as older ones of ROS 2, the common types (``std_msgs``,
    ``geometry_msgs``, ...) are decoded by the definitions that ROS 2 has.

    Parameters
    ----------
    topic : Topic
        Whose messages.
    path : path
        The bag's name in messages.

    Raises
    ------
    RecordingError
        If the topic is encoded otherwise than ROS 1 or 2 do, or its definition is missing or not
        understood.
    """

    def __init__(self, topic: Topic, path: object) -> None:
        self._path = path
        self._decoders = {topic: self._deserializer(topic)}

    def decode(
        self, messages: Iterable[RawMessage], convert: Callable[[Any], Content]
    ) -> Iterator[Content]:
        """Yield each message as ``convert`` makes it of the decoded fields.

        Raises
        ------
        RecordingError
            If a message is damaged, has other fields than this suite's, or values that
            ``convert`` refuses; or if it has a definition of its own, and that is not understood.
        """
        return (self._decode(message, convert) for message in messages)

    def decode_sound(
        self, messages: Iterable[RawMessage], convert: Callable[[Any], Content]
    ) -> Iterator[Content]:
        """Yield messages as ``decode`` does; leave out, with a warning, those that are malformed.

        The live nodes leave these out, too, so that a later computation has their results.

        Raises
        ------
        RecordingError
            If a message has other fields than this suite's, or every one is malformed.
        """
        sound, malformed, first = 0, 0, None
        for message in messages:
            try:
                content = self._decode(message, convert)
            except RecordingError as error:
                if isinstance(error.__cause__, AttributeError):
                    raise
                malformed, first = malformed + 1, first or error
                continue
            sound += 1
            yield content
        if first is not None:
            if not sound:
                raise first
            _log.warning("%d malformed messages are left out; of the first: %s", malformed, first)

    def _decode(self, message: RawMessage, convert: Callable[[Any], Content]) -> Content:
        if (decode := self._decoders.get(message.channel)) is None:
            decode = self._decoders[message.channel] = self._deserializer(message.channel)
        try:
            return convert(decode(message.data))
        except RecordingError:
            raise
        except _DECODING_ERRORS as error:
            raise RecordingError(
                f"{self._path}: the message of {message.topic} logged at {message.log_time} ns is "
                f"not a valid {message.typename}: {_first_line(error) or 'it has no content'}"
            ) from error

    def _deserializer(self, topic: Topic) -> Callable[[bytes], Any]:
        try:
            return _deserializer(topic)
        except RecordingError as error:
            raise RecordingError(f"{self._path}: {error}") from error


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0]


# Errors of rosbags on damaged content.
_DECODING_ERRORS = (
    SerdeError, AttributeError, ValueError, AssertionError, LookupError, OverflowError,
    struct.error, MemoryError,
)  # fmt: skip


def _deserializer(topic: Topic) -> Callable[[bytes], Any]:
    if topic.message_encoding not in ("cdr", "ros1"):
        raise RecordingError(
            f"{topic.name} is recorded as '{topic.message_encoding}'; only CDR is read"
        )
    store, typename = _types(topic)
    ros1 = topic.message_encoding == "ros1"
    deserialize = store.deserialize_ros1 if ros1 else store.deserialize_cdr
    return lambda data: deserialize(data, typename)


@lru_cache(maxsize=64)  # parsing a definition takes as long as reading thousands of messages
def _types(topic: Topic) -> tuple[Typestore, str]:
    """Return a store that knows the topic's type, and its name there."""
    package, slash, name = topic.typename.partition("/")  # in MCAP, ROS 1 writes package/Name
    if not slash:
        raise RecordingError(
            f"{topic.name} has the type '{topic.typename}', which names no package and so no type "
            "of ROS; record it again"
        )
    name = name.rpartition("/")[2]
    typename = f"{package}/msg/{name}"
    if topic.schema_encoding not in ("ros2msg", "ros1msg"):
        store = get_typestore(Stores.LATEST)
        if typename not in store.fielddefs:
            raise RecordingError(
                f"{topic.name} has no message definition in .msg form; record it again as MCAP"
            )
        return store, typename
    store = get_typestore(Stores.EMPTY)
    try:
        store.register(get_types_from_msg(topic.definition, typename))
        store.get_msgdef(typename)
    # KeyError: a type that it uses is not there
    except (TypesysError, KeyError, ValueError, AssertionError, RecursionError) as error:
        raise RecordingError(
            f"the definition of {topic.typename} in the bag is not understood: {_first_line(error)}"
        ) from error
    return store, typename


def samples(message: Any) -> SampleBlock:
    """Convert a ``ProbeSamples`` message; ValueError if the block is not sound."""
    return sound_block(
        SampleBlock(
            stamp=_stamp(message),
            sequence=message.sequence,
            sample_period=message.sample_period,
            position=message.position,
            force=message.force,
            command=message.command,
        )
    )


def site(message: Any) -> PalpationSite:
    """Convert a ``PalpationSite`` message; ValueError if it is not sound."""
    return PalpationSite(
        stamp=sound_stamp(_stamp(message)),
        site=message.site,
        position=sound_position(_point(message.position)),
        phase=Phase(message.phase),
        # Bags of earlier versions tell neither.
        leaving=Leaving(getattr(message, "leaving", Leaving.UNTOLD)),
        normal=sound_normal(_point(message.normal)) if hasattr(message, "normal") else UP,
    )


def stiffness_map(message: Any) -> RecordedMap:
    """Convert a ``StiffnessMap`` message."""
    shape = message.rows, message.columns
    return RecordedMap(
        stamp=_stamp(message),
        origin=_point(message.origin),
        spacing=message.spacing,
        stiffness=message.stiffness.reshape(shape),
        damping=message.damping.reshape(shape),
        covariance_trace=message.covariance_trace.reshape(shape),
        stiffness_stddev=message.stiffness_stddev.reshape(shape),
        verdict=message.verdict.reshape(shape) if hasattr(message, "verdict") else None,
        dwell_begin=message.dwell_begin.reshape(shape) if hasattr(message, "dwell_begin") else None,
    )


#: The name and the values of one estimate, in the order of the fields of ``TissueEstimates``.
EstimateRow: TypeAlias = tuple[str, tuple[float | str, ...]]


def estimate_row(message: Any) -> EstimateRow:
    """Convert a ``TissueEstimate`` message to the fields of ``TissueEstimates``, in their order.

    ValueError if its stamp or number is not sound.
    """
    if message.sequence > LAST_SEQUENCE:
        raise ValueError(f"sequence is {message.sequence}; samples are numbered up to 2^63 - 1")
    return message.estimator, (
        sound_stamp(_stamp(message)),
        message.sequence,
        message.stiffness,
        message.damping,
        message.covariance_trace,
        message.stiffness_variance,
        message.damping_variance,
        message.stiffness_damping_covariance,
        message.force_offset,
        message.predicted_force,
        message.innovation,
        message.normalized_innovation_squared,
        message.status,
        getattr(message, "model", ""),  # bags of earlier versions do not tell it
    )


def estimator_model(message: Any) -> EstimatorModel:
    """Convert an ``EstimatorModel`` message; ValueError if its stamp is not sound."""
    return EstimatorModel(
        stamp=sound_stamp(_stamp(message)),
        sequence=message.sequence,
        estimator=message.estimator,
        model=message.model,
        file=message.file,
        content=message.content,
        effects=tuple(message.effects),
    )


def estimates(rows: list[EstimateRow]) -> TissueEstimates:
    """Make ``TissueEstimates`` of the rows of one estimator, at least one."""
    columns = list(zip(*(values for _, values in rows), strict=True))
    numbers = [np.float64] * (len(columns) - 4)
    types: list[Any] = [np.int64, np.int64, *numbers, np.uint8, TEXT]
    arrays: list[Any] = [np.array(*each) for each in zip(columns, types, strict=True)]
    return TissueEstimates(rows[0][0], *arrays)


def _stamp(message: Any) -> int:
    stamp = message.header.stamp
    return int(stamp.sec * NANOSECONDS + stamp.nanosec)


def _point(message: Any) -> tuple[float, float, float]:
    return message.x, message.y, message.z
