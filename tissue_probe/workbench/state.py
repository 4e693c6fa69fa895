"""The whole desk as plain data, and the desk again: files, question, effects in their order.

Contents: that, in memory, and in one file with all recordings in it. They are made again, since a
fit says nothing without the samples that it was made of.
"""

from __future__ import annotations

import json
import zipfile
import zlib
from io import BytesIO
from pathlib import Path
from typing import Any

from tissue_probe.workbench.declaration import Declared, as_object, check_declared, shorten_value
from tissue_probe.workbench.desk import Desk
from tissue_probe.workbench.opened_file import Opened
from tissue_probe.workbench.refusal import RequestRefused
from tissue_probe.workbench.request_declarations import Layout, Stated
from tissue_probe.workbench.uploads import LARGEST_UPLOAD, plain

VERSION = 1
#: The file's ending, and its member that tells the rest.
STATE_ENDING, MEMBER = ".workbench", "desk.json"
#: Errors of reading an archive that is damaged, locked or packed in an unknown way.
ARCHIVE_ERRORS = (
    OSError,
    ValueError,
    KeyError,
    RuntimeError,
    EOFError,
    zlib.error,
    zipfile.BadZipFile,
)
#: Most bytes of a member that is text: names and some hundred numbers, or a program of one's own.
LONGEST_MEMBER = 2**20


class StateFile(Declared):
    """A recording: its name, where it lies, the statements on it, and whose copy it is."""

    name: str
    path: str
    layout: Layout
    owned: bool


class DeskState(Declared):
    """The whole desk; recordings that are chosen, by their places among ``files``.

    ``programs`` holds the text of effects that came with a file, and are not run.
    """

    version: int
    files: list[StateFile]
    fitted: int | None
    second: int | None
    asked: Stated
    effects: list[str]
    added: list[str]
    programs: list[str] = []


def state(desk: Desk) -> dict[str, Any]:
    """Return the desk as plain data; recordings by their paths."""
    files = list(desk.files.values())
    place = {opened.number: index for index, opened in enumerate(files)}
    return {
        "version": VERSION,
        "files": [
            {"name": f.name, "path": str(f.path), "layout": f.layout, "owned": f.owned}
            for f in files
        ],
        "fitted": None if desk.fitted is None else place[desk.fitted],
        "second": None if desk.second is None else place[desk.second],
        "asked": desk.asked.parameters(),
        "effects": list(desk.effects),
        "added": [rung.added for rung in desk.rungs[1:]],
    }


async def restore(desk: Desk, kept: dict[str, Any]) -> None:
    """Put everything on an empty desk as it was.

    Recordings that are there no more are left out, with all that was found of them.

    Raises
    ------
    Refused
        If it is no state of this version, or something in it cannot be done again.
    """
    whole = _check_state(kept)
    opened: list[Opened | None] = []
    desk.asked = desk.asked.changed(whole.asked)
    for file in map(Path, whole.effects):
        if file.exists():
            await desk.take_effects(file)
    for each in whole.files:
        path = Path(each.path)
        there = path.exists()
        opened.append(await desk.open(path, each.layout, each.name, each.owned) if there else None)
    for table in [one for one in opened if one and one.table][-1:]:
        await desk.draw_map(table.number)
    first = _at(opened, whole.fitted)
    if first is None or first.measured is None:
        desk.changed()
        return
    other = _at(opened, whole.second)
    await desk.use(first.number, other.number if other and other.measured else None)
    if desk.asked.of_samples()["site"] is not None:
        await desk.draw_map(first.number)
    await desk.add_all(whole.added)


def _check_state(kept: dict[str, Any]) -> DeskState:
    """Return a state as it is declared, whole: nothing on the desk is touched before.

    Raises
    ------
    Refused
        If it is none, or of another version.
    """
    if kept.get("version", VERSION) != VERSION:
        raise RequestRefused(
            f"this is the state of another version ({shorten_value(kept['version'])})"
        )
    return check_declared(DeskState, kept, "the state of a workbench")


def _at(opened: list[Opened | None], place: int | None) -> Opened | None:
    return opened[place] if place is not None and 0 <= place < len(opened) else None


def pack_state(desk: Desk) -> bytes:
    """Return the desk and all its recordings as one file."""
    told = state(desk)
    buffer = BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, strict_timestamps=False) as archive:
        for kind in ("files", "effects"):
            for number, each in enumerate(told[kind]):
                path = Path(each["path"] if kind == "files" else each)
                if path.is_dir():
                    raise RequestRefused(
                        f"{path.name} is a folder: keep it with the state by yourself"
                    )
                member = f"{kind}/{number}/{plain(path.name)}"
                archive.write(path, member)
                if kind == "files":
                    told[kind][number] |= {"path": member, "owned": True}
                else:
                    told[kind][number] = member
        archive.writestr(MEMBER, json.dumps(told, indent=1))
    return buffer.getvalue()


def unpack_state(path: Path, folder: Path) -> dict[str, Any]:
    """Unpack a state's recordings into a folder, and return it with their paths.

    Effects of one's own are unpacked, but not named: a user who opens a file has not agreed to run
    a program in it.

    Raises
    ------
    Refused
        If it is no such file, damaged, or unpacks to more than a recording may have.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            told = as_object(_text(archive, MEMBER), MEMBER)
            _check_state(told)
            for number, each in enumerate(told["files"]):
                each["path"] = str(_unpack_member(archive, each["path"], folder / str(number)))
                each["owned"] = True
            own = [_text(archive, name) for name in told["effects"]]
    except RequestRefused:
        raise
    except ARCHIVE_ERRORS as error:
        raise RequestRefused(f"{path.name} is no state of a workbench: {error}") from None
    return {**told, "effects": [], "programs": own}


def _text(archive: zipfile.ZipFile, member: str) -> str:
    if archive.getinfo(member).file_size > LONGEST_MEMBER:
        raise RequestRefused(f"this is no state of a workbench: {member} is too long")
    return archive.read(member).decode()


def _unpack_member(archive: zipfile.ZipFile, member: str, folder: Path) -> Path:
    info = archive.getinfo(member)
    if info.file_size > LARGEST_UPLOAD:
        raise RequestRefused(f"a recording in it has more than {LARGEST_UPLOAD / 1e6:.0f} MB")
    folder.mkdir(parents=True, exist_ok=True)
    # By its last part alone: a member's name may point anywhere.
    path = folder / plain(member)
    left = info.file_size
    with archive.open(info) as source, path.open("wb") as file:
        while left and (part := source.read(min(left, 2**20))):
            file.write(part)
            left -= len(part)
    return path
