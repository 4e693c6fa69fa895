"""A server of the workbench as a user starts it, and Debian's Chromium in front of it."""

from __future__ import annotations

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
#: Longest wait for anything on a busy machine [ms]; a first fit compiles.
PATIENCE = 90_000


@dataclass
class Server:
    """A server's process, and where it is."""

    process: subprocess.Popen
    address: str
    port: int
    folder: Path

    @property
    def token(self) -> str:
        return self.address.partition("token=")[2]

    @property
    def cookie(self) -> str:
        return f"tissue_probe_{self.port}={self.token}"

    def kill(self) -> None:
        """End it as a crash would."""
        self.process.kill()
        self.process.wait()


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


@contextmanager
def serving(folder: Path, *arguments: object, port: int | None = None) -> Iterator[Server]:
    port = port or free_port()
    command = [sys.executable, "-m", "tissue_probe", "workbench", "--no-browser", "--port", port]
    process = subprocess.Popen(
        [*map(str, command), *map(str, arguments)],
        env={**os.environ, "XDG_STATE_HOME": str(folder)},
        stdout=subprocess.PIPE,
        stderr=(folder / "log").open("ab"),
        text=True,
    )
    try:
        line = process.stdout.readline()
        found = re.search(r"http://\S+", line)
        assert found, (folder / "log").read_text()
        yield Server(process, found[0], port, folder)
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(30)
        process.stdout.close()


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with serving(tmp_path_factory.mktemp("state")) as found:
        yield found


@pytest.fixture(scope="session")
def chromium():
    """Chromium without a window, and without a network."""
    path = shutil.which("chromium")
    if path is None:
        pytest.skip("there is no chromium: apt-get install chromium")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with playwright.sync_playwright() as driver:
        # The sandbox needs rights that a container does not give.
        browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()


@dataclass
class Opened:
    """A page, and all that it complained of."""

    page: object
    complaints: list[str] = field(default_factory=list)


@pytest.fixture
def open_page(chromium):
    """Open pages; at the end none may have complained, nor asked for anything elsewhere."""
    contexts, complaints = [], []

    def opened(address: str, size=(1280, 720), **more):
        context = chromium.new_context(
            viewport={"width": size[0], "height": size[1]}, accept_downloads=True, **more
        )
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(PATIENCE)
        page.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        host = address.split("/?")[0]

        def foreign(request):
            if not request.url.startswith((host, host.replace("http", "ws"), "blob:", "data:")):
                complaints.append(f"asked for {request.url}")

        page.on("request", foreign)
        page.goto(address)
        page.wait_for_selector("[data-example], .work")
        return page

    opened.complaints = complaints
    yield opened
    for context in contexts:
        context.close()
    assert complaints == []
