"""A full disk ends a run in a sentence; no row is lost or doubled, and the next run repairs.

Each run is a process of its own, on a disk that is small (a file system in memory, where mounting
one is permitted) or that takes no longer file (a limit of the process).
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from laboratory import QUESTION

#: Three recordings are answered, the disk is full, one of them is dated anew, and six are asked
#: for; then there is room again.
STORY = """
import json, os, resource, sys
from pathlib import Path
import pyarrow.parquet as pq
import tissue_probe as tp
from tissue_probe.studies.plan import StudyPlan, recordings_of

data, disk, kind, question = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3], sys.argv[4]
answers = disk / "answers"

def study(names):
    plan = StudyPlan(recordings_of(str(data / names)), "estimate", json.loads(question), answers)
    return tp.study(plan, workers=1)

def fill():
    if kind == "limit":
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, resource.RLIM_INFINITY))
        return
    with open(disk / "filler", "wb", buffering=0) as file:
        try:
            while True:
                file.write(bytes(4096))
        except OSError:
            pass

def make_room():
    if kind == "limit":
        resource.setrlimit(resource.RLIMIT_FSIZE, 2 * (resource.RLIM_INFINITY,))
    else:
        (disk / "filler").unlink()

def stored():
    return sorted(Path(each["path"]).name for each in pq.read_table(answers / "rows").to_pylist())

told = {"first": study("*_1.csv").computed}
os.utime(data / "a_1.csv")
fill()
said = []
for attempt in range(2):
    try:
        study("*.csv")
    except tp.TissueProbeError as error:
        said.append(str(error))
told |= {"said": said, "kept": stored(), "left": [p.name for p in answers.rglob("_*")]}
make_room()
told |= {"last": study("*.csv").computed, "then": study("*.csv").computed, "all": stored()}
print(json.dumps(told))
"""


def run_story(laboratory: Path, disk: Path, kind: str, before: tuple[str, ...] = ()) -> dict:
    disk.mkdir()
    story = [sys.executable, "-c", STORY, str(laboratory), str(disk), kind]
    done = subprocess.run(
        [*before, *story, json.dumps({"force_polarity": QUESTION["force_polarity"]})],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def in_a_small_file_system(disk: Path) -> tuple[str, ...]:
    """Return how a command is run with a file system of 1 MB there; skip where that is refused."""
    if shutil.which("unshare") is None:
        pytest.skip("unshare, which mounts without rights of its own, is not installed")
    mount = f'mount -t tmpfs -o size=1m tmpfs "{disk}" && exec "$@"'
    before = ("unshare", "--map-root-user", "--mount", "sh", "-c", mount, "sh")
    disk.mkdir()
    tried = subprocess.run([*before, "true"], capture_output=True, text=True, check=False)
    disk.rmdir()
    if tried.returncode:
        pytest.skip(f"no file system can be mounted here: {tried.stderr.strip()}")
    return before


@pytest.mark.parametrize(
    ("kind", "reason"), [("limit", "File too large"), ("tmpfs", "No space left on device")]
)
def test_a_full_disk_loses_and_doubles_no_row(laboratory, tmp_path, kind, reason):
    disk = tmp_path / "disk"
    before = in_a_small_file_system(disk) if kind == "tmpfs" else ()
    told = run_story(laboratory, disk, kind, before)
    assert told["first"] == 3
    assert len(told["said"]) == 2
    for said in told["said"]:
        assert f"cannot be written: {reason}; all that was written before is kept" in said
    assert told["kept"] == ["a_1.csv", "b_1.csv", "c_1.csv"]
    assert told["left"] == []
    assert (told["last"], told["then"]) == (3, 0)
    assert told["all"] == [f"{each}_{day}.csv" for each in "abc" for day in (1, 2)]
