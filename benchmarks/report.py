"""What was measured, as tables beside the targets, and as a file."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator
from datetime import datetime
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from benchmarks.estimators import CONTESTANTS
from benchmarks.estimators_speed import GOALS
from benchmarks.machine import LITTLE_LOAD
from benchmarks.suite import ESTIMATORS, OTHERS

#: The live runs, and what the head of a column calls them.
MODES = {"alone": "alone", "with_subscriber": "2 kHz"}

#: The estimator that stands in every table of them.
RECOMMENDED = "robust_ekf"

# The targets: each value is to stay below.
CORES = 0.6
SHARE = 0.65
LATENCY_MS = 10
OFFLINE_SECONDS = 1


def keep(results: dict[str, object], folder: Path) -> Path:
    """Write the results to a new JSON file named after now; return its path."""
    path = folder / f"{datetime.now():%Y-%m-%dT%H-%M-%S}.json"
    path.write_text(json.dumps(results, indent=2) + "\n")
    return path


def show(results: dict[str, object], console: Console) -> None:
    """Print every table for which there are results."""
    console.print(machine_table(results["machine"]))
    if results["machine"]["load_average_at_start"] > LITTLE_LOAD:
        console.print("[bold]Others were running: the times are longer than on an idle machine.")
    if "live" in results:
        for table in (counts_table, times_table, usage_table, both_ways_table):
            console.print(table(results["live"]))
    if "offline" in results:
        console.print(offline_table(results["offline"]))
    for table in estimators_tables(results.get("estimators", {})):
        console.print(table)
    if "speed" in results:
        console.print(speed_table(results["speed"]))
    if "filters" in results:
        console.print(filters_table(results["filters"]))
    if "live" in results or "offline" in results:
        console.print(targets_table(results))


def filters_table(found: dict[str, dict[str, float]]) -> Table:
    """Return how many random sequences showed which fault, of each filter."""
    faults = list(next(iter(found.values())))
    table = Table(title="Random settings and samples", title_justify="left")
    for column in ("filter", *faults):
        table.add_column(column, justify="left" if column == "filter" else "right")
    for name, counts in found.items():
        table.add_row(name, *(f"{counts[each]:.4g}" for each in faults))
    return table


def machine_table(machine: dict[str, object]) -> Table:
    """Return what it was measured on."""
    table = Table(title="Machine", show_header=False, title_justify="left")
    for name, value in machine.items():
        shown = f"{value:.2f}" if isinstance(value, float) else str(value)
        table.add_row(name.replace("_", " "), shown)
    return table


def counts_table(live: dict[str, object]) -> Table:
    """Return what each node should have received, what it did, and what it lost."""
    table = _two_modes("Messages", ["node", "of"], ["sent", "got", "lost"])
    for row in live["with_subscriber"]["counts"]:
        key = row["node"], row["what"]
        cells = [cell for mode in MODES for cell in _counted(live[mode]["counts"], key)]
        table.add_row(*key, *cells)
    table.caption = "2 kHz: the same with a subscriber of every single sample"
    return table


def times_table(live: dict[str, object]) -> Table:
    """Return the lateness of wake-ups, and the latency of estimates."""
    columns = ["p50", "p99", "max"]
    table = _two_modes("Lateness and latency in ms", ["of"], columns)
    for name, values in _times(live):
        table.add_row(name, *(f"{value:.2f}" if value is not None else "" for value in values))
    table.caption = (
        "wake-up: of the 2 kHz loop, after its deadline; p50, p99: medians over the seconds\n"
        "estimate: its publication, after the stamp of the last sample of its block\n"
        "from first: the same, after the stamp of the first sample of its block"
    )
    return table


def usage_table(live: dict[str, object]) -> Table:
    """Return what each process, and the suite together, take of processor and memory."""
    table = _two_modes("Processor and memory", ["process"], ["cores", "MB"])
    names = live["with_subscriber"]["cpu_cores"]
    nodes = [name for name in names if name not in OTHERS]
    for name in nodes:
        table.add_row(name, *_used(live, [name]))
    table.add_row("together", *_used(live, nodes), style="bold")
    table.add_section()
    for name in sorted(set(names) & set(OTHERS)):
        table.add_row(name, *_used(live, [name]))
    return table


def both_ways_table(live: dict[str, object]) -> Table:
    """Return the processor time of both ways to run the estimators."""
    table = _table("Cores, both ways")
    table.add_column("process")
    for column in ("apart", "together", "together / apart"):
        table.add_column(column, justify="right")
    apart, together = (live[way]["cpu_cores"] for way in ("apart", "alone"))
    parts = {"driver": ["driver"], "estimators": ["estimators", *ESTIMATORS]}
    parts |= {name: [name] for name in ("mapper", "recorder")}
    parts["all"] = [name for names in parts.values() for name in names]
    for part, names in parts.items():
        was, now = (sum(way.get(name, 0.0) for name in names) for way in (apart, together))
        table.add_row(part, f"{was:.3f}", f"{now:.3f}", f"{now / was:.2f}")
    table.caption = (
        "apart: each estimator in a process of its own; its stiffness, damping and\n"
        "covariance_trace published one by one, and recorded, too\n"
        "together: as the suite runs, the estimators in one process; numbers one by one\n"
        "only while someone subscribes, here nobody"
    )
    return table


def offline_table(offline: dict[str, object]) -> Table:
    """Return the filters' durations off line."""
    length = offline["recording_seconds"]
    table = _table(f"Off line: {length:.0f} s of samples")
    table.add_column("step")
    for column in ("s after start-up", "times real time", "s as a command"):
        table.add_column(column, justify="right")
    warm, commands = offline["warm_seconds"], offline["command_seconds"]
    for name, seconds in warm.items():
        whole = f"{commands[name]:.2f}" if name in commands else ""
        table.add_row(name, f"{seconds:.3f}", f"{length / seconds:.0f}", whole)
    total, whole = sum(warm.values()), sum(commands.values())
    cells = f"{total:.3f}", f"{length / total:.0f}", f"{whole:.2f}"
    table.add_row("together", *cells, style="bold")
    return table


