"""A surgical robot on Eclipse Cyclone DDS alone, speaking CRTK: no rclpy, no generated messages.

It holds its tool turned, moves at limited speed to where ``servo_cp`` says, follows CRTK's states,
and prints what it was told as JSON when a line comes in on standard input.
"""

import json
import math
import os
import select
import sys
import time

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from foreign_messages import (
    Header,
    OperatingState,
    PalpationSite,
    Point,
    Pose,
    PoseStamped,
    Quaternion,
    StringStamped,
    Time,
)

PERIOD = 0.01  # s
SPEED = 0.05  # m/s
#: Along x it comes no farther [m].
REACH = float(os.environ.get("REACH", "inf"))
#: Whether its poses are published as sensors' data often are.
BEST_EFFORT = "BEST_EFFORT" in os.environ
TURNED = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))


def taken(reader: DataReader, kind: type) -> list:
    """Take what was said; that a writer has left comes as a sample of another kind."""
    return [sample for sample in reader.take(N=100) if isinstance(sample, kind)]


class Robot:
    """Its two topics out, its two in; it hears what the scan announces, too."""

    def __init__(self) -> None:
        participant = DomainParticipant(int(os.environ["DOMAIN"]))
        reliable = Policy.Reliability.Reliable(1_000_000_000)
        volatile = Qos(reliable, Policy.History.KeepLast(100))
        latched = Qos(reliable, Policy.Durability.TransientLocal, Policy.History.KeepLast(1))

        def topic(name: str, kind: type) -> Topic:
            return Topic(participant, f"rt/dvrk/PSM1/{name}", kind)

        offered = Qos(Policy.Reliability.BestEffort) if BEST_EFFORT else volatile
        self.poses = DataWriter(participant, topic("measured_cp", PoseStamped), qos=offered)
        self.states = DataWriter(participant, topic("operating_state", OperatingState), qos=latched)
        self.setpoints = DataReader(participant, topic("servo_cp", PoseStamped), qos=volatile)
        self.commands = DataReader(participant, topic("state_command", StringStamped), qos=volatile)
        announced = Topic(participant, "rt/probe/palpation_site", PalpationSite)
        self.sites = DataReader(participant, announced, qos=volatile)
        self.position = [0.0, 0.0, 0.01]
        self.goal = list(self.position)
        self.state = "DISABLED"
        self.told = {"setpoints": 0, "commands": [], "turned": 0, "stamps": [], "depth": []}
        self.told["phases"] = []
        self.tell_state()

    def header(self) -> Header:
        return Header(Time(*divmod(time.time_ns(), 1_000_000_000)), "PSM1_base")

    def tell_state(self) -> None:
        self.states.write(OperatingState(self.header(), self.state, True, False))

    def step(self) -> None:
        for command in taken(self.commands, StringStamped):
            self.told["commands"].append(command.string)
            self.state = {"enable": "ENABLED", "disable": "DISABLED"}[command.string]
            self.tell_state()
        self.told["phases"] += [site.phase for site in taken(self.sites, PalpationSite)]
        for setpoint in taken(self.setpoints, PoseStamped):
            self.follow(setpoint)
        way = [goal - now for goal, now in zip(self.goal, self.position, strict=True)]
        distance = math.sqrt(sum(each * each for each in way))
        part = min(1.0, SPEED * PERIOD / distance) if distance else 0.0
        self.position = [now + part * each for now, each in zip(self.position, way, strict=True)]
        pose = Pose(Point(*self.position), Quaternion(*TURNED))
        self.poses.write(PoseStamped(self.header(), pose))

    def follow(self, setpoint: PoseStamped) -> None:
        stamp, pose = setpoint.header.stamp, setpoint.pose
        turn = (pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w)
        self.told["setpoints"] += 1
        self.told["turned"] += turn != TURNED
        self.told["stamps"].append(stamp.sec * 1_000_000_000 + stamp.nanosec)
        self.told["depth"].append(pose.position.z)
        if self.state == "ENABLED":
            self.goal = [min(pose.position.x, REACH), pose.position.y, pose.position.z]


def main() -> None:
    robot = Robot()
    while not select.select([sys.stdin], [], [], PERIOD)[0]:
        robot.step()
    print(json.dumps(robot.told))


if __name__ == "__main__":
    main()
