"""The server's end of the process that listens to ROS: pages are told, nodes are asked.

Contents: starting, hearing, asking and ending that process.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import sys
from typing import Any

from tissue_probe.workbench.pages import Pages
from tissue_probe.workbench.refusal import RequestRefused
from tissue_probe.workbench.watching import MAP_KIND
from tissue_probe.workbench.worker import DONE, FRAME

#: Longest wait for an answer to a command [s]: a little more than the nodes are waited for.
LONGEST_ANSWER = 15.0


class LiveListener:
    """Listens for as long as the server runs.

    Parameters
    ----------
    pages : Pages
        The pages that are told; a slow one misses outdated messages.

    Attributes
    ----------
    map : bytes or None
        The message with the newest map, for pages that come later.
    """

    def __init__(self, pages: Pages) -> None:
        self._pages = pages
        self.map: bytes | None = None
        self._process: asyncio.subprocess.Process | None = None
        self._numbers = itertools.count()
        self._waiting: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self.ended = ""

    async def listen(self) -> None:
        """Start the process, and pass its messages to pages, until it ends."""
        self._process = process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "tissue_probe.workbench.watching"),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            start_new_session=True,
        )
        assert process.stdout is not None
        with contextlib.suppress(asyncio.IncompleteReadError):
            while True:
                kind, size = FRAME.unpack(await process.stdout.readexactly(FRAME.size))
                content = await process.stdout.readexactly(size)
                if kind == DONE:
                    self._hand_answer(json.loads(content))
                elif kind == MAP_KIND:
                    self.map = content
                    self._pages.tell_bytes("live_map", content)
                else:
                    self._pages.tell_bytes("live", content)
        self.ended = "the process that listens to ROS has ended; start the workbench again"
        for waiting in self._waiting.values():
            waiting.cancel()

    async def command(self, command: str, given: dict[str, Any]) -> Any:
        """Ask something of the nodes.

        Raises
        ------
        Refused
            If they do not obey.
        """
        if self._process is None or self._process.stdin is None or self.ended:
            raise RequestRefused(self.ended or "nobody listens to ROS yet; wait a moment")
        number = next(self._numbers)
        line = {"number": number, "command": command, "given": given}
        self._waiting[number] = answer = asyncio.get_running_loop().create_future()
        try:
            self._process.stdin.write(json.dumps(line).encode() + b"\n")
            told = await asyncio.wait_for(answer, LONGEST_ANSWER)
        except (TimeoutError, asyncio.CancelledError, ConnectionError):
            raise RequestRefused("the nodes do not answer") from None
        finally:
            del self._waiting[number]
        if "refused" in told:
            raise RequestRefused(told["refused"])
        return told["ok"]

    async def close(self) -> None:
        """End the process."""
        process = self._process
        if process is None or process.returncode is not None:
            return
        assert process.stdin is not None
        process.stdin.close()
        try:
            await asyncio.wait_for(process.wait(), 3.0)
        except TimeoutError:
            process.kill()

    def _hand_answer(self, told: dict[str, Any]) -> None:
        waiting = self._waiting.get(told["number"])
        if waiting is not None and not waiting.done():
            waiting.set_result(told)
