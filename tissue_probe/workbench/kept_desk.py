"""Files that outlive the server: its token, and the desk, so that it goes on where it was killed.

Contents: that folder of the user's, and one server's place in it.
"""

from __future__ import annotations

import json
import os
import secrets
import shutil
from pathlib import Path
from typing import Any

from tissue_probe.workbench.declaration import as_object
from tissue_probe.workbench.refusal import RequestRefused


class Kept:
    """A server's folder, by its port: nobody else on the machine may read it.

    Parameters
    ----------
    port : int
        Where it listens.
    """

    def __init__(self, port: int) -> None:
        home = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local/state")
        self.folder = home / "tissue_probe" / f"workbench_{port}"
        self.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        self.folder.chmod(0o700)
        self._desk = self.folder / "desk.json"
        self._token = self.folder / "token"

    def token(self) -> str:
        """Return the token of the server that was killed here, or a new one."""
        if not self._token.exists():
            with open(self._token, "x", opener=_mine) as file:
                file.write(secrets.token_urlsafe(32))
        return self._token.read_text()

    def desk(self) -> dict[str, Any] | None:
        """Return the desk of a server that was killed; None if it ended, or left none."""
        try:
            return as_object(self._desk.read_bytes(), self._desk.name)
        except (OSError, RequestRefused):
            return None

    def keep(self, desk: dict[str, Any]) -> None:
        """Keep the desk; a file half written never takes the place of a whole one."""
        part = self._desk.with_suffix(".part")
        part.write_text(json.dumps(desk), encoding="utf-8")
        part.replace(self._desk)

    def clear(self) -> None:
        """Leave nothing: the server has ended as it should."""
        shutil.rmtree(self.folder, ignore_errors=True)


def _mine(path: str, flags: int) -> int:
    return os.open(path, flags, 0o600)
