"""A recording on the desk: its file, how it is read, and the reason if it cannot be."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tissue_probe.analysis.measurements import Measurements
from tissue_probe.analysis.previewing import Preview
from tissue_probe.errors import ParameterError
from tissue_probe.recording.layout import STATEMENT_KINDS
from tissue_probe.workbench import form_values
from tissue_probe.workbench.refusal import RequestRefused

#: Statements that a page writes as text, and that are numbers.
TYPED_NUMBERS = ("sample_rate",)


@dataclass
class Opened:
    """A recording on the desk.

    Attributes
    ----------
    number : int
        By which pages call it: they never name a path.
    path : Path
        Its file.
    name : str
        The file's name, as shown.
    layout : dict
        The user's statements on it.
    owned : bool
        Whether it was dropped on the page, so that its copy is the server's to remove.
    measured : Measurements or None
        Once it is read.
    table : bool
        Whether it is a table of sites: it has a map, and no samples.
    preview : Preview or None
        Where it could not be read as it is.
    problem : Refused or None
        Why not.
    """

    number: int
    path: Path
    name: str
    layout: dict[str, Any] = field(default_factory=dict)
    owned: bool = False
    measured: Measurements | None = None
    table: bool = False
    preview: Preview | None = None
    problem: RequestRefused | None = None


def check_layout(given: dict[str, Any]) -> dict[str, Any]:
    """Return a page's statements on a file, as ``tissue_probe.read`` takes them; blanks left out.

    Raises
    ------
    Refused
        If something is no parameter, or has no such value.
    """
    found: dict[str, Any] = {}
    for name, value in given.items():
        if name not in STATEMENT_KINDS:
            raise RequestRefused(f"there is no parameter {name} of reading")
        known = (form_values.number if name in TYPED_NUMBERS else form_values.text)(name, value)
        if known is None:
            continue
        try:
            found[name] = STATEMENT_KINDS[name](name, known)
        except ParameterError as error:
            raise RequestRefused(str(error)) from None
    return found
