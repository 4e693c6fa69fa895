"""The messages that flow all the time, as the bytes that DDS carries.

Contents: messages that come 200 times a second and more. rclpy makes Python objects of each of a
message's parts, and asks each for its value again to send it, which takes longer than all that the
suite does with the values.

Plain CDR: little-endian numbers in the order of the message's definition, each aligned to its own
size, counted from behind a header of four bytes (OMG DDS-XTypes, section 7.4.1).
"""

from __future__ import annotations

import struct
from functools import lru_cache

import numpy as np

from tissue_probe.mapping.fusion import Estimate
from tissue_probe.nodes.conversions import ESTIMATE_VALUES
from tissue_probe.signals import (
    NANOSECONDS,
    FloatArray,
    SampleBlock,
    TissueEstimates,
    sound_block,
    sound_stamp,
)

LITTLE_ENDIAN = b"\x00\x01"
_HEADER = f"<{len(LITTLE_ENDIAN)}s2x"
_VALUES = struct.Struct(f"<{len(ESTIMATE_VALUES)}dB")
_FLOAT64 = struct.Struct(f"{_HEADER}d")


def float64_to_cdr(value: float) -> bytes:
    """Return a ``std_msgs/Float64``."""
    return _FLOAT64.pack(LITTLE_ENDIAN, value)


def pose_to_cdr(stamp: int, z: float, frame_id: str) -> bytes:
    """Return a ``geometry_msgs/PoseStamped`` at ``z`` [m], not turned; the stamp in ns."""
    return _single_to_cdr(stamp, frame_id, 0.0, 0.0, z, 0.0, 0.0, 0.0, 1.0)


def wrench_to_cdr(stamp: int, z: float, frame_id: str) -> bytes:
    """Return a ``geometry_msgs/WrenchStamped`` of the force ``z`` [N] alone; the stamp in ns."""
    return _single_to_cdr(stamp, frame_id, 0.0, 0.0, z, 0.0, 0.0, 0.0)


def samples_to_cdr(block: SampleBlock, frame_id: str) -> bytes:
    """Return a block of samples as a ``ProbeSamples``."""
    name, count = frame_id.encode(), len(block)
    seconds, nanoseconds = divmod(block.stamp, NANOSECONDS)
    return _samples_layout(len(name) + 1, count).pack(
        *(LITTLE_ENDIAN, seconds, nanoseconds, len(name) + 1, name),
        *(block.sequence, block.sample_period),
        *(count, _doubles(block.position)),
        *(count, _doubles(block.force)),
        *(count, _doubles(block.command)),
    )


def samples_from_cdr(data: bytes) -> tuple[SampleBlock, str]:
    """Return the block of samples in a ``ProbeSamples``, and its frame_id.

    Raises
    ------
    ValueError
        If the bytes are no little-endian CDR of a ``ProbeSamples``, its arrays differ in length, or
        the block is not sound (``sound_block``).
    """
    if data[:2] != LITTLE_ENDIAN:
        raise ValueError("the samples are not encoded as little-endian CDR")
    try:
        seconds, nanoseconds, length = struct.unpack_from("<iII", data, 4)
        frame_id = bytes(data[16 : 15 + length]).decode()
        offset = _aligned(16 + length)
        sequence, sample_period = struct.unpack_from("<Qd", data, offset)
        offset += 16
        arrays = []
        for _ in range(3):
            (count,) = struct.unpack_from("<I", data, offset)
            begin = _aligned(offset + 4) if count else offset + 4
            arrays.append(np.frombuffer(data, "<f8", count, begin))
            offset = begin + 8 * count
    except (struct.error, ValueError) as error:
        raise ValueError(f"the samples are cut off: {error}") from None
    stamp = seconds * NANOSECONDS + nanoseconds
    return sound_block(SampleBlock(stamp, sequence, sample_period, *arrays)), frame_id


