"""A laboratory's recordings: specimens and days."""

from __future__ import annotations

from pathlib import Path

import pytest
from laboratory import write


@pytest.fixture
def laboratory(tmp_path) -> Path:
    """Six recordings: three specimens on two days."""
    folder = tmp_path / "data"
    folder.mkdir()
    for specimen, stiffness in (("a", 300.0), ("b", 400.0), ("c", 500.0)):
        for day in (1, 2):
            write(folder / f"{specimen}_{day}.csv", stiffness, seed=ord(specimen) + day)
    return folder
