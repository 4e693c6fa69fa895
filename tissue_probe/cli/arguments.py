"""Arguments that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Bag = Annotated[
    Path,
    typer.Argument(
        help="Recording: an .mcap, .db3 or ROS 1 .bag file, or a bag folder.", metavar="BAG"
    ),
]

Samples = Annotated[
    Path,
    typer.Argument(
        help="Recording (.mcap, .db3, bag folder), or .csv with time [s], position [m], force [N].",
        metavar="SAMPLES",
    ),
]

Table = Annotated[
    Path,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE",
        help="Table to write: .csv or .parquet; replaced if there.",
    ),
]

Topic = Annotated[
    str | None,
    typer.Option(metavar="TOPIC", help="Topic of the samples, where the recording has several."),
]
