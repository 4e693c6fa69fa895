"""Our diagnosis of a set, and its law asked for by name: what they say, and how they do on tests.

Contents: one diagnosis, one fit of the law, and the model of the last step on each test.
"""

from __future__ import annotations

import time
from pathlib import Path

import tissue_probe as tp
from benchmarks.beside.data import Set
from benchmarks.beside.results import Result, scored

DIAGNOSIS, LAW = "tissue_probe diagnose", "tissue_probe improve, the law by name"


def diagnose(of: Set, data: Path) -> Result:
    """Diagnose the record to learn from, and predict the tests with the model that is left."""
    return _learn(DIAGNOSIS, of, data, ())


def fit_law(of: Set, data: Path) -> Result:
    """Fit the law of the set's authors, asked for by name, and predict the tests with it."""
    return _learn(LAW, of, data, of.law)


def _learn(tool: str, of: Set, data: Path, law: tuple[str, ...]) -> Result:
    """Learn a model; of a test the state at its first sample is estimated, and nothing else."""
    begun = time.process_time()
    found = tp.diagnose(_read(of.path(data)), rig="force_driven", add=list(law), workers=1)
    seconds = time.process_time() - begun
    errors = []
    for test in of.tests:
        moved = tp.compare(_read(of.path(data, test)), model=found.model, workers=1)
        errors.append(scored(moved.fit.residuals[0], of.per_unit))
    says = f"{found.verdict}: {', '.join(found.effects) or 'none'}"
    return Result(of.name, tool, says, tuple(errors), seconds)


def _read(path: Path) -> tp.Measurements:
    return tp.read(path, force_polarity="compression")
