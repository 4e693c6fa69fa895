"""What processes use of the machine: processor time and memory."""

from __future__ import annotations

from collections.abc import Mapping

import psutil

MEGABYTE = 1e6


def cpu_seconds(pids: Mapping[str, int]) -> dict[str, float]:
    """Return the processor time, user and system, that each process has used so far [s]."""
    times = {name: psutil.Process(pid).cpu_times() for name, pid in pids.items()}
    return {name: time.user + time.system for name, time in times.items()}


def memory_megabytes(pids: Mapping[str, int]) -> dict[str, float]:
    """Return each process's memory [MB]; what several share is divided among them."""
    return {
        name: psutil.Process(pid).memory_full_info().pss / MEGABYTE for name, pid in pids.items()
    }
