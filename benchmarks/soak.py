"""The live suite, held for long: what it keeps of memory, files and threads, and what it loses.

Contents: one long run, and the target that it is held against.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from rich.table import Table

from benchmarks import recorded, suite
from benchmarks.live import SETTLING
from benchmarks.usage import holdings

ESTIMATOR = "robust_ekf"
NODES = ("driver", ESTIMATOR, "mapper", "recorder")
#: Over the last so long of the run memory must not grow: before, buffers and caches fill [s].
STEADY = 300.0
#: All nodes together are to grow by less, over that time [MB].
GROWTH = 5.0

KINDS = {"resident_megabytes": "MB", "file_descriptors": "files", "threads": "threads"}


def measure(folder: Path, minutes: float, say: Callable[[str], None] = print) -> dict[str, object]:
    """Run the suite for ``minutes``; return what it held, at three times, and what was lost.

    Parameters
    ----------
    folder : path
        Gets ``soak.mcap``, the recording.
    minutes : float
        Time from the first look to the last. Where it is less than twice ``STEADY``, its second
        half counts as the last part.
    say : callable
        Told what is under way.

    Raises
    ------
    SessionError
        If the suite cannot be started or breaks down.
    """
    bag = (folder / "soak.mcap").absolute()
    bag.unlink(missing_ok=True)
    whole = 60.0 * minutes
    last = min(STEADY, whole / 2.0)
    say(f"soak: driver, {ESTIMATOR}, mapper and recorder, {minutes:g} min")
    with suite.acquiring(bag, suite.with_one_estimator(bag, ESTIMATOR)) as session:
        pids = {name: session.processes[name].pid for name in NODES}
        suite.spend(session, SETTLING)
        start = holdings(pids)
        suite.spend(session, whole - last)
        between = holdings(pids)
        suite.spend(session, last)
        end = holdings(pids)
    return {
        "minutes": minutes,
        "last_seconds": last,
        "start": start,
        "between": between,
        "end": end,
        "growth_megabytes": sum(
            end[name]["resident_megabytes"] - between[name]["resident_megabytes"] for name in NODES
        ),
        "counts": recorded.counts(bag, [ESTIMATOR]),
    }


def table(found: dict[str, object]) -> Table:
    """Return what each process held at the start and at the end, and what was lost."""
    shown = Table(title=f"Soak: {found['minutes']:g} min", title_justify="left")
    shown.add_column("process")
    for kind in KINDS.values():
        for when in ("start", "end"):
            shown.add_column(f"{kind}\n{when}", justify="right")
    for name in NODES:
        cells = [
            f"{found[when][name][kind]:.{1 if kind == 'resident_megabytes' else 0}f}"
            for kind in KINDS
            for when in ("start", "end")
        ]
        shown.add_row(name, *cells)
    lost = ", ".join(f"{row['node']} {row['lost']} {row['what']}" for row in found["counts"])
    sent = found["counts"][0]["published"]
    shown.caption = (
        f"lost of {sent} samples: {lost}\n"
        f"memory grew by {found['growth_megabytes']:.2f} MB in the last "
        f"{found['last_seconds'] / 60:g} min, all together; to reach: below {GROWTH:g} MB, 0 lost"
    )
    shown.caption_justify = "left"
    return shown
