"""The worker's tasks: calls of the Python interface, each by a name.

Contents: these calls.
"""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import tissue_probe as tp
from tissue_probe.analysis.choices import OWN_RIG
from tissue_probe.analysis.passing import from_bytes, to_bytes
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from tissue_probe.analysis.comparing import ComparisonResult, Fit
    from tissue_probe.analysis.diagnosing import DiagnosisResult
    from tissue_probe.analysis.mapping import MapResult
    from tissue_probe.analysis.measurements import Measurements
    from tissue_probe.analysis.previewing import Preview

Tell = Callable[[dict[str, Any]], None]
"""Called with the step under way."""


@dataclass(frozen=True)
class Work:
    """One call: its name in ``CALLS`` and its arguments; the effects' files that it needs."""

    name: str
    arguments: Mapping[str, Any]
    effects: tuple[str, ...] = ()

    def to_bytes(self) -> bytes:
        """Return it as ``do`` takes it."""
        return to_bytes((self.effects, to_bytes((self.name, dict(self.arguments)))))


def do(content: bytes, tell: Any) -> bytes:
    """Make a call, and return its result as bytes."""
    effects, inner = from_bytes(content)
    name, arguments = from_bytes(inner, effects)
    return to_bytes(CALLS[name](tell=tell, **arguments))


def warm_reading(tell: Tell) -> Measurements:
    """Load the modules that reading a table needs."""
    rows = [(n / 500.0, 1e-3 * math.sin(0.1 * n)) for n in range(500)]
    lines = [f"{t},{u},{500.0 * u}" for t, u in rows]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "warm.csv"
        path.write_text("\n".join(["t,u,F", *lines]) + "\n")
        return tp.read(path)


def warm(tell: Tell) -> ComparisonResult:
    """Load the modules that every fit needs; compile the code that all models share."""
    return tp.compare(warm_reading(tell), rig=OWN_RIG)


def warm_effects(tell: Tell) -> ComparisonResult:
    """Load the library of effects, and the integrator of nonlinear models."""
    return warm(tell).plus("cubic_stiffening")


def preview(tell: Tell, path: str) -> Preview:
    """See ``tissue_probe.preview``."""
    return tp.preview(path)


def read(tell: Tell, path: str, layout: Mapping[str, Any]) -> Measurements | None:
    """See ``tissue_probe.read``; None of a table of sites, which has no samples."""
    told = -1

    def advance(share: float) -> None:
        nonlocal told
        if (percent := int(100 * share)) > told:
            told = percent
            tell({"share": share})

    try:
        return tp.read(path, **layout, progress=advance)
    except tp.TissueProbeError:
        from tissue_probe.analysis.mapping import is_sites

        if is_sites(path):
            return None
        raise


def compare(tell: Tell, measured: Measurements, asked: Mapping[str, Any]) -> ComparisonResult:
    """See ``tissue_probe.compare``."""
    return tp.compare(measured, **asked)


def add(tell: Tell, compared: ComparisonResult, effect: str, begin: Fit | None) -> ComparisonResult:
    """Return the next rung; where a ranking knows it, the search begins there."""
    return compared.plus(effect, begin)


def rank(
    tell: Tell,
    measured: Measurements,
    second: Measurements | None,
    asked: Mapping[str, Any],
    folder: str,
) -> DiagnosisResult:
    """See ``tissue_probe.diagnose``; each effect's prediction is kept in the folder meanwhile."""

    def note_found(effect: str, fit: Fit) -> None:
        # Forms of an effect are found one by one, here and in a copy of this process.
        error = Path(folder) / f"{effect}.error"
        if error.exists() and not fit.rmse < np.fromfile(error)[0]:
            return
        keep(error, np.array([fit.rmse]))
        keep_predicted(Path(folder), effect, fit.predicted)
        tell({"effect": effect, "rmse": fit.rmse, "heldout_rmse": fit.heldout_rmse})

    def progress(doing: str) -> None:
        tell({"doing": doing})

    return tp.diagnose(measured, validate=second, progress=progress, found=note_found, **asked)


def keep_predicted(folder: Path, effect: str, predicted: Sequence[Any]) -> None:
    """Keep a file a stretch."""
    for number, course in enumerate(predicted):
        keep(predict_file(folder, effect, number), np.asarray(course))


def keep(path: Path, numbers: FloatArray) -> None:
    """Write a file in one motion: a reader never sees half of it."""
    part = path.with_name(f"{path.name}.{os.getpid()}")
    numbers.tofile(part)
    part.replace(path)


def predict_file(folder: Path, effect: str, stretch: int) -> Path:
    """Return where it is kept, as numbers of eight bytes."""
    return folder / f"{effect}.{stretch}.f8"


def scan(tell: Tell, measured: Measurements | str) -> MapResult:
    """See ``tissue_probe.map``; where a scan has no recorded estimates, they are made."""
    try:
        return tp.map(measured)
    except tp.TissueProbeError:
        if isinstance(measured, str):
            raise
        tell({"doing": "stiffness is estimated at each site"})
        return tp.map(measured, estimators=["robust_ekf"])


def check_effects(tell: Tell, path: str) -> list[dict[str, Any]]:
    """Run a file of effects, and return those that it adds to the library."""
    known = {row["name"] for row in tp.effects()}
    return [row for row in tp.effects([path]) if row["name"] not in known]


def report(
    tell: Tell,
    measured: Measurements,
    second: Measurements | None,
    asked: Mapping[str, Any],
    added: Sequence[str],
) -> bytes:
    """Return the report of a ladder as one page of HTML."""
    result = tp.diagnose(
        measured,
        validate=second,
        add=added,
        progress=lambda doing: tell({"doing": doing}),
        **asked,
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "report.html"
        result.report(path)
        return path.read_bytes()


#: Those that read, and fit nothing.
READING = ("warm_reading", "preview", "read")
CALLS: Mapping[str, Callable[..., Any]] = {
    each.__name__: each
    for each in (
        *(warm_reading, warm, warm_effects),
        *(preview, read, compare, add, rank, scan, check_effects, report),
    )
}
