"""How long a command takes to start, beside an earlier revision: processor time.

Contents: the commands, and both trees.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from rich.table import Table

ROOT = Path(__file__).parents[1]
#: How often each command is run in each tree, by turns, so that others' load is that of both.
REPETITIONS = 5
MAKE = (
    "challenge",
    "make",
    "--count",
    "1",
    "--hide",
    "one",
    "--seed",
    "3",
    "--excitation",
    "sine10",
)
ASKED = ("made/0001.csv", "--rig", "compliant_probe", "--starts", "at-rest")
COMPARE, DIAGNOSE = ("compare", *ASKED), ("diagnose", *ASKED)
COMMANDS: dict[str, tuple[str, ...]] = {
    "import tissue_probe": ("-c", "import tissue_probe"),
    "--help": ("-m", "tissue_probe", "--help"),
    "compare, refused": ("-m", "tissue_probe", "compare", "nofile.csv"),
    "compare, 2 s": ("-m", "tissue_probe", *COMPARE),
}
FIRST = "first diagnosis, nothing compiled"


def measure(revision: str, say: Callable[[str], None] = print) -> dict[str, dict[str, float]]:
    """Return the processor time of each command [s], of this tree and of an earlier one.

    Parameters
    ----------
    revision : str
        Of git.
    say : callable
        Told what is under way.

    Raises
    ------
    SystemExit
        If git has no such revision.
    """
    with TemporaryDirectory() as name:
        folder = Path(name)
        trees = {"before": tree_of(revision, folder / "before"), "now": ROOT}
        times: dict[str, dict[str, float]] = {}
        _processor_time(("-m", "tissue_probe", *MAKE, "made"), ROOT, folder)
        for title, command in COMMANDS.items():
            say(f"{title}: {REPETITIONS} times, now and before")
            for tree in trees.values():  # compiles; reads files of which the system has no copy yet
                _processor_time(command, tree, folder)
            taken = [
                {key: _processor_time(command, tree, folder) for key, tree in trees.items()}
                for _ in range(REPETITIONS)
            ]
            times[title] = {key: median(each[key] for each in taken) for key in trees}
        say(f"{FIRST}: once, now and before")
        times[FIRST] = {
            key: _processor_time(("-m", "tissue_probe", *DIAGNOSE), tree, folder, cache=key)
            for key, tree in trees.items()
        }
    return times


def table(times: dict[str, dict[str, float]], revision: str) -> Table:
    """Return the times side by side."""
    shown = Table(title="Processor time of commands [s]", title_justify="left")
    for column in ("", revision, "now", "now / before"):
        shown.add_column(column, justify="right" if column else "left")
    for title, each in times.items():
        ratio = each["now"] / each["before"]
        shown.add_row(title, f"{each['before']:.2f}", f"{each['now']:.2f}", f"{ratio:.2f}")
    return shown


def tree_of(revision: str, folder: Path) -> Path:
    """Leave the files of a revision in a folder."""
    command = ["git", "-C", str(ROOT), "archive", revision]
    packed = subprocess.run(command, capture_output=True)
    if packed.returncode:
        raise SystemExit(f"benchmarks: {packed.stderr.decode().strip()}")
    with tarfile.open(fileobj=BytesIO(packed.stdout)) as files:
        files.extractall(folder)
    return folder


def _processor_time(
    command: tuple[str, ...], tree: Path, folder: Path, cache: str | None = None
) -> float:
    """Return the processor time that Python takes for a command, its own processes included [s]."""
    variables = {**os.environ, "PYTHONPATH": str(tree)}
    if cache:
        variables["TISSUE_PROBE_CACHE"] = str(folder / f"cache_{cache}")
    process = subprocess.Popen(
        [sys.executable, *command],
        cwd=folder,
        env=variables,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return used.ru_utime + used.ru_stime
