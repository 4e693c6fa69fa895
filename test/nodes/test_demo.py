"""The demo, end to end: every node a process, one command, the nodules in the right places."""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from conftest import PATIENCE
from tissue_probe.analysis.recorded_facts import gather_sites
from tissue_probe.estimation import ESTIMATORS
from tissue_probe.recording.bags.open_bag import open_bag
from tissue_probe.recording.bags.reader import read_estimates, read_map, read_recording
from tissue_probe.recording.bags.summary import summarize
from tissue_probe.recording.bags.topic_field import read_field
from tissue_probe.recording.errors import RecordingError

PNG = b"\x89PNG\r\n\x1a\n"
EXECUTABLES = Path(sys.prefix, "lib", "tissue_probe")
PROGRAM = EXECUTABLES / "tissue_probe"
CONFIG = Path(__file__).parents[2] / "config"
FOXGLOVE, PLOTJUGGLER = CONFIG / "foxglove_layout.json", CONFIG / "plotjuggler.xml"


def hears_ctrl_c() -> None:
    """Let a process hear Ctrl-C where these tests, run in the background of a shell, do not."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.fixture
def demo(tmp_path):
    """Start the demo; it is ended with the test, in order if it listens."""
    started = []

    def start(*arguments: str) -> subprocess.Popen:
        started.append(
            subprocess.Popen(
                [PROGRAM, "demo", "--folder", str(tmp_path), *arguments],
                cwd="/",
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                preexec_fn=hears_ctrl_c,
            )
        )
        return started[-1]

    yield start
    for each in started:
        each.send_signal(signal.SIGINT)
        try:
            each.communicate(timeout=PATIENCE)
        finally:
            each.kill()


def shown_by_viewers() -> tuple[list[str], list[str]]:
    """Return the curves (``/topic.field``) of Foxglove and PlotJuggler, and other topics shown."""
    panels = json.loads(FOXGLOVE.read_text())["configById"]
    curves = [path["value"] for panel in panels.values() for path in panel.get("paths", [])]
    names = [each.get("name") for each in ElementTree.parse(PLOTJUGGLER).iter("curve")]
    curves += [".".join(name.rsplit("/", 1)) for name in names]
    whole = [*panels["3D!map"]["topics"], panels["RawMessages!map"]["topicPath"]]
    return curves, [*whole, panels["DiagnosticSummary!health"]["topicToRender"]]


@pytest.mark.crowded
@pytest.mark.slow
def test_the_demo_finds_every_nodule_and_leaves_recording_and_pictures(demo, tmp_path):
    running = demo("--dwell-time", "0.2")
    printed, said = running.communicate(timeout=150)
    assert running.returncode == 0, said
    assert "3 of 3 nodules found, 0 inclusions where there is no nodule" in printed
    assert "25 of 25 sites measured" in printed
    for picture in ("map.png", "estimates.png"):
        content = (tmp_path / picture).read_bytes()
        assert content.startswith(PNG)
        assert len(content) > 50_000
    bag = tmp_path / "run.mcap"
    summary = summarize(bag)
    assert not summary.truncated
    assert [samples.lost for samples in summary.samples] == [0]
    assert len(summary.sites) == 25
    live = read_map(bag)
    # The map that was published live: the background, and a nodule right under a site.
    assert live.stiffness[0, 0] == pytest.approx(450.0, rel=0.02)
    assert live.stiffness[3, 1] > 2.5 * 450.0
    off_line = gather_sites(read_recording(bag), list(read_estimates(bag).values())).map()
    assert live.stamp == off_line.stamp
    for layer in ("stiffness", "damping", "covariance_trace", "stiffness_stddev", "verdict"):
        assert_array_equal(getattr(live, layer), getattr(off_line, layer))
    # The viewers' layouts show it all, the suite's own filter among them.
    curves, topics = shown_by_viewers()
    assert any("robust_ekf" in curve for curve in curves)
    recorded = open_bag(bag)
    for curve in curves:
        assert np.isfinite(read_field(recorded, bag, curve, {}).values).any(), curve
    assert set(topics) <= {topic.name for topic in recorded.topics}


def is_recording(running: subprocess.Popen, bag: Path) -> None:
    """Wait until two thousand samples of the demo are stored."""
    deadline = time.monotonic() + PATIENCE
    while recorded_samples(bag) < 2000:
        assert time.monotonic() < deadline, "nothing is recorded"
        assert running.poll() is None, running.communicate()[1]
        time.sleep(0.1)


@pytest.mark.crowded
def test_ctrl_c_in_the_demo_ends_every_process_and_keeps_the_recording(demo, domain, tmp_path):
    running, bag = demo(), tmp_path / "run.mcap"
    is_recording(running, bag)
    assert len(processes_in(domain)) == 7  # the demo, and six nodes
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=PATIENCE)
    assert "Traceback" not in said
    assert running.returncode == 0, said  # what was palpated until then is drawn
    assert processes_in(domain) == []
    assert recorded_samples(bag) >= 2000
    assert not summarize(bag).truncated


@pytest.mark.crowded
@pytest.mark.parametrize(
    ("signals", "status"),
    [((signal.SIGINT,) * 3, None), ((signal.SIGTERM,), 128 + signal.SIGTERM)],
    ids=["Ctrl-C thrice", "SIGTERM"],
)
def test_no_process_is_left_behind_however_the_demo_is_ended(
    demo, domain, tmp_path, signals, status
):
    running, bag = demo(), tmp_path / "run.mcap"
    is_recording(running, bag)
    for number in signals:
        running.send_signal(number)
        time.sleep(0.1)  # as fast as a hand is
    _, said = running.communicate(timeout=PATIENCE)
    assert status is None or running.returncode == status, said
    assert "Traceback" not in said
    assert processes_in(domain) == []
    assert not summarize(bag).truncated


def processes_in(domain: int) -> list[str]:
    """Return the command lines of the processes that were started in a test's domain."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has just ended, or is another user's
            if f"ROS_DOMAIN_ID={domain}" in (folder / "environ").read_text().split("\0"):
                found.append((folder / "cmdline").read_text().replace("\0", " "))
    return found


def recorded_samples(bag: Path) -> int:
    try:
        return len(read_recording(bag))
    except (RecordingError, OSError):
        return 0


def test_every_node_and_every_estimator_is_an_executable_of_ros2_run():
    nodes = {"driver", "stage", "scan", "estimators", "mapper", "recorder", "replay"}
    nodes |= {"tissue_probe"}
    assert nodes | set(ESTIMATORS) <= {file.name for file in EXECUTABLES.iterdir()}


@pytest.mark.parametrize("name", ["driver", "recorder", "ukf"])
def test_an_executable_asked_for_help_says_how_parameters_are_given(name):
    done = subprocess.run(
        [EXECUTABLES / name, "--help"], capture_output=True, text=True, timeout=PATIENCE
    )
    assert done.returncode == 0
    assert f"ros2 run tissue_probe {name} --ros-args -p NAME:=VALUE" in done.stdout
    wrong = subprocess.run([EXECUTABLES / name, "now"], capture_output=True, text=True)
    assert wrong.returncode == 2
    assert "cannot read now" in wrong.stderr


@pytest.mark.parametrize("name", ["ekf", "afekf", "robust_ekf"])
def test_an_estimator_is_started_by_its_own_name(name):
    # A wrong setting ends it at once, and the message tells whose it was.
    done = subprocess.run(
        [EXECUTABLES / name, "--ros-args", "-p", "force_noise:=-1.0"],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == 1
    assert done.stderr.startswith(f"{name}: parameter force_noise")
