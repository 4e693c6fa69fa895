"""The requests of a thread with deadlines to the operating system, and whether they are granted.

Contents: Linux's real-time priority and locked memory.
"""

from __future__ import annotations

import ctypes
import os
import resource

#: Above every ordinary process, below the kernel's work for its devices (50) and before all
#: that is more urgent than a probe.
PRIORITY = 40
#: Linux's mlockall(2): present and future memory, each page once it is in use. To fill every
#: thread's stack at once would take more memory than all else.
_CURRENT, _FUTURE, _ON_FAULT = 1, 2, 4


def ask_for_priority() -> str:
    """Ask that the calling thread runs before every ordinary one; return the outcome."""
    # Threads that it starts get an ordinary priority again.
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    try:
        os.sched_setscheduler(0, policy, os.sched_param(PRIORITY))
    except OSError as error:
        return f"no ({error.strerror}): give the user an rtprio of {PRIORITY} or more"
    return f"yes, {PRIORITY}"


def ask_for_locked_memory() -> str:
    """Ask that this process never waits for memory on disk; return the outcome."""
    try:
        # Under a limit a later request for memory would fail, which is worse than to wait for it.
        resource.setrlimit(resource.RLIMIT_MEMLOCK, 2 * (resource.RLIM_INFINITY,))
    except (ValueError, OSError):
        return "no (the user's memlock is limited): set it to unlimited"
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mlockall(_CURRENT | _FUTURE | _ON_FAULT) != 0:
        return f"no ({os.strerror(ctypes.get_errno())})"
    return "yes"
