"""Storage and loss of a study's recordings over the frequency that drove each, for its page."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from tissue_probe.quantities import SIDE
from tissue_probe.report.frequency_plot import GROUPS, FrequencyPlot, FrequencyPoint
from tissue_probe.studies.exclusion import explain_exclusion
from tissue_probe.studies.result import deviation_of

FREQUENCY_PARTS = {"storage": "Storage k", "loss": "Loss 2πfβ"}


def plots_over_frequency(
    rows: Sequence[Mapping[str, Any]], by: str | None, links: Mapping[str, str]
) -> Iterator[FrequencyPlot]:
    """Yield a plot of the storage and one of the loss; none where no row has them.

    Parameters
    ----------
    rows : sequence of mapping
        Of a study; those that no statistics take are not drawn.
    by : str, optional
        The factor whose groups are told apart.
    links : mapping of str to str
        A page about each recording by its path; empty for none.
    """
    used = [each for each in rows if "frequency" in each and not explain_exclusion(each)]
    if by:  # as its statistics do
        used = [each for each in used if by in each]
    groups = sorted({str(each[by]) for each in used}) if by else []
    shown = groups if len(groups) <= GROUPS else []
    for name, title in FREQUENCY_PARTS.items():
        points = [_point(each, name, by, shown, links) for each in used if _is_drawable(each, name)]
        if points:
            note = _note(len(used) - len(points), by, groups, shown)
            yield FrequencyPlot(f"{title} over frequency", "N/m", note, points, shown)


def _is_drawable(row: Mapping[str, Any], name: str) -> bool:
    sd = row.get(deviation_of(name), math.nan)
    return math.isfinite(sd) and math.isfinite(row[name]) and row[name] > 0.0


def _point(
    row: Mapping[str, Any],
    name: str,
    by: str | None,
    shown: Sequence[str],
    links: Mapping[str, str],
) -> FrequencyPoint:
    value, half = row[name], SIDE * row[deviation_of(name)]
    group = shown.index(str(row[by])) if by and shown else 0
    path = row["path"]
    return FrequencyPoint(
        Path(path).name, row["frequency"], value, value - half, value + half, group, links[path]
    )


def _note(away: int, by: str | None, groups: Sequence[str], shown: Sequence[str]) -> str:
    said = [
        "Of recordings that one frequency drives, on Kelvin-Voigt tissue: parts of the fitted "
        "model's complex stiffness k + i 2πfβ. Bars: 95 % intervals. Both axes are logarithmic."
    ]
    if away:
        said.append(f"Not drawn, since the value is not above 0 or its error not known: {away}.")
    if groups and not shown:
        said.append(f"The {len(groups)} groups of {by} are too many to be told apart here.")
    return " ".join(said)
