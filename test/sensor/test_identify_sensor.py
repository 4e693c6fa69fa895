"""`tp.identify_sensor`, `tissue_probe sensor`: from tables and bags to a model for nodes."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest
import yaml
from free_air_world import World
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import tissue_probe as tp
from tissue_probe import cli
from tissue_probe.sensor.compensation import load_file
from tissue_probe.sensor.free_air import WRENCH_AXES
from tissue_probe.sensor.sensor_tracks import Track

COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw", *WRENCH_AXES)
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
    poses, wrenches, angles = air
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:

        def add(name, kind, track, fields):
            topic = writer.add_connection(name, kind, typestore=TYPES)
            for stamp, row in zip(track.stamps, track.rows, strict=True):
                message = of(kind)(header(stamp), *fields(row.tolist()))
                writer.write(topic, int(stamp), TYPES.serialize_cdr(message, kind))

        stamped = "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/WrenchStamped"
        add("/arm/pose", stamped[0], poses, lambda p: [pose(point(*p[:3]), turn(*p[3:]))])
        felt = of("geometry_msgs/msg/Wrench")
        add("/arm/wrench", stamped[1], wrenches, lambda w: [felt(vector(*w[:3]), vector(*w[3:]))])
        none = np.empty(0)
        joints = "sensor_msgs/msg/JointState"
        add("/joints", joints, angles, lambda a: [["j0", "j1", "j2"], np.array(a), none, none])
        if second:
            add("/arm/other", stamped[0], Track(poses.stamps[:0], poses.rows[:0]), list)


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


def test_a_table_without_rows_is_refused_in_a_sentence(air):
    empty = {name: values[:0] for name, values in table(air).items()}
    with pytest.raises(tp.TissueProbeError, match="table has columns, but no rows"):
        tp.identify_sensor(empty)


def test_a_topic_that_tells_nothing_of_use_is_named(air, tmp_path):
    poses, wrenches, angles = air
    nothing = Track(wrenches.stamps[:0], wrenches.rows[:0])
    bag(tmp_path / "empty", (poses, nothing, nothing))
    with pytest.raises(tp.TissueProbeError, match="on /arm/wrench there is no message"):
        tp.identify_sensor(tmp_path / "empty")
    bag(tmp_path / "run", (poses, wrenches, angles))
    with pytest.raises(tp.TissueProbeError, match="on /joints there is no message of elbow"):
        tp.identify_sensor(tmp_path / "run", joints=["elbow"])
    bag(tmp_path / "bare", (poses, wrenches, Track(angles.stamps, angles.rows[:, :1])))
    with pytest.raises(tp.TissueProbeError, match="/joints has a joint without a position"):
        tp.identify_sensor(tmp_path / "bare", joints=["j2"])


def test_the_model_is_read_back_as_it_was_written(air, tmp_path):
    result = tp.identify_sensor(table(air))
    result.save(tmp_path / "sensor.yaml")
    again = load_file(tmp_path / "sensor.yaml")
    np.testing.assert_allclose(again.load, result.model.load, rtol=1e-8)
    assert again.stamp == result.model.stamp
    assert again.text() == result.model.text()


@pytest.fixture(scope="module")
def cabled():
    poses, wrenches, angles, _ = World(cable=1.0).move(0.0, 30.0)
    return tp.identify_sensor(table((poses, wrenches, angles)), joints=["j0", "j1", "j2"])


def test_a_cable_is_in_the_file_too(cabled, tmp_path):
    cabled.save(tmp_path / "sensor.yaml")
    again = load_file(tmp_path / "sensor.yaml")
    assert again.cable.joints == 3
    np.testing.assert_allclose(again.weights, cabled.model.weights, rtol=1e-7, atol=1e-12)


@pytest.mark.parametrize("text", ["", "a: 1", "format: tissue_probe sensor 1\ncable: null", "["])
def test_a_file_that_is_no_model_is_refused(text, tmp_path):
    (tmp_path / "x.yaml").write_text(text)
    with pytest.raises(tp.TissueProbeError, match=r"x\.yaml:? .*"):
        load_file(tmp_path / "x.yaml")


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("stamp", ".inf", "stamp has not a whole number"),
        ("delay", ".nan", "delay has not a finite number"),
        ("delay", "1.0e+300", "delay is 1e[+]300 s: sensors have 0.1 s at most"),
        ("noise", "[0, 0, 0, 0, 0, 0]", "noise is not positive"),
        ("bias", "[1, 2]", r"bias has not the shape \(6,\) of finite numbers"),
        ("load", "[[1], [1, 2]]", r"load has not the shape \(10,\)"),
        ("joints", ".inf", "joints has not a whole number"),
        ("joints", "9", "the cable has 9 joints"),
        ("reach", "0.0", "a reach of 0 m"),
        ("place", "[.nan, 0, 0]", r"place has not the shape \(3,\)"),
        ("frame", "[1, 0, 0]", r"frame has not the shape \(3, 3\)"),
    ],
)
def test_a_damaged_number_of_a_model_is_named(cabled, name, value, sentence, tmp_path):
    content = yaml.safe_load(cabled.model.text())
    holder = content["cable"] if name in content["cable"] else content
    holder[name] = yaml.safe_load(value)
    path = tmp_path / "x.yaml"
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(tp.TissueProbeError, match=f"is damaged: .*{sentence}"):
        load_file(path)


def test_a_model_that_cannot_be_written_leaves_nothing_behind(cabled, tmp_path):
    (tmp_path / "sensor.yaml").mkdir()
    with pytest.raises(tp.TissueProbeError, match=r"sensor\.yaml"):
        cabled.save(tmp_path / "sensor.yaml")
    assert [each.name for each in tmp_path.iterdir()] == ["sensor.yaml"]


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