def last_estimate_to_cdr(estimates: TissueEstimates, frame_id: str) -> bytes:
    """Return the newest of some estimates as a ``TissueEstimate``."""
    frame, name = frame_id.encode(), estimates.estimator.encode()
    model = estimates.model[-1].encode()
    seconds, nanoseconds = divmod(int(estimates.stamp[-1]), NANOSECONDS)
    return _estimate_layout(len(frame) + 1, len(name) + 1, len(model) + 1).pack(
        *(LITTLE_ENDIAN, seconds, nanoseconds, len(frame) + 1, frame),
        *(estimates.sequence[-1], len(name) + 1, name),
        *(getattr(estimates, value)[-1] for value in ESTIMATE_VALUES),
        *(estimates.status[-1], len(model) + 1, model),
    )


def estimate_from_cdr(data: bytes) -> tuple[str, int, Estimate, int]:
    """Return a ``TissueEstimate``: estimator, status, the estimate for a map, sample's number.

    Raises
    ------
    ValueError
        If the bytes are no little-endian CDR of a ``TissueEstimate``, or its stamp is not sound.
    """
    name, status, stamp, values = estimate_values_from_cdr(data)
    (length,) = struct.unpack_from("<I", data, 12)
    (sequence,) = struct.unpack_from("<Q", data, _aligned(16 + length))
    named = dict(zip(ESTIMATE_VALUES, values, strict=True))
    found = Estimate(stamp, *(named[each] for each in Estimate._fields[1:]))
    return name, status, found, sequence


def estimate_values_from_cdr(data: bytes) -> tuple[str, int, int, list[float]]:
    """Return the estimator of a ``TissueEstimate``, its status, its stamp, and ``ESTIMATE_VALUES``.

    Raises
    ------
    ValueError
        As ``estimate_from_cdr``.
    """
    if data[:2] != LITTLE_ENDIAN:
        raise ValueError("the estimate is not encoded as little-endian CDR")
    try:
        seconds, nanoseconds, length = struct.unpack_from("<iII", data, 4)
        offset = _aligned(16 + length) + 8
        (length,) = struct.unpack_from("<I", data, offset)
        name = bytes(data[offset + 4 : offset + 3 + length]).decode()
        *values, status = _VALUES.unpack_from(data, _aligned(offset + 4 + length))
    except (struct.error, ValueError) as error:
        raise ValueError(f"the estimate is cut off: {error}") from None
    return name, status, sound_stamp(seconds * NANOSECONDS + nanoseconds), values


def _single_to_cdr(stamp: int, frame_id: str, *values: float) -> bytes:
    name = frame_id.encode()
    return _single_layout(len(name) + 1, len(values)).pack(
        LITTLE_ENDIAN, *divmod(stamp, NANOSECONDS), len(name) + 1, name, *values
    )


@lru_cache
def _single_layout(frame_length: int, values: int) -> struct.Struct:
    return struct.Struct(_padded(f"{_HEADER}iII{frame_length}s") + f"{values}d")


@lru_cache
def _samples_layout(frame_length: int, count: int) -> struct.Struct:
    layout = _padded(f"{_HEADER}iII{frame_length}s") + "Qd"
    for _ in range(3):
        layout = _padded(f"{layout}I") + f"{8 * count}s"
    return struct.Struct(layout)


@lru_cache
def _estimate_layout(frame_length: int, name_length: int, model_length: int) -> struct.Struct:
    layout = _padded(f"{_HEADER}iII{frame_length}s") + f"QI{name_length}s"
    layout = _padded(layout) + f"{len(ESTIMATE_VALUES)}dB3xI{model_length}s"
    return struct.Struct(layout)


def _padded(layout: str) -> str:
    """Return a layout filled up to the next place of a double."""
    offset = struct.calcsize(layout)
    return f"{layout}{_aligned(offset) - offset}x"


def _aligned(offset: int) -> int:
    """Return the next place of a double."""
    return offset + (4 - offset) % 8


def _doubles(values: FloatArray) -> bytes:
    return np.asarray(values, "<f8").tobytes()
