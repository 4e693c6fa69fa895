"""A client of the probe on Eclipse Cyclone DDS alone: no rclpy, no generated ROS messages.

Prints what it received as JSON when a line comes in on standard input.
"""

import json
import os
import select
import sys
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, uint32
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Wrench(IdlStruct, typename="geometry_msgs::msg::dds_::Wrench_"):
    force: Vector3
    torque: Vector3


@dataclass
class WrenchStamped(IdlStruct, typename="geometry_msgs::msg::dds_::WrenchStamped_"):
    header: Header
    wrench: Wrench


@dataclass
class Float64(IdlStruct, typename="std_msgs::msg::dds_::Float64_"):
    data: float64


def main() -> None:
    participant = DomainParticipant(int(os.environ["DOMAIN"]))
    qos = Qos(Policy.Reliability.Reliable(1_000_000_000), Policy.History.KeepAll)

    def reader(name: str, kind: type) -> DataReader:
        return DataReader(participant, Topic(participant, name, kind), qos=qos)

    wrenches = reader("rt/probe/measured_cf", WrenchStamped)
    stiffness = reader("rt/probe/ekf/stiffness", Float64)
    received: dict[str, list] = {"stamps": [], "forces": [], "stiffness": []}

    def take() -> None:
        for message in wrenches.take(N=100_000):
            stamp = message.header.stamp
            received["stamps"].append(stamp.sec * 1_000_000_000 + stamp.nanosec)
            received["forces"].append(message.wrench.force.z)
        received["stiffness"].extend(message.data for message in stiffness.take(N=100_000))

    while not select.select([sys.stdin], [], [], 0.02)[0]:
        take()
    take()
    print(json.dumps(received))


if __name__ == "__main__":
    main()
