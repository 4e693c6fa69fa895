"""The server's end of the worker: one piece of work at a time, told of, and cancelled.

Contents: starting, hearing and ending the process.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import sys
from collections.abc import Callable
from typing import Any

from tissue_probe.analysis.passing import from_bytes
from tissue_probe.workbench.refusal import RequestRefused
from tissue_probe.workbench.work import Work
from tissue_probe.workbench.worker import DONE, FRAME, WORK_FAILED, WORK_TOLD

Hear = Callable[[dict[str, Any]], None]


class Cancelled(RequestRefused):
    """The user has ended the work."""


class Workshop:
    """Does one piece of work after the other, in a process that stays warm between them."""

    def __init__(self) -> None:
        self._one_at_a_time = asyncio.Lock()
        self._process: asyncio.subprocess.Process | None = None
        #: How often work was cancelled: work that waited for its turn then was meant, too.
        self._cancelled = 0

    async def do(self, work: Work, hear: Hear = lambda told: None) -> Any:
        """Return the result of a piece of work.

        Parameters
        ----------
        work : Work
            The work.
        hear : callable
            Called with the step under way.

        Raises
        ------
        Cancelled
            If ``cancel`` was called meanwhile.
        Refused
            If it cannot be done; says why, and the remedy.
        """
        before = self._cancelled
        async with self._one_at_a_time:
            if self._cancelled != before:
                raise Cancelled("cancelled")
            process = await self._start_worker()
            kind, content = await self._answer(process, work.to_bytes(), hear)
        if kind == WORK_FAILED:
            raise RequestRefused(content.decode())
        return await asyncio.to_thread(from_bytes, content, work.effects)

    def cancel(self) -> None:
        """End the work under way and all that waits, if there is any."""
        if self._one_at_a_time.locked():
            self._cancelled += 1
            self._end()

    async def close(self) -> None:
        """End the process."""
        process = self._process
        self._end()
        if process is not None:
            await process.wait()

    async def _start_worker(self) -> asyncio.subprocess.Process:
        if self._process is None or self._process.returncode is not None:
            # A group of its own: processes that the worker starts end with it, and no Ctrl-C
            # reaches it.
            self._process = await asyncio.create_subprocess_exec(
                sys.executable,
                "-m",
                "tissue_probe.workbench.worker",
                stdin=asyncio.subprocess.PIPE,
                stdout=asyncio.subprocess.PIPE,
                start_new_session=True,
                limit=2**20,
            )
        return self._process

    async def _answer(
        self, process: asyncio.subprocess.Process, content: bytes, hear: Hear
    ) -> tuple[bytes, bytes]:
        assert process.stdin is not None
        assert process.stdout is not None
        before = self._cancelled
        try:
            process.stdin.write(FRAME.pack(WORK_TOLD, len(content)) + content)
            await process.stdin.drain()
            while True:
                kind, size = FRAME.unpack(await process.stdout.readexactly(FRAME.size))
                told = await process.stdout.readexactly(size)
                if kind in (DONE, WORK_FAILED):
                    return kind, told
                hear(json.loads(told))
        except (asyncio.IncompleteReadError, ConnectionError):
            await process.wait()
            if self._cancelled != before:
                raise Cancelled("cancelled") from None
            raise RequestRefused(
                "the process that fits was ended from outside; if the machine is short of memory, "
                "end other programs, then try again"
            ) from None
        except asyncio.CancelledError:
            self._end()
            raise

    def _end(self) -> None:
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                if hasattr(os, "killpg"):
                    os.killpg(self._process.pid, signal.SIGKILL)
                else:
                    self._process.kill()
        self._process = None
