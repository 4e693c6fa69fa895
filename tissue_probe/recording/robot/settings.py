"""A user's statements on a robot, with which its poses and its wrench become samples.

Contents: the parameters, which node and bag reader share, and their file.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, model_validator

from tissue_probe.bounded_yaml import YamlError, read
from tissue_probe.errors import check_file
from tissue_probe.recording.errors import RecordingError
from tissue_probe.settings import SettingsError, build, setting

#: Numbers in a list, from any kind of array that ROS has.
Numbers = Annotated[list[float], BeforeValidator(list)]
#: By how much the length of an axis or quaternion may differ from 1: that of written digits.
UNIT_ROUNDING = 1e-3


class RobotDescription(BaseModel):
    """Which topics, in which frames, and which way the robot presses."""

    position: str = setting(
        "/robot/measured_cp", "", "topic of the poses, or of the states of a joint"
    )
    joint: str = setting(
        "",
        "",
        "joint of a sensor_msgs/JointState whose travel is the position; empty: the topic has "
        "geometry_msgs/PoseStamped",
    )
    joint_travel: float = setting(
        1.0,
        "m",
        "travel into the tissue at one unit (m or rad) of the joint; negative where that goes out",
        ge=-1e3,
        le=1e3,
    )
    position_rate: float = setting(
        100.0, "Hz", "messages of the position a second", ge=10.0, le=4000.0
    )
    position_frame: str = setting(
        "", "", "frame_id of the poses; empty: that of the first one. Others are left out"
    )
    force: str = setting("/robot/measured_cf", "", "topic of the geometry_msgs/WrenchStamped")
    force_rate: float = setting(
        100.0, "Hz", "messages of the force a second; as many samples there are", ge=10.0, le=4000.0
    )
    force_frame: str = setting(
        "", "", "frame_id of the wrench; empty: that of the first one. Others are left out"
    )
    force_rotation: Numbers = setting(
        [0.0, 0.0, 0.0, 1.0],
        "",
        "quaternion x, y, z, w that turns the wrench's axes into those of force_axes",
    )
    force_axes: Literal["tool", "base"] = setting(
        "tool",
        "",
        "whose axes the wrench has, once turned by force_rotation: the pose's own (tool), or those "
        "of the frame in which poses are told (base)",
    )
    force_polarity: Literal["", "compression", "tension"] = setting(
        "",
        "",
        "which forces along the axis are positive: compression where the sensor tells the force "
        "that presses on the tissue, tension where it tells that of the tissue on the tool; to be "
        "stated",
    )
    axis: Numbers = setting(
        [0.0, 0.0, 1.0], "", "direction of pressing, into the tissue, x, y, z of axis_frame"
    )
    axis_frame: Literal["tool", "base"] = setting(
        "tool", "", "in which frame that direction is fixed: the pose's own (tool), or base"
    )
    zero: Numbers = setting(
        [],
        "m",
        "where the position is zero: x, y, z in base, or one value of the joint; empty: where the "
        "robot is when it is first heard",
    )
    fastest: float = setting(
        1.0, "m/s", "a faster move from message to message is a jump", gt=0.0, le=100.0
    )

    @model_validator(mode="after")
    def _go_together(self) -> RobotDescription:
        _check_length("axis", self.axis, 3)
        _check_length("force_rotation", self.force_rotation, 4)
        count = 1 if self.joint else 3
        if self.zero and not (len(self.zero) == count and all(map(math.isfinite, self.zero))):
            raise ValueError(f"zero is {self.zero}: give {count} finite numbers, or none")
        if self.joint and self.axis_frame != self.force_axes:
            raise ValueError(
                "a joint tells no orientation: give axis_frame and force_axes the same value"
            )
        if self.joint_travel == 0.0:
            raise ValueError("joint_travel is 0 m: give the way of the joint, not 0")
        return self


def _check_length(name: str, values: list[float], count: int) -> None:
    if len(values) != count or not abs(math.hypot(*values) - 1.0) <= UNIT_ROUNDING:
        raise ValueError(f"{name} is {values}: give {count} numbers whose squares add up to 1")


def read_settings(path: str | Path) -> RobotDescription:
    """Read the parameters of the node ``adapter`` from a ROS parameter file.

    Raises
    ------
    RecordingError
        If the file has no such parameters, or a wrong one; says which.
    OSError
        If the file cannot be read.
    """
    check_file(Path(path))
    try:
        content = read(path)
    except YamlError as error:
        raise RecordingError(f"{path} {error}") from None
    # Other parameters of the node (``frame_id``) mean nothing off line.
    values = {k: v for k, v in _of_adapter(content).items() if k in RobotDescription.model_fields}
    if not values:
        raise RecordingError(
            f"{path} has no parameters of the node adapter; give the file by which it is started"
        )
    try:
        return build(RobotDescription, values, f"{path}: ")
    except SettingsError as error:
        raise RecordingError(str(error)) from None


def _of_adapter(content: Any) -> dict[str, Any]:
    """Return the node's parameters in a ROS parameter file, in any namespace."""
    if not isinstance(content, dict):
        return {}
    for name, node in content.items():
        if str(name).rpartition("/")[2] == "adapter" and isinstance(node, dict):
            found = node.get("ros__parameters")
            return found if isinstance(found, dict) else {}
    return {}
