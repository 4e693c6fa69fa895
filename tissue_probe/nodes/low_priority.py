"""The priority of work beside the nodes, which waits for those that measure."""

from __future__ import annotations

import os

#: How much lower it is: at 10 a process that is ready gets a tenth of the processor beside one of
#: priority 0 (Linux' weights of nice values, 110 to 1024).
NICENESS = 10


def lower_priority(task: int) -> None:
    """Lower the priority of a process or a thread, by its number, where the system can."""
    if hasattr(os, "setpriority"):
        os.setpriority(os.PRIO_PROCESS, task, NICENESS)
