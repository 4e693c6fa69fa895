"""The open pages: the messages to each, of which the newest counts.

Contents: a slow page holds up nothing, and misses outdated messages only.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable

from starlette.websockets import WebSocket, WebSocketDisconnect

from tissue_probe.workbench.messages import as_json

#: Answers that wait for a page: one that asks for more without reading is closed.
WAITING = 1000


class Page:
    """One page: answers in their order, and of everything that changes only the newest.

    Parameters
    ----------
    socket : WebSocket
        Its connection.
    """

    def __init__(self, socket: WebSocket) -> None:
        self._socket = socket
        self._answers: deque[bytes | str] = deque()
        self._newest: dict[str, Callable[[], bytes | str]] = {}
        self._something = asyncio.Event()

    def answer(self, message: bytes | str) -> None:
        """Send an answer."""
        self._answers.append(message)
        self._something.set()

    def tell(self, kind: str, make: Callable[[], bytes | str]) -> None:
        """Send the newest of its kind: it is made when the page takes it."""
        self._newest[kind] = make
        self._something.set()

    async def send(self) -> None:
        """Send, for as long as the page is there."""
        with contextlib.suppress(WebSocketDisconnect):
            while await self._some():
                pass

    async def _some(self) -> bool:
        """Send the waiting messages, when there are some; return whether the page reads it."""
        await self._something.wait()
        self._something.clear()
        while self._answers or self._newest:
            if len(self._answers) > WAITING:
                await self._socket.close(1008, "the page does not read")
                return False
            # The newest state came from the answer before it, or after: a page
            # that is told an answer knows the state that it led to.
            for kind in list(self._newest):
                await self._send_message(self._newest.pop(kind)())
            if self._answers:
                await self._send_message(self._answers.popleft())
        return True

    async def _send_message(self, message: bytes | str) -> None:
        if isinstance(message, str):
            await self._socket.send_text(message)
        else:
            await self._socket.send_bytes(message)


class Pages:
    """All pages that are open."""

    def __init__(self) -> None:
        self._pages: set[Page] = set()

    def __len__(self) -> int:
        return len(self._pages)

    def tell(self, kind: str, make: Callable[[], object]) -> None:
        """Tell all pages the newest of a kind."""
        for page in self._pages:
            page.tell(kind, lambda: as_json({kind: make()}))

    def tell_bytes(self, kind: str, message: bytes) -> None:
        """Send all pages the newest message of a kind."""
        for page in self._pages:
            page.tell(kind, lambda: message)

    async def serve(
        self,
        socket: WebSocket,
        greet: Callable[[Page], None],
        hear: Callable[[Page, str | bytes], None],
    ) -> None:
        """Hear and tell one page until it leaves."""
        await socket.accept()
        page = Page(socket)
        self._pages.add(page)
        sending = asyncio.create_task(page.send())
        try:
            greet(page)
            while (message := await socket.receive())["type"] == "websocket.receive":
                text = message.get("text")
                hear(page, message["bytes"] if text is None else text)
        finally:
            self._pages.discard(page)
            sending.cancel()
