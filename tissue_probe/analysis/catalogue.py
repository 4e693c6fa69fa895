"""The effects and estimators that can be chosen, as tables."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tissue_probe import arguments as take
from tissue_probe.analysis.result_table import Column, ResultTable
from tissue_probe.estimation import ESTIMATORS
from tissue_probe.physics.library import effects as library


@take.checks(files=take.several(take.path, "paths"))
def effects(files: Sequence[str | Path] = ()) -> ResultTable:
    """List the effects that a model may miss: the library's, and those in files of one's own.

    Parameters
    ----------
    files : sequence of path
        Python files with effects; they are run.

    Raises
    ------
    EffectError
        If a file cannot be used.
    """
    columns = (Column("name", "effect"), Column("family", "family"), Column("physics", "physics"))
    rows = tuple((each.name, each.family, each.physics) for each in library(files).values())
    return ResultTable("Effects", columns, rows)


def estimators() -> ResultTable:
    """List the filters that estimate stiffness and damping."""
    columns = (Column("name", "estimator"), Column("summary", "summary"))
    rows = tuple((name, each.summary) for name, each in ESTIMATORS.items())
    return ResultTable("Estimators", columns, rows)
