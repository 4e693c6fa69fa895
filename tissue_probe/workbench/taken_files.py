"""Files taken from the desk: model, report, notebook, the whole state, each as one file.

Contents: their names and kinds.
"""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Callable
from pathlib import Path

from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response

from tissue_probe.workbench.notebook import notebook
from tissue_probe.workbench.refusal import RequestRefused
from tissue_probe.workbench.requests import Requests
from tissue_probe.workbench.state import STATE_ENDING, pack_state

#: Of each file its type, told to the browser.
TAKEN_TYPES = {
    "model.yaml": "application/yaml",
    "report.html": "text/html",
    "map.html": "text/html",
    "steps.ipynb": "application/x-ipynb+json",
    f"desk{STATE_ENDING}": "application/zip",
}


async def take(request: Request) -> Response:
    """Answer a request for one of the files."""
    name, requests = request.path_params["name"], request.app.state.requests
    if name not in TAKEN_TYPES:
        told = f"there is no {name} to take away; there are {', '.join(TAKEN_TYPES)}\n"
        return PlainTextResponse(told, status_code=404)
    content = await _content(name, requests)
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return Response(content, media_type=TAKEN_TYPES[name], headers=headers)


async def _content(name: str, requests: Requests) -> bytes:
    desk = requests.desk
    if name == "model.yaml":
        if not desk.rungs:
            raise RequestRefused("there is no model yet: open a recording first")
        return await _write_bytes(name, desk.rungs[-1].compared.model.save)
    if name == "map.html":
        if desk.map is None:
            raise RequestRefused("there is no map yet: open a scan first")
        return await _write_bytes(name, desk.map.report)
    if name == "report.html":
        found: bytes = await requests.change(desk.report)
        return found
    if name == "steps.ipynb":
        return notebook(desk).encode()
    return await asyncio.to_thread(pack_state, desk)


async def _write_bytes(name: str, write: Callable[[Path], object]) -> bytes:
    """Return the bytes that a function writes to a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        await asyncio.to_thread(write, path)
        return path.read_bytes()
