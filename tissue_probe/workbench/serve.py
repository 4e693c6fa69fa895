"""The server of the workbench: starts, opens the page, goes on where it was killed, and ends."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import signal
import socket
import sys
import webbrowser
from collections.abc import AsyncIterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import uvicorn
from starlette.applications import Starlette

from tissue_probe.errors import ParameterError, TissueProbeError
from tissue_probe.workbench import state
from tissue_probe.workbench.app import application
from tissue_probe.workbench.desk import Desk
from tissue_probe.workbench.guard import Guard
from tissue_probe.workbench.kept_desk import Kept
from tissue_probe.workbench.opened_study import open_study
from tissue_probe.workbench.request_declarations import LONGEST_REQUEST
from tissue_probe.workbench.requests import Requests
from tissue_probe.workbench.work import Work
from tissue_probe.workbench.workshop import Workshop

if TYPE_CHECKING:
    from tissue_probe.analysis.comparing import ComparisonResult

#: Where it listens if nothing is said: the same each time, so that a page that was left open finds
#: the server again.
PORT = 8437
#: How many ports after that are tried where another workbench runs.
TRIED = 20
#: Largest message of a page [bytes]: any request of the length that is refused in words has less.
LARGEST_MESSAGE = 2 * 4 * LONGEST_REQUEST
#: Time that open connections have to end [s].
ENDING_TIME = 1


def serve(
    files: Sequence[Path],
    layout: dict[str, Any],
    asked: dict[str, Any],
    port: int | None = None,
    browse: bool = True,
    live: bool = False,
    commands: bool = False,
    study: Path | None = None,
) -> None:
    """Serve the workbench until Ctrl-C.

    Parameters
    ----------
    files : sequence of path
        Recordings to open: the first is fitted, the second is held against.
    layout : dict
        How they are read, as ``tissue_probe.read`` takes it.
    asked : dict
        The question on them, as ``tissue_probe.compare`` takes it.
    port : int, optional
        Where to listen; by default the first that is free.
    browse : bool
        Whether to open the page in the user's browser.
    live, commands : bool
        Whether to listen to ROS, and whether pages may command the nodes.
    study : path, optional
        File of a study that was run, whose table the page shows.

    Raises
    ------
    ParameterError
        If the port is taken.
    """
    studied = None if study is None else open_study(study)
    listening = _open_socket(port)
    port = listening.getsockname()[1]
    kept = Kept(port)
    token = kept.token()
    desk = Desk(reading=Workshop(), fitting=Workshop())
    desk.asked = desk.asked.changed(asked)
    desk.study = studied
    app = _make_application(desk, files, layout, kept, live, commands)
    address = f"http://127.0.0.1:{port}/?token={token}"
    config = uvicorn.Config(
        Guard(app, token, port),
        log_level="warning",
        access_log=False,
        ws_max_size=LARGEST_MESSAGE,
        timeout_graceful_shutdown=ENDING_TIME,
        server_header=False,
        lifespan="on",
    )
    logging.getLogger("uvicorn.error").addFilter(_without_trace)
    print(f"The workbench is at {address}", flush=True)
    print("It ends by Ctrl-C.", file=sys.stderr, flush=True)
    if browse:
        with contextlib.suppress(webbrowser.Error):
            webbrowser.open(address)
    # The server, ended by a signal, raises it once more at its end.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(uvicorn.Server(config).serve(sockets=[listening]))
    kept.clear()


def _without_trace(record: logging.LogRecord) -> bool:
    """Leave uvicorn's sentence on bytes that are no text, without a trace of the program."""
    if record.exc_info and isinstance(record.exc_info[1], UnicodeDecodeError):
        record.exc_info = None
    return True


def _try_out(compared: ComparisonResult) -> None:
    """Do with a comparison all that pages ask for: the modules are imported afterwards."""
    compared.predict({})
    compared.view().spectrum()


def _open_socket(port: int | None) -> socket.socket:
    tried = range(PORT, PORT + TRIED) if port is None else [port]
    for each in tried:
        found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        # A server that was killed a moment ago leaves its port in TIME_WAIT.
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            found.bind(("127.0.0.1", each))
            found.listen()
        except OSError:
            found.close()
            continue
        return found
    raise ParameterError(f"`port` {tried[0]} is taken; give another one")


def _make_application(
    desk: Desk,
    files: Sequence[Path],
    layout: dict[str, Any],
    kept: Kept,
    live: bool,
    commands: bool,
) -> Starlette:
    """Return the application of a desk that begins with the files, or where it was killed."""
    requests = Requests(desk, kept.folder, live, commands)
    tell = desk.changed

    def note_change() -> None:
        tell()
        kept.keep(state.state(desk))

    async def begin(before: dict[str, Any] | None) -> None:
        desk.changed = tell
        with contextlib.suppress(TissueProbeError):
            if files:
                for path in files:
                    await desk.open(path, layout)
                read = [n for n, opened in desk.files.items() if opened.measured]
                if read:
                    await desk.use(read[0], read[1] if len(read) > 1 else None)
                elif tables := [n for n, opened in desk.files.items() if opened.table]:
                    await desk.draw_map(tables[0])
            elif before is not None:
                await state.restore(desk, before)
        desk.changed = note_change
        note_change()

    async def warm_up() -> None:
        """Load, here and in both processes, the modules that the first steps would wait for."""
        with contextlib.suppress(TissueProbeError):
            for name in ("warm", "warm_effects"):
                found = await desk.fitting.do(Work(name, {}))
                await asyncio.to_thread(_try_out, found)

    async def warm_up_reading() -> None:
        with contextlib.suppress(TissueProbeError):
            await desk.reading.do(Work("warm_reading", {}))

    @contextlib.asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        before = kept.desk()
        tasks = [
            asyncio.create_task(each)
            for each in (warm_up_reading(), warm_up(), requests.change(lambda: begin(before)))
        ]
        if requests.live is not None:
            tasks.append(asyncio.create_task(requests.live.listen()))
        yield
        for task in tasks:
            task.cancel()
        if requests.live is not None:
            await requests.live.close()
        requests.close()
        await desk.reading.close()
        await desk.fitting.close()

    app = application(requests, kept.folder)
    app.router.lifespan_context = lifespan
    return app
