"""The priority of work beside the nodes, which waits for those that measure."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

#: How much lower it is: at 10 a process that is ready gets a tenth of the processor beside one of
#: priority 0 (Linux' weights of nice values, 110 to 1024).
NICENESS = 10


def lower_priority(task: int) -> None:
    """Lower the priority of a process or a thread, by its number, where the system can."""
    if hasattr(os, "setpriority"):
        os.setpriority(os.PRIO_PROCESS, task, NICENESS)


def lower_session(leader: int) -> None:
    """Lower the priority of a process that leads a session of its own, against all sessions.

    Linux may share the processor among sessions first (autogroup, sched(7)), and by priority only
    within each. Work in the session of a node would use up the node's share, whose samples then
    wait for all other sessions.
    """
    lower_priority(leader)
    with suppress(OSError):
        Path(f"/proc/{leader}/autogroup").write_text(str(NICENESS))
