"""The server's addresses: the page's files, its WebSocket, uploads, files to take away.

Contents: the function of each address.

No address names a file of the machine: the page's own files are known by name beforehand, and
recordings go by their numbers on the desk.
"""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from tissue_probe.errors import TissueProbeError
from tissue_probe.workbench import desk_messages, state, uploads
from tissue_probe.workbench.opened_file import Opened
from tissue_probe.workbench.refusal import RequestRefused, describe_refusal
from tissue_probe.workbench.requests import Requests
from tissue_probe.workbench.taken_files import take

PAGE = Path(__file__).parent / "page"
PAGE_TYPES = {".html": "text/html", ".css": "text/css", ".js": "text/javascript",
         ".svg": "image/svg+xml"}  # fmt: skip


#: The content type of an upload: a file's own bytes.
BYTES_TYPE = "application/octet-stream"


async def _answer_refusal(request: Request, error: Exception) -> Response:
    assert isinstance(error, (TissueProbeError, OSError))
    desk = request.app.state.requests.desk
    words = desk_messages.without_paths(desk, str(describe_refusal(error)))
    return PlainTextResponse(f"{words}\n", status_code=409)


async def _not_here(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    status, headers = error.status_code, error.headers or {}
    words = {
        404: "there is nothing at this address; the page is at /",
        405: f"this address takes {headers.get('Allow')}, and not {request.method}",
    }
    return PlainTextResponse(f"{words.get(status, error.detail)}\n", status, headers)


async def _answer_nobody(request: Request, error: Exception) -> Response:
    """Answer nobody: the sender of the request went away before its end."""
    return Response(status_code=400)


#: How a request ends that cannot be done.
REFUSALS: dict[Any, Any] = {
    TissueProbeError: _answer_refusal,
    OSError: _answer_refusal,
    HTTPException: _not_here,
    ClientDisconnect: _answer_nobody,
}


def application(requests: Requests, folder: Path) -> Starlette:
    """Return the application.

    Parameters
    ----------
    requests : Requests
        Answers pages.
    folder : path
        Where files dropped on a page are kept.
    """
    files = {
        f"/{path.relative_to(PAGE).as_posix()}": path
        for path in PAGE.rglob("*")
        if path.suffix in PAGE_TYPES
    }
    files["/"] = PAGE / "index.html"

    async def serve_file(request: Request) -> Response:
        path = files[request.url.path]
        content = await asyncio.to_thread(path.read_bytes)
        return Response(content, media_type=PAGE_TYPES[path.suffix])

    async def socket(websocket: WebSocket) -> None:
        await requests.pages.serve(websocket, requests.greet, requests.hear)

    async def upload(request: Request) -> Response:
        path = await uploads.keep(_file_name(request), request.stream(), folder)
        if path.suffix == state.STATE_ENDING:
            await requests.change(lambda: _open_state(requests, path))
            return JSONResponse({"state": True})
        opened = await requests.change(lambda: _open(requests, path))
        return JSONResponse({"file": opened.number})

    app = Starlette(
        routes=[
            *(Route(address, serve_file) for address in files),
            Route("/upload", upload, methods=["POST"]),
            Route("/take/{name}", take),
            WebSocketRoute("/socket", socket),
        ],
        exception_handlers=REFUSALS,
    )
    # An address with a slash too many is none of ours.
    app.router.redirect_slashes = False
    app.state.requests = requests
    return app


def _file_name(request: Request) -> str:
    """Return the name of an uploaded file.

    Raises
    ------
    HTTPException
        If there is none, or the file comes wrapped in a form.
    """
    kind, name = request.headers.get("content-type"), request.headers.get("x-file-name")
    if kind != BYTES_TYPE:
        raise HTTPException(
            415, f"send the file as it is, as Content-Type {BYTES_TYPE}, not {kind}"
        )
    if not name:
        raise HTTPException(400, "give the file's name in the header X-File-Name")
    return unquote(name)


async def _open(requests: Requests, path: Path) -> Opened:
    opened = await requests.desk.open(path, owned=True)
    await requests.desk.compare_first(opened)
    return opened


async def _open_state(requests: Requests, path: Path) -> None:
    """Replace the desk by a kept one."""
    kept = await asyncio.to_thread(state.unpack_state, path, path.parent / "state")
    for number in list(requests.desk.files):
        requests.desk.forget(number)
    await state.restore(requests.desk, kept)
    if kept["programs"]:
        raise RequestRefused(
            "this state has effects of your own; they are not run before you open their file "
            "under Missing, and the rungs that need them are left out"
        )
