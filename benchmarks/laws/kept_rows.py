"""Outcomes that are kept, line by line: a run that is interrupted goes on where it was.

Contents: the file of a state of the code, reading it, adding to it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import Any

from benchmarks.laws.cases import Case
from benchmarks.laws.outcome import LawOutcome, Said, ask

ROOT = Path(__file__).parents[2]
#: The code that outcomes depend on; tables and lines are made of them anew.
MADE_BY = (
    "tissue_probe",
    *(f"benchmarks/laws/{name}.py" for name in ("library", "channel", "cases", "outcome")),
)


class KeptRows:
    """The outcomes of one state of the code; those of another are in another file.

    Parameters
    ----------
    folder : Path
        Of the results.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / f"laws-{_digest_code()}.jsonl"
        self._known = {outcome.case: outcome for outcome in self._read()}

    def ask_all(self, cases: Iterable[Case]) -> Iterator[LawOutcome]:
        """Yield the outcome of each case: the one that is kept, or a new one, and keep that."""
        for case in cases:
            if case not in self._known:
                self._keep(ask(case))
            yield self._known[case]

    def _keep(self, outcome: LawOutcome) -> None:
        self._known[outcome.case] = outcome
        with self.path.open("a") as file:
            file.write(f"{json.dumps(asdict(outcome))}\n")

    def _read(self) -> Iterator[LawOutcome]:
        lines = self.path.read_text().splitlines(keepends=True) if self.path.exists() else []
        # A line without its end was being written when the run was interrupted.
        whole = [line for line in lines if line.endswith("\n")]
        if len(whole) < len(lines):
            self.path.write_text("".join(whole))
        yield from (_parse(json.loads(line)) for line in whole)


def _parse(row: dict[str, Any]) -> LawOutcome:
    case = row.pop("case")
    said, before = row.pop("said"), row.pop("before")
    return LawOutcome(
        Case(**{**case, "hidden": tuple(case["hidden"])}),
        said=_said(said),
        before=_said(before) if before else None,
        **row,
    )


def _said(row: dict[str, Any]) -> Said:
    lists = {name: tuple(row[name]) for name in ("effects", "tied", "unseen")}
    return Said(**{**row, **lists})


def _digest_code() -> str:
    """Return a short name of the code that outcomes depend on."""
    digest = sha256()
    for place in MADE_BY:
        path = ROOT / place
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(file.read_bytes())
    return digest.hexdigest()[:12]
