"""A bag that ``ros2 bag`` split over the files of a folder.

Contents: which files they are, and putting them together.

``rosbags`` reads folders too, but silently leaves out every topic whose QoS is written otherwise
in ``metadata.yaml`` than in the file, which converted bags often have.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path, PurePath

from tissue_probe import bounded_yaml
from tissue_probe.recording.bags.bag import Bag, RawMessage
from tissue_probe.recording.errors import RecordingError

_log = logging.getLogger(__name__)

METADATA = "metadata.yaml"
"""The file that ``ros2 bag`` writes beside the others."""

_FILE_PATTERN = re.compile(r".*\.(mcap|db3)(\.zstd)?")


class FolderBag:
    """Bags, at least one, as one (``bag.Bag``): one after the other."""

    def __init__(self, bags: Sequence[Bag]) -> None:
        self._bags = bags
        self.profile = bags[0].profile
        self.topics = tuple(dict.fromkeys(topic for bag in bags for topic in bag.topics))
        self.metadata = {name: values for bag in bags for name, values in bag.metadata.items()}
        self.truncated = any(bag.truncated for bag in bags)

    def messages(self, topics: Collection[str]) -> Iterator[RawMessage]:
        """Yield the messages of the topics so named, in the order in which they were stored."""
        for bag in self._bags:
            yield from bag.messages(topics)

    def count(self, topics: Collection[str]) -> int:
        """Return how many messages of the topics so named there are."""
        return sum(bag.count(topics) for bag in self._bags)


def files_of(folder: Path) -> list[Path]:
    """Return the files of a folder that ``ros2 bag`` wrote, in the order in which it did.

    All that lie there, with a warning if ``metadata.yaml`` says otherwise.

    Raises
    ------
    RecordingError
        If there are none, or several and no ``metadata.yaml``: they may be separate runs.
    """
    found = sorted(
        (file for file in folder.iterdir() if _FILE_PATTERN.fullmatch(file.name)), key=_number
    )
    packed = {file.name for file in found}
    files = [file for file in found if f"{file.name}.zstd" not in packed]
    if not files:
        raise RecordingError(
            f"{folder} is a folder without a bag (no .mcap or .db3 in it); "
            "give a recorded file or its folder"
        )
    if not (folder / METADATA).is_file() and len(files) == 1:
        _log.warning("%s has no %s: its recorder was killed, perhaps", folder, METADATA)
        return files
    if not (folder / METADATA).is_file():  # perhaps a folder of separate runs
        raise RecordingError(
            f"{folder} is a folder without {METADATA}; give one of its files "
            f"({', '.join(file.name for file in files)}), or run 'ros2 bag reindex {folder}'"
        )
    listed = _list_files(folder / METADATA)
    if listed is None:
        return files
    if missing := sorted(set(listed) - {file.name for file in files}):
        _log.warning("%s lists %s, missing there", folder / METADATA, ", ".join(missing))
    if more := [file.name for file in files if file.name not in listed]:
        _log.warning(
            "%s does not list %s; read too, as all files that lie there",
            folder / METADATA,
            ", ".join(more),
        )
    order = {name: number for number, name in enumerate(listed)}
    return sorted(files, key=lambda file: order.get(file.name, len(order)))


def _number(file: Path) -> list[tuple[int, str]]:
    """Return a key that puts file 10 after file 9."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in _PARTS.split(file.name)]


_PARTS = re.compile(r"(\d+)")


def _list_files(metadata: Path) -> list[str] | None:
    """Return the names of the files that the metadata list; None, with a warning, if not told."""
    try:
        read = bounded_yaml.read(metadata)
        paths = read["rosbag2_bagfile_information"]["relative_file_paths"] if read else None
        return None if paths is None else [PurePath(path).name for path in paths]
    except (ValueError, KeyError, TypeError) as error:
        _log.warning(
            "%s is not understood, and not used (%s)", metadata, str(error).replace("\n", " ")
        )
        return None
