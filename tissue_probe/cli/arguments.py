"""Arguments that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer


def in_a_folder(path: Path | None) -> Path | None:
    """Return a file that is to be written; checked before an analysis that may take minutes.

    Raises
    ------
    ValueError
        If there is no such folder, or it is itself a folder.
    """
    if path and path.is_dir():
        raise ValueError(f"{path} cannot be written: it is a folder; give the name of a file")
    if path and not path.parent.is_dir():
        raise ValueError(f"{path} cannot be written: there is no folder {path.parent}; make it")
    return path


def picture(path: Path) -> Path | None:
    """Return a picture that is to be written.

    Raises
    ------
    ValueError
        If there is no such folder, or its name ends in no kind of picture.
    """
    if path.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise ValueError(f"{path} cannot be drawn: give a name that ends in .png, .svg or .pdf")
    return in_a_folder(path)


def output_file(help: str) -> Any:
    """Return the option ``--output`` of a file that is to be written; Typer has no type for it."""
    return typer.Option("--output", "-o", metavar="FILE", callback=in_a_folder, help=help)


Bag = Annotated[
    Path,
    typer.Argument(
        help="Recording: an .mcap, .db3 or ROS 1 .bag file, or a bag folder.", metavar="BAG"
    ),
]

Table = Annotated[Path, output_file("Table to write: .csv or .parquet; replaced if there.")]

EffectFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--effects",
        metavar="FILE",
        help="Python file with effects of your own, such as a model file needs; it is run. May be "
        "given several times.",
    ),
]
