"""``python -m benchmarks study``: speed, and statistics that hold, beside what is to be reached."""

from __future__ import annotations

from collections.abc import Callable

from rich.markup import escape
from rich.table import Table

from benchmarks.studies import sealed, speed
from benchmarks.studies.parts import results_of


def measure(count: int, say: Callable[[str], None] = print) -> dict[str, dict[str, float]]:
    """Return the results by part and name; a part that fails has none.

    Parameters
    ----------
    count : int
        Recordings of the study whose time is taken.
    say : callable
        Told what is under way.
    """
    return {
        "sealed": results_of(lambda: sealed.measure(say=say), say),
        "speed": speed.measure(count, say),
    }


def tables(found: dict[str, dict[str, float]]) -> list[Table]:
    """Return the results beside what is to be reached."""
    shown = []
    for part, title in ((speed, "Many recordings"), (sealed, "Sealed studies")):
        results = found[part.__name__.rpartition(".")[2]]
        table = Table(title=title, title_justify="left")
        for column in ("", "measured", "to reach"):
            table.add_column(column, justify="right" if column else "left")
        for name, goal in part.goals(results).items():
            table.add_row(escape(name), f"{results[name]:.4g}", goal)
        shown.append(table)
    return shown
