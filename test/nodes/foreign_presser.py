"""A robot on Eclipse Cyclone DDS alone that presses on a spring with a damper, and feels the force.

Its tool is held turned, its force sensor is mounted turned in that; each topic has a rate and
jitter of its own, and stamps of when it was measured. A word on standard input makes it fail.
"""

import math
import os
import random
import select
import sys
import time

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

STIFFNESS, DAMPING = 600.0, 3.0  # N/m, N s/m
POSE_RATE, WRENCH_RATE = 250.0, 500.0  # Hz
JITTER = 0.3  # of a period, either way
FORCE_NOISE, POSITION_NOISE = 5e-3, 1e-7  # N, m
FREQUENCY = 5.0  # Hz
JUMP = 0.05  # m
BACK = 2_000_000_000  # ns: whole periods
TOUCH = (0.4, -0.1, 0.3)  # m
#: Half a turn about x, and somewhat more: the tool's z is INTO, in the base.
TOOL = (math.sin(1.4), 0.0, 0.0, math.cos(1.4))
INTO = (0.0, -math.sin(2.8), math.cos(2.8))
#: The sensor is turned by this about the tool's z [rad], and looks back.
MOUNTED = 0.5
#: That is: a point of the tool is the sensor's, mirrored by half a turn about x, then turned.
ROTATION = (math.cos(MOUNTED / 2.0), math.sin(MOUNTED / 2.0), 0.0, 0.0)


def pressed(stamp):
    """Displacement into the spring at a time, or times [ns], in m, and its rate."""
    omega = 2.0 * math.pi * FREQUENCY
    phase = omega * (stamp % 1_000_000_000_000) * 1e-9  # of whole periods, and few digits
    return 1.5e-3 + 1e-3 * np.sin(phase), 1e-3 * omega * np.cos(phase)


class Presser:
    """Two topics, each due at times of its own."""

    def __init__(self) -> None:
        participant = DomainParticipant(int(os.environ["DOMAIN"]))
        reliable = Qos(Policy.Reliability.Reliable(1_000_000_000), Policy.History.KeepLast(500))
        qos = Qos(Policy.Reliability.BestEffort) if "BEST_EFFORT" in os.environ else reliable

        def writer(name: str, kind: type) -> DataWriter:
            return DataWriter(participant, Topic(participant, f"rt/robot/{name}", kind), qos=qos)

        self.poses = writer("measured_cp", PoseStamped)
        self.wrenches = writer("measured_cf", WrenchStamped)
        self.fault = ""
        self.begin = time.monotonic()
        self.due = {self.tell_pose: 0.0, self.tell_wrench: 0.0}
        self.rates = {self.tell_pose: POSE_RATE, self.tell_wrench: WRENCH_RATE}
        self.count = dict.fromkeys(self.due, 0)

    def header(self, frame: str) -> Header:
        back = BACK if self.fault == "back" else 0
        return Header(Time(*divmod(self.now - back, 1_000_000_000)), frame)

    def tell_pose(self) -> None:
        u = float(pressed(self.now)[0]) + random.gauss(0.0, POSITION_NOISE)
        u += JUMP if self.fault == "jump" else 0.0
        place = [touch + u * into for touch, into in zip(TOUCH, INTO, strict=True)]
        self.poses.write(PoseStamped(self.header("base"), Pose(Point(*place), Quaternion(*TOOL))))

    def tell_wrench(self) -> None:
        if self.fault == "silent":
            return
        u, speed = map(float, pressed(self.now))
        force = STIFFNESS * u + DAMPING * speed + random.gauss(0.0, FORCE_NOISE)
        # The tissue pushes the tool back, along its -z; the sensor looks back, so that is its z.
        felt = Vector3(0.0, 0.0, math.nan if self.fault == "nan" else force)
        frame = "other" if self.fault == "frame" else "ft"
        zero = Vector3(0.0, 0.0, 0.0)
        self.wrenches.write(WrenchStamped(self.header(frame), Wrench(felt, zero)))

    def step(self) -> float:
        """Tell what is due; return how long nothing will be [s]."""
        passed = time.monotonic() - self.begin
        for tell, due in self.due.items():
            if due <= passed:
                self.now = time.time_ns()
                tell()
                period = 1.0 / self.rates[tell]
                self.count[tell] = max(self.count[tell] + 1, int(passed / period))
                self.due[tell] = period * (self.count[tell] + random.uniform(-JITTER, JITTER))
        return max(min(self.due.values()) - (time.monotonic() - self.begin), 0.0)


def main() -> None:
    robot = Presser()
    wait = 0.0
    while True:
        if select.select([sys.stdin], [], [], wait)[0]:
            words = os.read(sys.stdin.fileno(), 1000).decode().split()
            if not words:
                return
            robot.fault = "" if words[-1] == "well" else words[-1]
        wait = robot.step()


if __name__ == "__main__":
    main()
