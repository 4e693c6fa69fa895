"""What processes use of the machine: processor time, memory, file descriptors, threads."""

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


def holdings(pids: Mapping[str, int]) -> dict[str, dict[str, float]]:
    """Return resident memory [MB], file descriptors and threads that each process has now."""
    processes = {name: psutil.Process(pid) for name, pid in pids.items()}
    return {
        name: {
            "resident_megabytes": process.memory_info().rss / MEGABYTE,
            "file_descriptors": process.num_fds(),
            "threads": process.num_threads(),
        }
        for name, process in processes.items()
    }
