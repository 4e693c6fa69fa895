"""The server of the workbench, started as a user starts it."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

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
