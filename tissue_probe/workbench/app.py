"""The server's addresses: the page's files, its WebSocket, uploads, files to take away.

What belongs here: which address does what. What does not: doing it, and who may ask (``guard``).

No address names a file of the machine: the page's own files are known by name beforehand, and
recordings go by their numbers on the desk.
"""

from __future__ import annotations

import asyncio
from pathlib import Path
from urllib.parse import unquote

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from tissue_probe.errors import TissueProbeError
from tissue_probe.workbench import state, uploads
from tissue_probe.workbench.opened import Opened
from tissue_probe.workbench.refused import Refused
from tissue_probe.workbench.requests import Requests
from tissue_probe.workbench.taken import take

PAGE = Path(__file__).parent / "page"
KINDS = {".html": "text/html", ".css": "text/css", ".js": "text/javascript",
         ".svg": "image/svg+xml"}  # fmt: skip


def application(requests: Requests, folder: Path) -> Starlette:
    """Return the application.

    Parameters
    ----------
    requests : Requests
        Answers pages.
    folder : path
        Where what is dropped on a page is kept.
    """
    files = {
        f"/{path.relative_to(PAGE).as_posix()}": path
        for path in PAGE.rglob("*")
        if path.suffix in KINDS
    }
    files["/"] = PAGE / "index.html"

    async def serve_file(request: Request) -> Response:
        path = files[request.url.path]
        content = await asyncio.to_thread(path.read_bytes)
        return Response(content, media_type=KINDS[path.suffix])

    async def socket(websocket: WebSocket) -> None:
        await requests.pages.serve(websocket, requests.hear)

    async def upload(request: Request) -> Response:
        name = unquote(request.headers.get("x-file-name", "recording"))
        try:
            path = await uploads.keep(name, request.stream(), folder)
            if path.suffix == state.ENDING:
                await requests.change(lambda: _open_state(requests, path, folder))
                return JSONResponse({"state": True})
            opened = await requests.change(lambda: _open(requests, path))
        except TissueProbeError as error:
            return PlainTextResponse(f"{error}\n", status_code=409)
        return JSONResponse({"file": opened.number})

    app = Starlette(
        routes=[
            *(Route(address, serve_file) for address in files),
            Route("/upload", upload, methods=["POST"]),
            Route("/take/{name}", take),
            WebSocketRoute("/socket", socket),
        ]
    )
    app.state.requests = requests
    return app


async def _open(requests: Requests, path: Path) -> Opened:
    opened = await requests.desk.open(path, owned=True)
    await requests.desk.compare_first(opened)
    return opened


async def _open_state(requests: Requests, path: Path, folder: Path) -> None:
    """Put a kept desk in the place of what lies there."""
    kept = await asyncio.to_thread(state.unpacked_state, path, path.parent / "state")
    for number in list(requests.desk.files):
        requests.desk.forget(number)
    await state.restore(requests.desk, kept)
    if kept["programs"]:
        raise Refused(
            "this state has effects of your own; they are not run before you open their file "
            "under Missing, and the rungs that need them are left out"
        )