def estimators_tables(rows: dict[str, dict[str, str]]) -> Iterator[Table]:
    """Yield how exact the estimators are, two at a time beside the recommended one."""
    others = [who.title for who in CONTESTANTS if who.title != RECOMMENDED] if rows else []
    for first in range(0, len(others), 2):
        columns = ["to reach", RECOMMENDED, *others[first : first + 2]]
        table = _table("Estimators: median/worst, of k, of beta")
        for column in ("of", *columns):
            table.add_column(column, overflow="fold")
        for title, found in rows.items():
            table.add_row(escape(title), *(found[column] for column in columns), end_section=True)
        yield table


def speed_table(speed: dict[str, float]) -> Table:
    """Return what a sample costs, beside what is to be reached."""
    table = _table("Processor time of a sample")
    table.add_column("of")
    for column in ("to reach", "reached"):
        table.add_column(column, justify="right")
    for name, value in speed.items():
        table.add_row(escape(name), GOALS.get(name, ""), f"{value:.3g}")
    return table


def targets_table(results: dict[str, object]) -> Table:
    """Return the targets beside what was reached, in red where it was not."""
    table = _table("Targets")
    table.add_column("target")
    for column in ("", "reached"):
        table.add_column(column, justify="right")
    for name, limit, run, reached in targets(results):
        style = "green" if reached < limit else "red"
        table.add_row(name, run, f"{reached:.3g}", style=style)
    return table


def targets(results: dict[str, object]) -> Iterator[tuple[str, float, str, float]]:
    """Yield each target's name, the value to stay below, the run, and the value reached."""
    for mode in MODES if "live" in results else ():
        live = results["live"][mode]
        run = mode.replace("_", " ")
        yield "messages lost: none", 1, run, sum(row["lost"] for row in live["counts"])
        yield f"processor: below {CORES} cores", CORES, run, cores_of(live)
        latency = max(latency["first_p99_ms"] for latency in live["latency"].values())
        yield f"p99 latency, from first: below {LATENCY_MS} ms", LATENCY_MS, run, latency
    if "live" in results:
        share = cores_of(results["live"]["alone"]) / cores_of(results["live"]["apart"])
        yield f"processor: below {SHARE} of before", SHARE, "alone", share
    if "offline" in results:
        offline = results["offline"]
        share = sum(offline["warm_seconds"].values()) / offline["recording_seconds"]
        yield (
            f"three filters over 60 s: below {OFFLINE_SECONDS} s",
            OFFLINE_SECONDS,
            "off line",
            60 * share,
        )


def cores_of(run: dict[str, object]) -> float:
    """Return the cores that the suite kept busy in one run, others' programs left out."""
    return sum(cores for name, cores in run["cpu_cores"].items() if name not in OTHERS)


def _table(title: str) -> Table:
    return Table(title=title, title_justify="left", caption_justify="left")


def _two_modes(title: str, keys: list[str], columns: list[str]) -> Table:
    """Return an empty table with ``columns`` once for each mode."""
    table = _table(title)
    for key in keys:
        table.add_column(key)
    for mode in MODES:
        for column in columns:
            table.add_column(f"{MODES[mode]}\n{column}", justify="right")
    return table


def _counted(counts: list[dict[str, object]], key: tuple[str, str]) -> list[str]:
    for row in counts:
        if (row["node"], row["what"]) == key:
            return [str(row[name]) for name in ("published", "received", "lost")]
    return ["", "", ""]


def _times(live: dict[str, object]) -> Iterator[tuple[str, list[float | None]]]:
    """Yield a name, and p50, p99 and largest of each mode."""
    names = ("p50_ms", "p99_ms", "max_ms")
    yield "wake-up", [live[mode]["lateness"][name] for mode in MODES for name in names]
    for estimator in live["alone"]["latency"]:
        found = [live[mode]["latency"][estimator] for mode in MODES]
        yield f"{estimator} estimate", [latency[name] for latency in found for name in names]
        first = [latency["first_p99_ms"] for latency in found]
        yield "  from first", [None, first[0], None, None, first[1], None]


def _used(live: dict[str, object], names: Collection[str]) -> list[str]:
    """Return the cores and megabytes of some processes together, in each mode."""
    cells = []
    for mode in MODES:
        for unit, digits in (("cpu_cores", 3), ("memory_megabytes", 0)):
            used = [live[mode][unit][name] for name in names if name in live[mode][unit]]
            cells.append(f"{sum(used):.{digits}f}" if used else "")
    return cells
