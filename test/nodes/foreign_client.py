"""A client of the probe on Eclipse Cyclone DDS alone: no rclpy, no generated ROS messages.

Prints what it received as JSON when a line comes in on standard input.
"""

import json
import os
import select
import sys

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from foreign_messages import Float64, WrenchStamped


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
