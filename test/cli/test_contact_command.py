"""``tissue_probe contact``, ``admittance``, ``mujoco``: from a recording to files for use."""

from __future__ import annotations

import json

import numpy as np
import pytest
import yaml
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

TIME = np.arange(500) / 250.0
PHASE = 2.0 * np.pi * 2.5 * TIME + 3.0 * np.sin(np.pi * TIME)
DEPTH = 2e-3 + 1e-3 * np.sin(PHASE)
FORCE = 1000.0 * DEPTH + 3.0 * np.gradient(DEPTH, TIME)
FORCE = FORCE + np.random.default_rng(0).normal(0.0, 0.02, TIME.size)
KNOWN = ("--force-polarity", "compression", "--delay", "0+-1e-5", "--constant", "tip_mass=0")
ADAPTER = """
/probe/adapter:
  ros__parameters:
    position: /arm/Pose
    force: /arm/Wrench
    position_rate: 250.0
    force_rate: 250.0
    force_polarity: tension
    zero: [0.3, 0.1, 0.5]
"""
GAINS = ("--mass", 2, "--stiffness", 50, "--delay", 0.01)


@pytest.fixture
def recorded(tmp_path):
    rows = np.stack([TIME, DEPTH, FORCE], axis=1)
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", header="t,position,force", comments="")


@pytest.mark.usefixtures("recorded")
def test_a_recording_becomes_a_contact_and_gains(run, tmp_path):
    outcome = run("contact", "run.csv", *KNOWN, "--json", "contact.json")
    assert outcome.status == 0, outcome.err
    assert "adequate" in outcome.out
    told = json.loads((tmp_path / "contact.json").read_text())
    stiffness = told["values"]["stiffness"]
    assert abs(stiffness["value"] - 1000.0) < 3.0 * stiffness["deviation"]
    assert told["told"] == ["stiffness", "damping"]
    assert run("admittance", "contact.yaml", *GAINS, "--axis", "y").status == 0
    gains = yaml.safe_load((tmp_path / "admittance.yaml").read_text())
    axes = gains["admittance_controller"]["ros__parameters"]["admittance"]["selected_axes"]
    assert axes == [False, True, False, False, False, False]


def test_a_robots_bag_is_read_as_its_adapter_hears_it(run, tmp_path):
    types = get_typestore(Stores.ROS2_JAZZY)

    def of(name):
        return types.types[name]

    with Writer(tmp_path / "run", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        kinds = {name: f"geometry_msgs/msg/{name}Stamped" for name in ("Pose", "Wrench")}
        topics = {
            name: writer.add_connection(f"/arm/{name}", kind, typestore=types)
            for name, kind in kinds.items()
        }
        vector, turn = of("geometry_msgs/msg/Vector3"), of("geometry_msgs/msg/Quaternion")
        point, none = of("geometry_msgs/msg/Point"), vector(0.0, 0.0, 0.0)
        for time, depth, force in zip(TIME, DEPTH, FORCE, strict=True):
            stamp = round(time * 1e9) + 1_700_000_000_000_000_000
            at = of("builtin_interfaces/msg/Time")(*divmod(stamp, 10**9))
            # Pressed downwards, by a tool that points down: its x axis is turned by half a turn.
            place = point(0.3, 0.1, 0.5 - float(depth)), turn(1.0, 0.0, 0.0, 0.0)
            felt = vector(0.0, 0.0, 7.0 - float(force)), none
            for name, parts in (("Pose", place), ("Wrench", felt)):
                content = of(f"geometry_msgs/msg/{name}")(*parts)
                message = of(kinds[name])(of("std_msgs/msg/Header")(at, "tool"), content)
                writer.write(topics[name], stamp, types.serialize_cdr(message, kinds[name]))
    (tmp_path / "robot.yaml").write_text(ADAPTER)
    outcome = run("contact", "run", "--adapter", "robot.yaml", *KNOWN[2:], "--json", "contact.json")
    assert outcome.status == 0, outcome.err
    stiffness = json.loads((tmp_path / "contact.json").read_text())["values"]["stiffness"]
    assert abs(stiffness["value"] - 1000.0) < 3.0 * stiffness["deviation"]


@pytest.mark.usefixtures("recorded")
def test_a_contact_goes_into_a_model_of_mujoco(run, tmp_path):
    pytest.importorskip("mujoco", reason="mujoco is not installed: pip install mujoco")
    from benchmarks.live_loop import simulated

    (tmp_path / "scene.xml").write_text(simulated.slider())
    assert run("contact", "run.csv", *KNOWN).status == 0
    names = ("--model", "scene.xml", "--tip", "tip", "--tissue", "tissue")
    outcome = run("mujoco", "contact.yaml", *names)
    assert outcome.status == 0, outcome.err
    assert '<include file="contact.xml"/>' in outcome.out
    assert "<pair " in (tmp_path / "contact.xml").read_text()
    assert "--tip finger" in run("mujoco", "contact.yaml", *names[:3], "finger", *names[4:]).err


@pytest.mark.usefixtures("recorded")
@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--delay", "soon"), "--delay soon: give VALUE+-SD, such as 0.004+-0.0001"),
        (("--delay", "0.1"), "--delay is 0.1 s"),
        (("--constant", "mass=1"), "--constant mass: mass is no constant of rigid_probe"),
        (("--sensor", "run.csv"), "run.csv"),
        (("--sensor", "none.yaml"), "none.yaml: No such file"),
    ],
)
def test_a_wrong_statement_ends_in_a_sentence(run, arguments, sentence):
    outcome = run("contact", "run.csv", "--force-polarity", "compression", *arguments)
    assert outcome.status == 1
    assert sentence in outcome.err
    assert "Traceback" not in outcome.err


def test_a_file_that_is_no_contact_is_refused(run, tmp_path):
    (tmp_path / "other.yaml").write_text("format: other")
    outcome = run("admittance", "other.yaml", *GAINS)
    assert outcome.status == 1
    assert "other.yaml: it is no contact" in outcome.err
