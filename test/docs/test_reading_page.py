"""Each source that the pages on reading name: its file is made, and its one command reads it."""

import re
import shlex
import sys
from pathlib import Path

import h5py
import numpy as np
import pyarrow
import pytest
from nptdms import ChannelObject, RootObject, TdmsWriter
from pyarrow import csv, parquet
from rosbags.rosbag1 import Writer as Rosbag1Writer
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from scipy.io import savemat

from benchmarks.written_tables import xlsx
from tissue_probe import cli

DOCS = Path(__file__).parents[2] / "docs"
ROWS = 400
TIME = np.arange(ROWS) * 2e-3
POSITION = 2e-3 + 1e-3 * np.sin(2.0 * np.pi * 5.0 * TIME)
FORCE = 400.0 * POSITION + 3.0 * 1e-3 * 2.0 * np.pi * 5.0 * np.cos(2.0 * np.pi * 5.0 * TIME)
MILLIMETRES = 1e3 * POSITION


def rows(mark, decimal, *columns):
    """Return lines of numbers."""
    return [
        mark.join(f"{value:.9f}".replace(".", decimal) for value in row)
        for row in zip(*columns, strict=True)
    ]


def text(name, *lines):
    Path(name).write_text("\n".join(lines) + "\n", encoding="utf-8")


def instron():
    quoted = [
        ",".join(f'"{cell}"' for cell in row.split(","))
        for row in rows(",", ".", TIME, MILLIMETRES, FORCE)
    ]
    text(
        "run.csv", '"Specimen","1"', "", '"Time","Extension","Load"', '"(s)","(mm)","(N)"', *quoted
    )


def zwick():
    lines = rows(";", ",", TIME, MILLIMETRES, FORCE)
    text(
        "run.txt",
        '"Prüfer";"Müller"',
        "",
        '"Prüfzeit";"Standardweg";"Standardkraft"',
        "s;mm;N",
        *lines,
    )


def mts():
    lines = rows("\t", ".", TIME, MILLIMETRES, FORCE)
    head = "Running Time\tAxial Displacement\tAxial Force"
    text("run.txt", "Data Header:\tTime:\t8.4\tSec", "", head, "Sec\tmm\tN", *lines)


def mach1():
    lines = rows("\t", ".", TIME, MILLIMETRES, FORCE)
    text(
        "run.txt",
        "<Mach-1 File>",
        "<DATA>",
        "Time, s\tPosition (z), mm\tFz, N",
        *lines,
        "<END DATA>",
    )


def lvm():
    head = ["LabVIEW Measurement\t", "Separator\tTab", "***End_of_Header***\t", ""]
    text(
        "run.lvm",
        *head,
        "X_Value\tStroke\tLoad\tComment",
        *rows("\t", ".", TIME, MILLIMETRES, FORCE),
    )


def tdms():
    with TdmsWriter("run.tdms") as file:
        waves = [("Stroke", MILLIMETRES, "mm"), ("Load", FORCE, "N")]
        channels = [
            ChannelObject("group", n, v, {"unit_string": unit, "wf_increment": 2e-3})
            for n, v, unit in waves
        ]
        file.write_segment([RootObject(), *channels])


def ddf():
    volts = rows("\t", ".", np.arange(ROWS), POSITION / 5e-4, FORCE / 0.1)
    head = ["Sample Frequency (Hz):\t10000", "Test Data in Volts:", "", "Sample\tAI0\tAI1"]
    text("run.ddf", *head, *volts)


def excel():
    def words(*cells):
        inside = "".join(f'<c t="inlineStr"><is><t>{cell}</t></is></c>' for cell in cells)
        return f"<row>{inside}</row>"

    def sheet():
        yield words("Operator", "Smith")
        yield words("Time", "Stroke", "Load")
        yield words("s", "mm", "N")
        for row in np.column_stack([TIME, MILLIMETRES, FORCE]).tolist():
            yield "<row>" + "".join(f"<c><v>{value!r}</v></c>" for value in row) + "</row>"

    xlsx(Path("run.xlsx"), {"one": sheet()})


def matlab(**variables):
    savemat("run.mat", variables)


def hdf5():
    with h5py.File("run.h5", "w") as file:
        file["run/1/t"], file["run/1/u"], file["run/1/F"] = TIME, MILLIMETRES, FORCE


def as_parquet():
    columns = {"t": TIME, "u_mm": MILLIMETRES, "Load [N]": FORCE}
    parquet.write_table(pyarrow.table(columns), "run.parquet")


