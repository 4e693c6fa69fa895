"""The one family of errors that tell a user something to mend.

Contents: the family, and its members that no package has to itself.
"""

from __future__ import annotations

from pathlib import Path


class TissueProbeError(ValueError):
    """Something that the user can mend; the message is a sentence: where, the fault, the remedy.

    A parameter is named in backticks, as Python knows it (`sample_rate`); the command line writes
    its option instead.
    """


class ParameterError(TissueProbeError):
    """A parameter has a value that it cannot have, or contradicts another one."""


class MeasurementError(TissueProbeError):
    """The samples, or the model together with them, are such that a fit would be worthless."""


class FileError(TissueProbeError, OSError):
    """A file cannot be read or written; told as the operating system does, and of both families."""

    def __reduce__(self) -> tuple[type[FileError], tuple[object, ...]]:
        """Say how to make it again: Dask's pickling knows no way for two such families."""
        return type(self), self.args


class NoFileError(FileError, FileNotFoundError):
    """There is no file of a name; told as the operating system does, and of both families."""


def check_file(path: Path) -> None:
    """Refuse a path at which there is neither a file nor a folder.

    Raises
    ------
    NoFileError
        If there is none.
    """
    if not path.exists():
        raise NoFileError(f"{path}: No such file or directory")
