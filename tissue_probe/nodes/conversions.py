"""Messages to and from the plain arrays that everything else works on.

Contents: rclpy's message objects.
"""

from __future__ import annotations

import array

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, PoseStamped, Vector3
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from tissue_probe.signals import (
    NANOSECONDS,
    TEXT,
    EstimatorModel,
    FloatArray,
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
from tissue_probe_msgs import msg


def to_time(stamp: int) -> Time:
    """Nanoseconds since the epoch as a ROS time."""
    return Time(sec=stamp // NANOSECONDS, nanosec=stamp % NANOSECONDS)


def from_time(time: Time) -> int:
    """Return a ROS time in nanoseconds since the epoch."""
    return int(time.sec * NANOSECONDS + time.nanosec)


def samples_to_message(block: SampleBlock, frame_id: str) -> msg.ProbeSamples:
    """Turn a block of samples into its message."""
    return msg.ProbeSamples(
        header=Header(stamp=to_time(block.stamp), frame_id=frame_id),
        sequence=block.sequence,
        sample_period=block.sample_period,
        position=_doubles(block.position),
        force=_doubles(block.force),
        command=_doubles(block.command),
    )


def samples_from_message(message: msg.ProbeSamples) -> SampleBlock:
    """Turn a message into a block of samples.

    Raises
    ------
    ValueError
        If the message's arrays differ in length, or the block is not sound (``sound_block``).
    """
    return sound_block(
        SampleBlock(
            stamp=from_time(message.header.stamp),
            sequence=message.sequence,
            sample_period=message.sample_period,
            position=np.frombuffer(message.position),
            force=np.frombuffer(message.force),
            command=np.frombuffer(message.command),
        )
    )


#: The fields that the message has and ``TissueEstimates`` has as arrays of the same name.
ESTIMATE_VALUES = (
    "stiffness",
    "damping",
    "covariance_trace",
    "stiffness_variance",
    "damping_variance",
    "stiffness_damping_covariance",
    "force_offset",
    "predicted_force",
    "innovation",
    "normalized_innovation_squared",
)


def estimate_from_message(message: msg.TissueEstimate) -> TissueEstimates:
    """Turn a message into estimates of one row."""
    return TissueEstimates(
        estimator=message.estimator,
        stamp=np.array([from_time(message.header.stamp)]),
        sequence=np.array([message.sequence], dtype=np.int64),
        status=np.array([message.status], dtype=np.uint8),
        model=np.array([message.model], dtype=TEXT),
        **{name: np.array([getattr(message, name)]) for name in ESTIMATE_VALUES},
    )


def model_to_message(model: EstimatorModel, frame_id: str) -> msg.EstimatorModel:
    """Turn the model by which an estimator goes on into its message."""
    return msg.EstimatorModel(
        header=Header(stamp=to_time(model.stamp), frame_id=frame_id),
        sequence=model.sequence,
        estimator=model.estimator,
        model=model.model,
        file=model.file,
        content=model.content,
        effects=list(model.effects),
    )


def site_to_message(site: PalpationSite, frame_id: str) -> msg.PalpationSite:
    """Turn an announcement into its message."""
    x, y, z = site.position
    return msg.PalpationSite(
        header=Header(stamp=to_time(site.stamp), frame_id=frame_id),
        site=site.site,
        position=Point(x=x, y=y, z=z),
        normal=Vector3(**dict(zip("xyz", site.normal, strict=True))),
        phase=int(site.phase),
        leaving=int(site.leaving),
    )


def site_from_message(message: msg.PalpationSite) -> PalpationSite:
    """Turn a message into an announcement.

    Raises
    ------
    ValueError
        If phase or leaving is none of the message's constants, or stamp or position are not sound.
    """
    return PalpationSite(
        stamp=sound_stamp(from_time(message.header.stamp)),
        site=message.site,
        position=sound_position(_xyz(message.position)),
        phase=Phase(message.phase),
        leaving=Leaving(message.leaving),
        normal=sound_normal(_xyz(message.normal)),
    )


def place_from_message(message: PoseStamped) -> tuple[float, float, float]:
    """Return where a stage or robot says that it is, or is told to go: (x, y, z) [m].

    Raises
    ------
    ValueError
        If the position is not sound (``sound_position``), or the orientation not finite.
    """
    turned = message.pose.orientation
    if not np.isfinite([turned.x, turned.y, turned.z, turned.w]).all():
        raise ValueError("its orientation is not finite")
    return sound_position(_xyz(message.pose.position))


def _xyz(point: Point | Vector3) -> tuple[float, float, float]:
    return point.x, point.y, point.z


def cloud_message(header: Header, points: FloatArray, names: list[str]) -> PointCloud2:
    """Turn points, shape (n, fields), into a cloud whose fields are ``names``, as float32."""
    data = np.ascontiguousarray(points, dtype=np.float32)
    return PointCloud2(
        header=header,
        height=1,
        width=len(data),
        fields=[
            PointField(name=name, offset=4 * i, datatype=PointField.FLOAT32, count=1)
            for i, name in enumerate(names)
        ],
        is_bigendian=False,
        point_step=4 * len(names),
        row_step=4 * data.size,
        data=array.array("B", data.tobytes()),
        is_dense=False,
    )


def _doubles(values: FloatArray) -> array.array[float]:
    """Return an array that rclpy takes over without looking at each value."""
    return array.array("d", values.tobytes())
