"""Opening a bag by its content, not by its name.

Contents: telling formats apart, and the sentence on those that are not read.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from tissue_probe.errors import check_file
from tissue_probe.recording.bags.bag import Bag
from tissue_probe.recording.bags.folder_bag import FolderBag, files_of
from tissue_probe.recording.bags.unpacking import is_packed, unpack_file
from tissue_probe.recording.errors import RecordingError

_BAG_ENDINGS = (".mcap", ".db3", ".bag", ".zstd")
_MCAP, _SQLITE, _ROS1 = _MAGICS = (b"\x89MCAP0\r\n", b"SQLite format 3\0", b"#ROSBAG V")


def open_bag(path: str | Path) -> Bag:
    """Open an MCAP file (complete or cut off), a ``.db3`` file, a bag folder, or a ROS 1 bag.

    A file may be packed by zstd as a whole, as ``ros2 bag`` does with ``--compression-mode file``.

    Raises
    ------
    RecordingError
        If it is none of these, cannot be read, or unpacks to more than a measurement holds.
    NoFileError
        If nothing has that name.
    """
    path = Path(path)
    if path.is_dir():
        return FolderBag([open_bag(file) for file in files_of(path)])
    if is_packed(_head(path)):
        return _PackedBag(path)
    return _open_file(path, path)


def is_bag(path: str | Path) -> bool:
    """Whether a file or folder is, or is called, a bag; others may be tables.

    Raises
    ------
    NoFileError
        If nothing has that name.
    """
    path = Path(path)
    if path.is_dir():
        return True
    head = _head(path)
    return head.startswith(_MAGICS) or is_packed(head) or path.suffix in _BAG_ENDINGS


def _open_file(path: Path, name: Path) -> Bag:
    head = _head(path)
    if head.startswith(_MCAP):
        from tissue_probe.recording.bags.mcap_bag import McapBag

        return McapBag(path, name)
    if head.startswith(_SQLITE):
        from tissue_probe.recording.bags.sqlite_bag import SqliteBag

        return SqliteBag(path, name)
    if head.startswith(_ROS1):
        from tissue_probe.recording.bags.ros1_bag import Ros1Bag

        return Ros1Bag(path, name)
    raise RecordingError(f"{name} {_what_is_wrong(head)}")


def _head(path: Path) -> bytes:
    check_file(path)
    with path.open("rb") as file:
        return file.read(16)


class _PackedBag(FolderBag):
    """A bag out of a file that is packed as a whole, unpacked beside other temporary files."""

    def __init__(self, path: Path) -> None:
        self._folder = TemporaryDirectory(prefix="tissue_probe")  # goes with this object
        unpacked = Path(self._folder.name, path.stem)
        with unpacked.open("wb") as file:
            unpack_file(path, file)
        super().__init__([_open_file(unpacked, path)])


def _what_is_wrong(head: bytes) -> str:
    if not head:
        return "is empty: nothing was recorded; record again"
    return "is not an MCAP file, nor another bag of ROS; give the file or folder of the recorder"
