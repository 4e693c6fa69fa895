"""`tp.identify_sensor`, `tissue_probe sensor`: from tables and bags to a model for nodes."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest
from free_air_world import World
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import tissue_probe as tp
from tissue_probe import cli
from tissue_probe.sensor.compensation import load_file
from tissue_probe.sensor.free_air import AXES

COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw", *AXES)
TYPES = get_typestore(Stores.ROS2_JAZZY)


@pytest.fixture(scope="module")
def air():
    poses, wrenches, angles, _ = World().move(0.0, 30.0)
    return poses, wrenches, angles


def table(air) -> dict[str, np.ndarray]:
    poses, wrenches, angles = air
    rows = np.hstack([poses.rows, wrenches.rows])
    found = {"t": (poses.stamps - poses.stamps[0]) / 1e9}
    found |= dict(zip(COLUMNS, rows.T, strict=True))
    return found | {f"j{number}": each for number, each in enumerate(angles.rows.T)}


def csv(path, columns) -> None:
    np.savetxt(
        path, np.stack(list(columns.values()), axis=1), delimiter=",", header=",".join(columns),
        comments="",
    )  # fmt: skip


def bag(path, air, second=False) -> None:
    def of(name):
        return TYPES.types[name]

    def header(stamp):
        time = of("builtin_interfaces/msg/Time")(*divmod(int(stamp), 10**9))
        return of("std_msgs/msg/Header")(time, "ft")

    vector, point = of("geometry_msgs/msg/Vector3"), of("geometry_msgs/msg/Point")
    turn, pose = of("geometry_msgs/msg/Quaternion"), of("geometry_msgs/msg/Pose")
    poses, wrenches, _ = air
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        names = {"/arm/pose": "PoseStamped", "/arm/wrench": "WrenchStamped"}
        names |= {"/arm/other": "PoseStamped"} if second else {}
        topics = {
            name: writer.add_connection(name, f"geometry_msgs/msg/{kind}", typestore=TYPES)
            for name, kind in names.items()
        }
        for stamp, p, w in zip(poses.stamps, poses.rows, wrenches.rows, strict=True):
            told = pose(point(*map(float, p[:3])), turn(*map(float, p[3:])))
            felt = of("geometry_msgs/msg/Wrench")(
                vector(*map(float, w[:3])), vector(*map(float, w[3:]))
            )
            for name, kind, value in (
                ("/arm/pose", "PoseStamped", told),
                ("/arm/wrench", "WrenchStamped", felt),
            ):
                kind = f"geometry_msgs/msg/{kind}"
                message = of(kind)(header(stamp), value)
                writer.write(topics[name], int(stamp), TYPES.serialize_cdr(message, kind))


def test_a_table_in_memory_and_a_bag_give_the_same_answer(air, tmp_path):
    bag(tmp_path / "run", air)
    of_bag, of_table = tp.identify_sensor(tmp_path / "run"), tp.identify_sensor(table(air))
    assert of_table.verdict == "adequate"
    assert of_table.found.number("mass").value == pytest.approx(0.8, rel=2e-3)
    for one, other in zip(of_bag.found.numbers, of_table.found.numbers, strict=True):
        assert one.value == pytest.approx(other.value, abs=1e-3 * one.deviation)


def test_of_several_topics_one_has_to_be_named(air, tmp_path):
    bag(tmp_path / "run", air, second=True)
    with pytest.raises(tp.TissueProbeError, match=r"2 topics of PoseStamped .* state `pose`"):
        tp.identify_sensor(tmp_path / "run")
    assert tp.identify_sensor(tmp_path / "run", pose="/arm/pose").verdict == "adequate"


def test_the_model_is_read_back_as_it_was_written(air, tmp_path):
    result = tp.identify_sensor(table(air))
    result.save(tmp_path / "sensor.yaml")
    again = load_file(tmp_path / "sensor.yaml")
    np.testing.assert_allclose(again.load, result.model.load, rtol=1e-8)
    assert again.stamp == result.model.stamp
    assert again.text() == result.model.text()


def test_a_cable_is_in_the_file_too(tmp_path):
    poses, wrenches, angles, _ = World(cable=1.0).move(0.0, 30.0)
    result = tp.identify_sensor(table((poses, wrenches, angles)), joints=["j0", "j1", "j2"])
    result.save(tmp_path / "sensor.yaml")
    again = load_file(tmp_path / "sensor.yaml")
    assert again.cable.joints == 3
    np.testing.assert_allclose(again.weights, result.model.weights, rtol=1e-7, atol=1e-12)


@pytest.mark.parametrize("text", ["", "a: 1", "format: tissue_probe sensor 1\ncable: null", "["])
def test_a_file_that_is_no_model_is_refused(text, tmp_path):
    (tmp_path / "x.yaml").write_text(text)
    with pytest.raises(tp.TissueProbeError, match=r"x\.yaml: .*"):
        load_file(tmp_path / "x.yaml")


def run(monkeypatch, capsys, *arguments) -> tuple[str, object]:
    monkeypatch.setattr(sys, "argv", ["tissue_probe", *map(str, arguments)])
    status: object = 0
    try:
        cli.main()
    except SystemExit as error:
        status = error.code
    return capsys.readouterr().out, status


def test_the_command_tells_writes_the_model_and_the_answer(air, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    csv("air.csv", table(air))
    out, status = run(monkeypatch, capsys, "sensor", "air.csv", "--json", "answer.json")
    assert not status
    assert "adequate" in out
    assert "common gain of the forces and the mass are one function" in out
    answer = json.loads((tmp_path / "answer.json").read_text())
    assert answer["verdict"] == "adequate"
    mass = answer["numbers"]["mass"]
    assert abs(mass["value"] - 0.8) < 4.0 * mass["deviation"]
    assert load_file("sensor.yaml").load[0] == pytest.approx(mass["value"])


def test_a_table_without_a_column_is_refused_in_a_sentence(air, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    columns = table(air)
    del columns["qw"]
    csv("air.csv", columns)
    _, status = run(monkeypatch, capsys, "sensor", "air.csv")
    assert "qw" in str(status)


def test_units_stand_in_the_columns_names(air):
    columns = table(air)
    columns |= {f"{name}_mm": 1e3 * columns.pop(name) for name in "xyz"}
    assert tp.identify_sensor(columns).verdict == "adequate"
