"""How much memory it takes to read a file, in a process of its own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def memory_to_read(path: Path, stated: dict[str, str]) -> float:
    """Return by how much a process's resident memory rises at most that reads a file [MB].

    ``stated`` are entries of the ``Layout``.
    """
    script = f"from benchmarks.memory import grown; print(grown({str(path)!r}, {stated!r}))"
    done = subprocess.run(
        [sys.executable, "-c", script], check=True, capture_output=True, text=True
    )
    return float(done.stdout.split()[-1])


def grown(path: str, stated: dict[str, str]) -> float:
    """Read a file here, and return the rise [MB]."""
    # What is loaded once is not of the file.
    import scipy.interpolate  # noqa: F401

    from tissue_probe.recording.any_file import read_any
    from tissue_probe.recording.layout import Layout

    Path("/proc/self/clear_refs").write_text("5")  # forget the peak, that of the parent too
    before = status("VmRSS")
    read_any(path, Layout(**stated))
    return status("VmHWM") - before


def status(name: str) -> float:
    """Return an entry of this process's status [MB]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith(name)) * 1024 / 1e6
