"""An arm on Eclipse Cyclone DDS alone that turns its flange in the air, with a tool on its sensor.

A word on standard input makes the tool push, or the sensor fail.
"""

import math
import os
import select
import sys
import time
from pathlib import Path

import numpy as np
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from foreign_messages import (
    Header,
    Point,
    Pose,
    PoseStamped,
    Quaternion,
    Time,
    Vector3,
    Wrench,
    WrenchStamped,
)

sys.path.append(str(Path(__file__).parents[1] / "sensor"))
from free_air_world import World

SECONDS = 120.0
#: Of the tool on the surface, along the sensor's z [N].
PUSH = 3.0
AN_HOUR = 3_600_000_000_000  # ns


def main() -> None:
    poses, wrenches, _, _ = World().move(0.0, SECONDS)
    participant = DomainParticipant(int(os.environ["DOMAIN"]))
    qos = Qos(Policy.Reliability.Reliable(1_000_000_000), Policy.History.KeepLast(500))

    def writer(name: str, kind: type) -> DataWriter:
        return DataWriter(participant, Topic(participant, f"rt/arm/{name}", kind), qos=qos)

    pose_writer, wrench_writer = writer("pose", PoseStamped), writer("wrench", WrenchStamped)
    word, begin, first = "", time.monotonic(), time.time_ns()
    passed = np.asarray(poses.stamps) - poses.stamps[0]
    for number, (p, w) in enumerate(zip(poses.rows, wrenches.rows, strict=True)):
        wait = begin + number / 250.0 - time.monotonic()
        if select.select([sys.stdin], [], [], max(wait, 0.0))[0]:
            words = os.read(sys.stdin.fileno(), 1000).decode().split()
            if not words:
                return
            word = "" if words[-1] == "well" else words[-1]
            time.sleep(max(begin + number / 250.0 - time.monotonic(), 0.0))
        now = first + int(passed[number]) - (AN_HOUR if word == "back" else 0)
        header = Header(Time(*divmod(now, 1_000_000_000)), "ft")
        place, turn = Point(*map(float, p[:3])), Quaternion(*map(float, p[3:]))
        pose_writer.write(PoseStamped(header, Pose(place, turn)))
        if word == "silent":
            continue
        force = Vector3(*map(float, w[:3]))
        force.z += PUSH if word == "push" else math.nan if word == "nan" else 0.0
        if word == "boot":
            header = Header(Time(*divmod(int(passed[number]), 1_000_000_000)), "ft")
        wrench_writer.write(WrenchStamped(header, Wrench(force, Vector3(*map(float, w[3:])))))


if __name__ == "__main__":
    main()