def counted():
    counts = np.rint(POSITION / 8.333e-8).astype(np.int64).astype(np.int16)
    lines = [f"{t:.3f},{n},{f:.9f}" for t, n, f in zip(TIME, counts, FORCE, strict=True)]
    text("run.csv", "t,enc,F", *lines)


def jpk():
    lines = rows(" ", ".", FORCE, -POSITION, TIME)
    text("curve.txt", "# xPosition: 0.0", "# columns: vDeflection height seriesTime", "#", *lines)


def velocity():
    lines = rows(",", ".", TIME, np.gradient(MILLIMETRES, TIME), FORCE)
    text("run.csv", "t,v,F", *lines)


WRITERS = {
    "Instron": instron,
    "Zwick": zwick,
    "MTS": mts,
    "Mach-1": mach1,
    "LabVIEW, `.lvm`": lvm,
    "LabVIEW, DIAdem": tdms,
    "Aurora": ddf,
    "Excel": excel,
    "MATLAB, vectors": lambda: matlab(run={"t": TIME, "u": MILLIMETRES, "F": FORCE}),
    "MATLAB, one": lambda: matlab(data=np.column_stack([TIME, POSITION, FORCE])),
    "HDF5": hdf5,
    "Parquet": as_parquet,
    "a table without": lambda: text("run.csv", *rows(",", ".", TIME, POSITION, FORCE)),
    "an encoder": counted,
    "JPK": jpk,
    "a velocity": velocity,
}

STORE = get_typestore(Stores.ROS2_JAZZY)
ROS1 = get_typestore(Stores.ROS1_NOETIC)
EPOCH = 1_700_000_000_000_000_000
RATE, SECONDS = 500, 2.0


def u(t):
    return 2e-3 + 1e-3 * np.sin(2.0 * np.pi * 2.0 * t)


def f(t):
    return 400.0 * u(t) + 3.0 * 1e-3 * 2.0 * np.pi * 2.0 * np.cos(2.0 * np.pi * 2.0 * t)


class Messages:
    """Messages of one type store; ROS 1 numbers them besides."""

    def __init__(self, store, **numbered):
        self.types, self.numbered = store.types, numbered

    def header(self, stamp, frame):
        time = self.types["builtin_interfaces/msg/Time"](*divmod(int(stamp), 10**9))
        return self.types["std_msgs/msg/Header"](stamp=time, frame_id=frame, **self.numbered)

    def vector(self, x, y, z):
        return self.types["geometry_msgs/msg/Vector3"](float(x), float(y), float(z))

    def wrench(self, stamp, x, z, frame="tool"):
        both = self.types["geometry_msgs/msg/Wrench"](self.vector(x, 0, z), self.vector(0, 0, 0))
        return self.types["geometry_msgs/msg/WrenchStamped"](self.header(stamp, frame), both)

    def pose(self, stamp, z):
        place = self.types["geometry_msgs/msg/Pose"](
            self.types["geometry_msgs/msg/Point"](0.1, 0.2, float(z)),
            self.types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
        )
        return self.types["geometry_msgs/msg/PoseStamped"](self.header(stamp, "base"), place)

    def joints(self, stamp, value):
        names, values = ["lift", "slide"], np.array([7.0, float(value)])
        none = np.empty(0)
        return self.types["sensor_msgs/msg/JointState"](
            self.header(stamp, "base"), names, values, none, none
        )


def bag(make, writer=None, store=STORE, encode="serialize_cdr", **numbered):
    """Write what ``make`` returns for each time: (topic, message), all types of one store."""
    messages = Messages(store, **numbered)
    writer = writer or Writer(Path("run"), version=9, storage_plugin=StoragePlugin.MCAP)
    with writer:
        connections = {}
        for number in range(int(RATE * SECONDS)):
            stamp = EPOCH + number * 10**9 // RATE
            for topic, message in make(messages, stamp, number / RATE):
                if topic not in connections:
                    connections[topic] = writer.add_connection(
                        topic, message.__msgtype__, typestore=store
                    )
                data = getattr(store, encode)(message, message.__msgtype__)
                writer.write(connections[topic], stamp + 200_000, bytes(data))


def arm(messages, stamp, t):
    return [
        ("/tcp/pose", messages.pose(stamp, u(t))),
        ("/ft/wrench", messages.wrench(stamp, 0, f(t))),
    ]


