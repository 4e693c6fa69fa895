"""A diagnosis beside a node: one question to a process of its own, of low priority.

Contents: starting it.
"""

from __future__ import annotations

from tissue_probe.monitoring.identification import RecordsQuestion
from tissue_probe.monitoring.question import MonitorQuestion
from tissue_probe.nodes.side_process import SideProcess


def start_diagnosis(question: MonitorQuestion | RecordsQuestion) -> SideProcess:
    """Return a process that says the verdict, when it has one."""
    # By its name: what it imports would take the node a second.
    process = SideProcess("tissue_probe.analysis.monitor_worker", question, "diagnoses")
    process.lower()
    return process
