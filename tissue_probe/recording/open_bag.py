"""Opening a bag by what it is, not by what it is called.

What belongs here: telling formats apart, and what to say of those that are not read.
What does not: reading them.
"""

from __future__ import annotations

from pathlib import Path

from mcap.writer import MCAP0_MAGIC

from tissue_probe.recording.bag import Bag
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.folder_bag import FolderBag
from tissue_probe.recording.mcap_bag import McapBag
from tissue_probe.recording.ros1_bag import Ros1Bag
from tissue_probe.recording.sqlite_bag import SqliteBag

_SQLITE_MAGIC = b"SQLite format 3\0"
_ROS1_MAGIC = b"#ROSBAG V"
_CALLED = (".mcap", ".db3", ".bag")


def open_bag(path: str | Path) -> Bag:
    """Open an MCAP file (complete or cut off), a ``.db3`` file, a bag folder, or a ROS 1 bag.

    Raises
    ------
    RecordingError
        If it is none of these, or cannot be read.
    FileNotFoundError
        If nothing has that name.
    """
    path = Path(path)
    if path.is_dir():
        return _open_folder(path)
    with path.open("rb") as file:
        head = file.read(16)
    if head.startswith(MCAP0_MAGIC):
        return McapBag(path)
    if head.startswith(_SQLITE_MAGIC):
        return SqliteBag(path)
    if head.startswith(_ROS1_MAGIC):
        return Ros1Bag(path)
    raise RecordingError(f"{path} {_what_is_wrong(path, head)}")


def is_bag(path: str | Path) -> bool:
    """Whether a file or folder is, or is called, a bag; others may be tables.

    Raises
    ------
    FileNotFoundError
        If nothing has that name.
    """
    path = Path(path)
    if path.is_dir():
        return True
    with path.open("rb") as file:
        head = file.read(16)
    return head.startswith((MCAP0_MAGIC, _SQLITE_MAGIC, _ROS1_MAGIC)) or path.suffix in _CALLED


def _open_folder(path: Path) -> Bag:
    files = sorted(file for file in path.iterdir() if file.suffix in (".mcap", ".db3"))
    if not files:
        raise RecordingError(
            f"{path} is a folder without a bag (no .mcap or .db3 in it); "
            "give a recorded file or its folder"
        )
    if not (path / "metadata.yaml").is_file():  # perhaps a folder of separate runs
        raise RecordingError(
            f"{path} is a folder without metadata.yaml; give one of its files "
            f"({', '.join(file.name for file in files)}), or run 'ros2 bag reindex {path}'"
        )
    return FolderBag([open_bag(file) for file in files])


def _what_is_wrong(path: Path, head: bytes) -> str:
    if not head:
        return "is empty: nothing was recorded; record again"
    return "is not an MCAP file, nor another bag of ROS; give what the recorder wrote"
