"""Marks of many maps as tables, each number with its sampling error.

Contents: sums, errors, tables.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from rich.markup import escape
from rich.table import Table

from benchmarks.maps.marks import DISAGREE, Marks

BINS = ((0.0, 0.2), (0.2, 0.5), (0.5, 0.8), (0.8, 0.95), (0.95, 1.0001))


def told(values: Iterable[float]) -> str:
    """Return a mean and its standard error."""
    known = np.array([each for each in values if each is not None and np.isfinite(each)])
    if not known.size:
        return "-"
    error = known.std(ddof=1) / math.sqrt(known.size) if known.size > 1 else math.nan
    return f"{known.mean():.3f} ± {error:.3f}"


def span(values: Sequence[float]) -> str:
    """Return the least and the largest of some values."""
    return f"{min(values):.1f} to {max(values):.1f}" if values else "-"


def share(hits: int, of: int) -> str:
    """Return a share and its standard error, by Agresti and Coull."""
    if not of:
        return "-"
    middle = (hits + 2.0) / (of + 4.0)
    return f"{hits / of:.3f} ± {math.sqrt(middle * (1.0 - middle) / (of + 4.0)):.3f}"


def _all(marks: Sequence[Marks], name: str) -> list:
    return [each for one in marks for each in getattr(one, name)]


def _sum(marks: Sequence[Marks], name: str) -> int:
    return sum(getattr(one, name) for one in marks)


#: What is told of a set of maps, by its title.
ROWS: Mapping[str, Callable[[Sequence[Marks]], str]] = {
    "maps; nodules": lambda m: f"{len(m)}; {_sum(m, 'nodules')}",
    "recall, declared at P >= .9": lambda m: share(_sum(m, "hits"), _sum(m, "nodules")),
    "of strong ones": lambda m: share(_sum(m, "strong_hits"), _sum(m, "strong")),
    "false inclusions a map": lambda m: told([one.false for one in m]),
    "inclusions declared a map": lambda m: told([one.hits + one.false for one in m]),
    "the one nodule, alone": lambda m: (
        share(sum(one.hits == 1 and not one.false for one in m), len(m))
        if all(one.nodules == 1 for one in m)
        else "-"
    ),
    "sites palpated again a map": lambda m: (
        told([one.again for one in m]) if _sum(m, "again") else "-"
    ),
    "location [mm]": lambda m: told(_all(m, "location")),
    "middle in its ellipse of 95 %": lambda m: share(
        sum(_all(m, "within")), len(_all(m, "within"))
    ),
    "boundary, 95 % Hausdorff [mm]": lambda m: told(_all(m, "hausdorff")),
    "Dice": lambda m: told(_all(m, "dice")),
    "all of it within the boundary of 95 %": lambda m: share(
        sum(_all(m, "held")), len(_all(m, "held"))
    ),
    "surface within 2 sd": lambda m: told([one.covered for one in m]),
    "inside nodules": lambda m: told([one.covered_in for one in m]),
    "an inclusion where none could hide": lambda m: share(
        sum(bool(one.hidden) for one in m), sum(one.hidden is not None for one in m)
    ),
    "chains disagree by more than .05": lambda m: share(
        sum(one.disagreement > DISAGREE for one in m),
        sum(np.isfinite(one.disagreement) for one in m),
    ),
    "spheres feel so many times stiffer": lambda m: span(_all(m, "felt")),
    "processor time [ms], median": lambda m: f"{1e3 * np.median([one.seconds for one in m]):.0f}",
    "longest of 95 %": lambda m: f"{1e3 * np.quantile([one.seconds for one in m], 0.95):.0f}",
}


def table(title: str, sets: Mapping[str, Sequence[Marks]]) -> Table:
    """Return a table with a column a set of maps."""
    found = Table("", *sets, title=title)
    for name, of in ROWS.items():
        cells = [of(marks) for marks in sets.values()]
        if set(cells) != {"-"}:
            found.add_row(escape(name), *cells)
    return found


def stated(sets: Mapping[str, Sequence[Marks]]) -> Table:
    """Return stated probability against share right."""
    found = Table("stated", *sets, title="Stated probability against share right")
    for low, high in BINS:
        cells = []
        for marks in sets.values():
            inside = [each for each in _all(marks, "stated") if low <= each[0] < high]
            right = share(sum(hit for _, hit in inside), len(inside))
            mean = np.mean([p for p, _ in inside]) if inside else math.nan
            cells.append(f"{mean:.2f}: {right} of {len(inside)}")
        found.add_row(f"{low:g} to {min(high, 1.0):g}", *cells)
    return found
