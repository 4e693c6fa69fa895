"""Our diagnosis of a set: what it says, and how its model does on the tests.

Contents: one diagnosis, and the model of its last step on each test.
"""

from __future__ import annotations

import time
from pathlib import Path

import tissue_probe as tp
from benchmarks.beside.data import Set
from benchmarks.beside.results import Result, scored


def measure(of: Set, data: Path) -> Result:
    """Diagnose the record to learn from, and predict the tests with the model that is left.

    Of a test the state at its first sample is estimated, and nothing else.
    """
    begun = time.process_time()
    found = tp.diagnose(_read(of.path(data)), rig="force_driven", workers=1)
    seconds = time.process_time() - begun
    errors = []
    for test in of.tests:
        moved = tp.compare(_read(of.path(data, test)), model=found.model, workers=1)
        errors.append(scored(moved.fit.residuals[0], of.per_unit))
    says = f"{found.verdict}: {', '.join(found.effects) or 'none'}"
    return Result(of.name, "tissue_probe diagnose", says, tuple(errors), seconds)


def _read(path: Path) -> tp.Measurements:
    return tp.read(path, force_polarity="compression")
