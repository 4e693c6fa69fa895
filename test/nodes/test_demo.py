"""The demo, end to end: every node a process, one command, the nodules in the right places."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from numpy.testing import assert_array_equal

from conftest import PATIENCE
from tissue_probe.cli.recorded import build_map
from tissue_probe.estimation import ESTIMATORS
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.reader import read_estimates, read_map, read_recording
from tissue_probe.recording.summary import summarize

PNG = b"\x89PNG\r\n\x1a\n"
EXECUTABLES = Path(sys.prefix, "lib", "tissue_probe")
PROGRAM = EXECUTABLES / "tissue_probe"


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


@pytest.mark.crowded
@pytest.mark.slow
def test_the_demo_finds_every_nodule_and_leaves_recording_and_pictures(demo, tmp_path):
    running = demo("--dwell-time", "0.2")
    printed, said = running.communicate(timeout=150)
    assert running.returncode == 0, said
    assert "3 of 3 nodules found, 0 stiff regions where there is no nodule" in printed
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
    off_line = build_map(read_recording(bag), list(read_estimates(bag).values()))
    assert live.stamp == off_line.stamp
    for layer in ("stiffness", "damping", "covariance_trace", "stiffness_stddev", "verdict"):
        assert_array_equal(getattr(live, layer), getattr(off_line, layer))


@pytest.mark.crowded
def test_ctrl_c_in_the_demo_ends_every_process_and_keeps_the_recording(demo, tmp_path):
    running = demo()
    bag = tmp_path / "run.mcap"
    deadline = time.monotonic() + PATIENCE
    while recorded_samples(bag) < 2000:
        assert time.monotonic() < deadline, "nothing is recorded"
        assert running.poll() is None, running.communicate()[1]
        time.sleep(0.1)
    running.send_signal(signal.SIGINT)
    running.communicate(timeout=PATIENCE)
    assert recorded_samples(bag) >= 2000
    assert not summarize(bag).truncated
    assert not any(str(tmp_path) in line for line in processes())


def recorded_samples(bag: Path) -> int:
    try:
        return len(read_recording(bag))
    except (RecordingError, OSError):
        return 0


def processes() -> list[str]:
    return subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True).stdout.split("\n")


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
