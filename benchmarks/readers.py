"""How many readers of single samples the driver bears before it sheds them.

Contents: one run after another, with a reader more in each.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from benchmarks import suite
from tissue_probe.nodes.session import NodeProcess, Session

#: No more are tried.
MOST = 16

SHED = "samples not published singly"
SHARE = "part of the time that publishing takes"
LATENESS = "worst lateness in the last second [ms]"


def measure(folder: Path, seconds: float, say: Callable[[str], None] = print) -> dict[str, object]:
    """Return for each number of readers what the driver told after ``seconds``, until it shed.

    Each reader is a process of its own that takes every message of ``measured_cf``; driver and
    stage run beside them, and nothing else.

    Raises
    ------
    SessionError
        If the driver cannot be started or ends.
    """
    rows: list[dict[str, float]] = []
    while len(rows) < MOST and not (rows and rows[-1]["shed"]):
        rows.append(run(folder, len(rows) + 1, seconds))
        say(
            f"readers: {rows[-1]['readers']:.0f} of measured_cf, publishing takes "
            f"{rows[-1]['share']:.0%} of the time, {rows[-1]['shed']:.0f} samples shed, worst "
            f"lateness of a second {rows[-1]['lateness_ms']:.1f} ms"
        )
    return {"seconds": seconds, "rows": rows, "borne": len(rows) - bool(rows[-1]["shed"])}


def run(folder: Path, readers: int, seconds: float) -> dict[str, float]:
    """Run the driver with so many readers; return what it told."""
    processes = [NodeProcess("driver", "driver"), NodeProcess("stage", "stage", "/stage")]
    with ExitStack() as stack:
        for number in range(readers):
            stack.enter_context(suite.subscriber(folder / f"reader_{number}.json"))
        session = stack.enter_context(Session(processes))
        session.wait_until(
            lambda: session.node.count_subscribers(suite.PER_SAMPLE_TOPIC) == readers, "readers"
        )
        session.activate({})
        worst = 0.0
        for _ in range(round(seconds)):
            suite.spend(session, 1.0)
            told = session.health["/probe/driver"]
            worst = max(worst, float(told.get(LATENESS, 0.0)))
        session.deactivate()
    for number in range(readers):
        (folder / f"reader_{number}.json").unlink()
    return {
        "readers": readers,
        "shed": int(told[SHED]),
        "share": float(told[SHARE]),
        "lateness_ms": worst,
    }


def sentence(found: dict[str, object]) -> str:
    """Say how many it bore."""
    last = found["rows"][-1]
    more = f"with {last['readers']} they are shed" if last["shed"] else "more were not tried"
    return (
        f"the driver bears {found['borne']} readers of measured_cf at 2 kHz on this machine; {more}"
    )
