"""What is said of the golden records, as tables; and as JSON, for a later comparison.

Contents: how a result looks and is read again.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path

import numpy as np
from rich.markup import escape
from rich.table import Table

from benchmarks.golden.compared import changes, ratio
from benchmarks.golden.told import Told

#: Key of the golden records in a file of results.
KEY = "golden"


def kept(found: Mapping[str, Told]) -> dict[str, dict[str, object]]:
    """Return a result as JSON holds it."""
    return {name: asdict(told) for name, told in found.items()}


def read(path: Path) -> dict[str, Told]:
    """Return an earlier result.

    Raises
    ------
    SystemExit
        If the file holds none.
    """
    try:
        return {
            name: Told(**told)
            for name, told in json.loads(path.read_text(encoding="utf-8"))[KEY].items()
        }
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise SystemExit(f"benchmarks: {path} is no result of `golden`: {error}") from None


def tables(found: Mapping[str, Told]) -> Iterator[Table]:
    """Yield what is said of each record, and the sums of each set."""
    yield _records(found)
    yield _sums(found)


def _records(found: Mapping[str, Told]) -> Table:
    made = Table("record", "verdict", "effects", "P", "revisions", title="Golden records")
    made.title_justify = "left"
    for column in ("responses", "s", ""):
        made.add_column(column, justify="right")
    for name, told in found.items():
        likely = max(told.probabilities.values(), default=0.0)
        cells = (told.verdict, "\n".join(told.effects), f"{likely:.2f}", "\n".join(told.revisions))
        numbers = (f"{told.responses:.0f}", f"{told.seconds:.1f}", "" if told.right else "WRONG")
        made.add_row(escape(name), *cells, *numbers)
    made.caption = "P: of the most probable effect; s: processor time"
    made.caption_justify = "left"
    return made


def _sums(found: Mapping[str, Told]) -> Table:
    made = Table("set", title="Golden records, in all", title_justify="left")
    for column in ("records", "right", "refused", "responses", "median", "processor [s]", "median"):
        made.add_column(column, justify="right")
    sets = dict.fromkeys(name.split()[0] for name in found)
    for each in (*sets, ""):
        own = [told for name, told in found.items() if name.startswith(each)]
        responses, seconds = ([getattr(t, k) for t in own] for k in ("responses", "seconds"))
        made.add_row(
            each or "in all", str(len(own)), str(sum(told.right for told in own)),
            str(sum(bool(told.refused) for told in own)),
            f"{sum(responses):.0f}", f"{np.median(responses):.0f}",
            f"{sum(seconds):.0f}", f"{np.median(seconds):.2f}",
        )  # fmt: skip
    return made


def differences(before: Mapping[str, Told], after: Mapping[str, Told]) -> Iterator[Table]:
    """Yield what differs from an earlier result, record by record, and in work and time."""
    made = Table("record", "before -> after", title="Changed records", title_justify="left")
    found = changes(before, after)
    for change in found:
        kinds = "\n".join(
            f"{kind}: {told}" if told else kind for kind, told in change.kinds.items()
        )
        made.add_row(escape(change.name), escape(kinds))
    both, one = set(before) & set(after), set(before) ^ set(after)
    made.caption = f"{len(found)} of {len(both)} records; {len(one)} are in one of the results only"
    yield made
    ratios = Table("after / before", "sums", "median", title="Work and time", title_justify="left")
    for kind, title in (("responses", "responses"), ("seconds", "processor time")):
        if told := ratio(before, after, kind):
            ratios.add_row(title, f"{told.sums:.3f}", f"{told.median:.3f}")
    yield ratios
