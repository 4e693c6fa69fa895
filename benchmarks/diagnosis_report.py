"""The battery of challenges as tables: what was to be reached, the suite, sparse regression.

Contents: rows, and the confusion matrix.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import asdict

import numpy as np
from rich.table import Table

from benchmarks.diagnosis import Battery
from benchmarks.ruler import probabilities
from tissue_probe.challenge.grading import Count, Grade
from tissue_probe.challenge.outside import OUTSIDE

#: Marks, what they are called, and what is to be reached on the exact and on the tolerant rig.
ROWS = (
    ("first", "right effect first", ">= 97 %", ">= 85 %"),
    ("first_three", "right effect among the first three", ">= 99 %", ">= 92 %"),
    ("first_three_named", "  by a verdict that names one", "", ""),
    ("declared", "right first, or declared not to be told", "", ">= 98 %"),
    ("family", "an effect of its family first", "", ""),
    ("false_alarms", "none hidden: effect found", "<= 2.5 %", "<= 2.5 %"),
    ("two", "two hidden: both named", ">= 85 %", ">= 85 %"),
    ("two_declared", "two hidden: one named, the other too or declared", "", ""),
    ("one_of_two", "two hidden: at least one named", "", ""),
    ("unexplained", "outside the library: unexplained", ">= 90 %", ">= 90 %"),
    ("absorbed", "absorbed by Kelvin-Voigt: adequate, or listed", "", ""),
    ("covered", "claimed set holds the truth", ">= 97 %", ">= 97 %"),
)

#: Length of the recordings for whose time there are goals [s]; median and longest.
TIMED, GOALS = 2.0, ("<= 2", "<= 10")


def results(batteries: Mapping[str, Battery]) -> dict[str, object]:
    """Return what was measured on each rig, for the file of results."""
    return {rig: _kept(battery) for rig, battery in batteries.items()}


def _kept(battery: Battery) -> dict[str, object]:
    suite, sparse = battery.marks()
    return {
        "suite": _marks(suite),
        "sparse_regression": _marks(sparse),
        "heldout_over_noise": battery.heldout,
        "left_out_over_noise": battery.left_out,
        "seconds": battery.seconds,
        "stated": [asdict(each) for each in battery.stated],
    }


def _marks(marks: Grade) -> dict[str, object]:
    shares = {name: asdict(getattr(marks, name)) for name, *_ in ROWS}
    return {**shares, "mean_claimed": marks.mean_claimed, "confusion": marks.confusion}


def tables(batteries: Mapping[str, Battery]) -> Iterator[Table]:
    """Yield the numbers of each rig, then what was taken for what."""
    for rig, battery in batteries.items():
        yield _numbers(rig, battery)
        yield probabilities.table(f"How sure it was, {rig} rig", battery.stated)
    for rig, battery in batteries.items():
        yield _confusion(rig, battery.marks()[0])


def _numbers(rig: str, battery: Battery) -> Table:
    table = Table(title=f"Diagnosis of sealed challenges, {rig} rig", title_justify="left")
    for column in ("", "to reach", "tissue_probe", "sparse regression"):
        table.add_column(column, justify="left" if not column else "right")
    suite, sparse = battery.marks()
    for name, title, exact, tolerant in ROWS:
        goal = exact if rig == "exact" else tolerant
        table.add_row(title, goal, *(_share(getattr(marks, name)) for marks in (suite, sparse)))
    sizes = ("-" if m.mean_claimed is None else f"{m.mean_claimed:.2f}" for m in (suite, sparse))
    table.add_row("mean size of a claimed set", "<= 1.3", *sizes)
    for title, errors in (
        ("error over noise on a second recording, median", battery.heldout),
        ("error over noise on eighths left out, median", battery.left_out),
    ):
        table.add_row(title, "<= 1.05", _at(errors, 50), "")
        table.add_row("  9 of 10 below", "", _at(errors, 90), "")
    for length, seconds in sorted(battery.seconds.items()):
        goals = GOALS if length == TIMED else ("", "")
        title = f"time for {length:g} s of samples, median, s"
        table.add_row(title, goals[0], _at(seconds, 50), "")
        table.add_row("  longest, s", goals[1], _at(seconds, 100), "")
    table.caption = (
        "sparse regression: STLSQ of PySINDy on the force balance of the nominal rig\n"
        "claimed set: of one hidden effect that shows; named first or declared indistinguishable\n"
        "errors: where exactly what was hidden was added; the second recording is of a wider band"
    )
    table.caption_justify = "left"
    return table


def _confusion(rig: str, marks: Grade) -> Table:
    table = Table(title=f"What was named first, {rig} rig", title_justify="left")
    table.add_column("hidden")
    table.add_column("times", justify="right")
    table.add_column("right", justify="right")
    table.add_column("otherwise")
    for hidden, named in sorted(marks.confusion.items()):
        right = Counter({name: n for name, n in named.items() if name in _answers(hidden)})
        others = ", ".join(f"{name} {n}" for name, n in (named - right).most_common())
        table.add_row(hidden, str(named.total()), str(right.total()), others)
    return table


def _answers(hidden: str) -> list[str]:
    """Return what may be named first."""
    if hidden in OUTSIDE:
        return ["unexplained"]
    return ["adequate"] if hidden == "none" else hidden.split(" + ")


def _share(count: Count) -> str:
    return "-" if not count.total else f"{count.right} of {count.total}, {100 * count.share:.0f} %"


def _at(values: list[float], percentile: float) -> str:
    return f"{np.percentile(values, percentile):.2f}" if values else "-"
