"""An error as one line for the user.

Contents: that alone, of any error.
"""

from __future__ import annotations


def sentence(error: Exception) -> str:
    """Return an error's text on one line, without the number of an operating system's error."""
    told = str(error)
    if isinstance(error, OSError) and error.filename and error.strerror:
        told = f"{error.filename}: {error.strerror}"
    return " ".join(told.split())