def two_sensors(messages, stamp, t):
    return [
        *arm(messages, stamp, t)[:1],
        ("/ft/wrench", messages.wrench(stamp, 0, 0, "right_tool")),
        ("/ft/wrench", messages.wrench(stamp, 0, f(t), "left_tool")),
    ]


def unstamped(messages, stamp, t):
    force = messages.wrench(stamp, 0, f(t)).wrench
    return [("/tcp/pose", messages.pose(stamp, u(t))), ("/ft/wrench", force)]


BAGS = {
    "ROS 2": lambda: bag(arm),
    "ROS 1": lambda: bag(arm, Rosbag1Writer(Path("run.bag")), ROS1, "serialize_ros1", seq=0),
    "robot arm: height": lambda: bag(
        lambda m, s, t: [("/tcp/pose", m.pose(s, -u(t))), *arm(m, s, t)[1:]]
    ),
    "robot arm: a joint": lambda: bag(
        lambda m, s, t: [("/joint_states", m.joints(s, u(t))), *arm(m, s, t)[1:]]
    ),
    "force-torque": lambda: bag(
        lambda m, s, t: [*arm(m, s, t)[:1], ("/ft/wrench", m.wrench(s, f(t), 0))]
    ),
    "two sensors": lambda: bag(two_sensors),
    "sensor without": lambda: bag(unstamped),
}


def cells(page, source):
    """Return the commands of a source's row; `...` is what the first command of the page says."""
    text = (DOCS / page).read_text(encoding="utf-8")
    row = next(line for line in text.splitlines() if line.startswith(f"| {source}"))
    first = re.search(r"`(tissue_probe compare [^`]+)`", text)[1]
    return first, re.findall(r"`([^`]+)`", row.split(" | ", 1)[1])


def arguments(page, source):
    """Return the one command of a source."""
    first, found = cells(page, source)
    if source == "ROS 1":
        return shlex.split(first.replace(" run ", f" {found[0]} "))
    one = next(each for each in found if each.startswith(("tissue_probe compare", "...")))
    return shlex.split(one.replace("...", first))


@pytest.fixture
def exported(monkeypatch, tmp_path):
    """Run a command's options with ``export``, and return position [m] and force [N]."""
    monkeypatch.chdir(tmp_path)

    def exported(command):
        command = [each for each in command if each not in ("--rig", "rigid_probe")]
        assert command[1] == "compare"
        command[1] = "export"
        monkeypatch.setattr(sys, "argv", [*command, "--output", "exported.csv"])
        try:
            cli.main()
        except SystemExit as end:
            if end.code:
                pytest.fail(str(end.code))
        table = csv.read_csv("exported.csv")
        return (table[name].to_numpy() for name in ("position", "force"))

    return exported


@pytest.mark.parametrize("source", WRITERS)
def test_the_one_command_of_a_source_reads_its_file(source, exported, tmp_path):
    command = arguments("reading.md", source)
    WRITERS[source]()
    position, force = exported(command)
    loose = {"an encoder": 1e-7, "a velocity": 2e-5}.get(source, 1e-9)
    zero = loose > 1e-9  # a counter and a velocity have no zero of their own
    np.testing.assert_allclose(
        position - zero * position[0], POSITION - zero * POSITION[0], atol=loose
    )
    np.testing.assert_allclose(force, FORCE, atol=1e-6)


@pytest.mark.parametrize("source", BAGS)
def test_the_one_command_of_a_bag_s_source_reads_it(source, exported, tmp_path):
    command = arguments("reading_bags.md", source)
    BAGS[source]()
    position, force = exported(command)
    times = np.arange(int(RATE * SECONDS)) / RATE
    known = np.isfinite(position)
    assert np.count_nonzero(known) >= times.size - 2
    np.testing.assert_allclose(position[known], u(times)[known], atol=2e-6)
    np.testing.assert_allclose(force, f(times), atol=1e-9)


@pytest.mark.parametrize(("page", "there"), [("reading.md", WRITERS), ("reading_bags.md", BAGS)])
def test_every_source_of_the_pages_is_tried(page, there):
    """But the array of NumPy, which is as MATLAB's, and this suite's own, which all tests read."""
    text = (DOCS / page).read_text(encoding="utf-8")
    table = re.search(r"^\| source \|.*\n\|[-| ]+\n((?:\|.*\n)+)", text, re.M)[1]
    sources = [line.removeprefix("| ") for line in table.splitlines()]
    untried = [each for each in sources if not each.startswith(tuple(there))]
    assert [each.split(" |")[0] for each in untried] in (["NumPy, `.npz`, `.npy`"], ["this suite"])
