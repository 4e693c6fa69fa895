"""Strangers' files: whether each kind is read rightly, and how much memory a long one takes.

Contents: making the files, reading them, counting.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from time import process_time
from typing import NamedTuple

import numpy as np
from rich.table import Table

from benchmarks.memory import memory_to_read
from benchmarks.written_tables import FORCE, KINDS, PERIOD, POLARITY, POSITION, SI, TIME
from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.bags.samples_bag import write_samples_bag
from tissue_probe.recording.layout import Layout
from tissue_probe.signals import Recording, SampleBlock

ROWS = 10_000_000
#: Rows of the texts whose reading is timed beside pyarrow's own reader.
TIMED = (4_000, 100_000)
#: So often each is read, by turns; the median counts.
TURNS = 7
#: How long files are written: text, columns, a recording of this suite.
LONG = (".csv", ".parquet", ".mcap")
#: Three columns of float64, three times [MB].
MEMORY = ROWS * 3 * 8 * 3 / 1e6
#: What is right of a force that is damaged by nothing: digits of a text.
EXACT = 1e-9
#: A time since 1970 as a float64 has no more digits, in periods.
CLOCK = 1e-6


class Outcome(NamedTuple):
    """What came of a file: whether it is right, and what was said of it."""

    kind: str
    right: bool
    said: str


class Text(NamedTuple):
    """A text: its lines, what is stated, and the sentence where it is to be refused."""

    lines: Sequence[str]
    stated: dict[str, str]
    refused: str = ""
    encoding: str = "utf-8"


def measure() -> dict[str, object]:
    """Read a file of each kind, and long ones; returns outcomes, memory [MB], and times [s]."""
    with tempfile.TemporaryDirectory() as folder:
        outcomes = [*_containers(Path(folder)), *_texts(Path(folder))]
        memory = {ending: _memory(Path(folder, f"long{ending}")) for ending in LONG}
        speed = {str(rows): _speed(Path(folder, "timed.csv"), rows) for rows in TIMED}
    kinds = [each._asdict() for each in outcomes]
    return {"kinds": kinds, "memory": memory, "speed": speed}


def tables(results: dict[str, object]) -> Iterator[Table]:
    """Yield what was measured as tables."""
    kinds = [Outcome(**each) for each in results["kinds"]]
    right = sum(each.right for each in kinds)
    table = Table(
        "kind", "", "said", title=f"Reading: {right} of {len(kinds)} right", title_justify="left"
    )
    for each in kinds:
        table.add_row(each.kind, "right" if each.right else "WRONG", each.said)
    yield table
    table = Table(
        "file", "more resident memory [MB]", "at most", title=f"{ROWS} rows", title_justify="left"
    )
    for ending, megabytes in results["memory"].items():
        table.add_row(ending, f"{megabytes:.0f}", f"{MEMORY:.0f}")
    yield table
    titles = ("rows of text", "read [s of processor]", "by pyarrow [s]", "ratio")
    table = Table(*titles, title="Speed, medians of readings by turns", title_justify="left")
    for rows, (own, peer) in results["speed"].items():
        table.add_row(rows, f"{own:.3f}", f"{peer:.4f}", f"{own / peer:.1f}")
    yield table


def _containers(folder: Path) -> Iterator[Outcome]:
    for name, kind in KINDS.items():
        yield _read(name, kind.write(folder / name), kind.stated, "")


def _texts(folder: Path) -> Iterator[Outcome]:
    for name, text in _written().items():
        path = folder / "text.csv"
        path.write_text("\n".join([*text.lines, ""]), encoding=text.encoding)
        yield _read(name, path, text.stated, text.refused)


def _read(name: str, path: Path, stated: dict[str, str], refused: str) -> Outcome:
    try:
        recording, notes = read_any(path, Layout(**stated))
    except ValueError as error:
        said = str(error).removeprefix(f"{path}").lstrip(":, ")
        return Outcome(name, bool(refused) and refused in str(error), said)
    said = "; ".join(note.removeprefix(f"{path}: ") for note in notes)
    return Outcome(name, not refused and _is_right(recording), said)


def _is_right(recording: Recording) -> bool:
    found = recording.blocks[0]
    return bool(
        len(recording) == TIME.size
        and abs(found.sample_period / PERIOD - 1.0) < CLOCK
        and np.abs(recording.position - POSITION).max() < EXACT
        and np.abs(recording.force - FORCE).max() < EXACT
    )


def _rows(mark: str = ",", decimal: str = ".", sizes=(1.0, 1.0, 1.0), quote: str = "") -> list[str]:
    columns = zip(TIME / sizes[0], POSITION / sizes[1], FORCE / sizes[2], strict=True)
    return [
        mark.join(f"{quote}{v:.15g}{quote}".replace(".", decimal) for v in row) for row in columns
    ]


def _timed(times: Sequence[str]) -> list[str]:
    return [f"{t},{u:.15g},{f:.15g}" for t, u, f in zip(times, POSITION, FORCE, strict=True)]


def _written() -> dict[str, Text]:
    """Return texts as instruments write them; no true ones, but what is characteristic of each."""
    si, mm = (1.0, 1.0, 1.0), (1.0, 1e-3, 1.0)
    own, rows, tabs = ["t,u,F"], _rows(), _rows("\t", sizes=mm)
    begun = np.datetime64("2026-03-01T23:59:59.900", "ns")
    dates = [str(begun + np.timedelta64(n, "ms")) for n in range(TIME.size)]
    names = {"position": "2", "force": "3", "time": "1", **SI}
    bluehill = ["Results Table 1", ",Maximum Load (N)", "1,0.55", "", "", "Time,Extension,Load"]
    lvm = ["LabVIEW Measurement\t", "Separator\tTab", "***End_of_Header***\t", ""]
    zwick = ['"Prüfer";"Müller"', "", '"Zeit";"Weg";"Kraft"', "s;µm;N"]
    mach = ["<Mach-1 File>", "<DATA>", "Time, s\tPosition (z), mm\tFz, N"]
    channel = {"position": "AI0", "force": "AI1", "position_unit": "1e-3", "force_unit": "N"}
    aurora = ["Sample Frequency (Hz):\t1000", "Test Data in Volts:", "", "Sample\tAI0\tAI1"]
    counted = [f"{n}\t{u:.15g}\t{f:.15g}" for n, (u, f) in enumerate(
        zip(1e3 * POSITION, FORCE, strict=True)
    )]  # fmt: skip
    mts = ["Data Header:\tTime:\t8.4\tSec", "", "Running Time\tAxial Displacement\tAxial Force"]
    stamped = {"decimals": [f"{1772409597 + t:.3f}" for t in TIME], "ISO 8601": dates,
               "of the day": [each[11:] for each in dates]}  # fmt: skip
    written = {
        "comma": Text([*own, *rows], {}),
        "semicolon, decimal comma": Text(["t;u;F", *_rows(";", ",")], {}),
        "tab": Text(["t\tu\tF", *_rows("\t")], {}),
        "blanks": Text(["t u F", *_rows("  ")], {}),
        "UTF-16": Text([*own, *rows], {}, encoding="utf-16"),
        "Instron Bluehill": Text(
            [*bluehill, "(s),(mm),(N)", *_rows(sizes=mm, quote='"')], POLARITY
        ),
        "Zwick": Text([*zwick, *_rows(";", ",", (1.0, 1e-6, 1.0), "")], POLARITY, "", "cp1252"),
        "MTS": Text([*mts, "Sec\tmm\tN", *tabs], POLARITY),
        "Mach-1": Text([*mach, *tabs], {"force": "Fz", **POLARITY}),
        "LabVIEW .lvm": Text([*lvm, "X_Value\tPosition (mm)\tForce (N)\tComment", *tabs], POLARITY),
        "Aurora .ddf": Text([*aurora, *counted], {"sample_rate": 1000.0, **channel, **POLARITY}),
        "header twice": Text([*own, *rows[:99], *own, *rows[99:]], {}),
        "comments, footer": Text(["# made by hand", *own, *rows, "", "end of test"], {}),
        "no header": Text(rows, {}, "no header line that names its columns: state which"),
        "no header, by number": Text(rows, names),
        "unit in names": Text(["t / s,u in mm,F_mN", *_rows(sizes=(1.0, 1e-3, 1e-3))], POLARITY),
        "lbf, inches": Text(
            ["Time (s),Stroke (in),Load (lbf)", *_rows(sizes=(1.0, 0.0254, 4.4482216152605))],
            POLARITY,
        ),
        "commas everywhere": Text(
            [*own, *_rows(",", ",", si)], {}, "are commas both between cells and within numbers"
        ),
        "a cell too many": Text(
            [*own, *rows[:50], rows[50] + ",1", *rows[51:]], {}, "line 52: 4 cells"
        ),
        "whole times": Text(
            [*own, *_timed(range(TIME.size))], {}, "counts whole numbers and tells no unit"
        ),
        "whole times, stated": Text([*own, *_timed(range(TIME.size))], {"time_unit": "ms"}),
        "minutes": Text(["t_min,u,F", *_rows(sizes=(60.0, 1.0, 1.0))], {}),
    }
    for unit, size in (("ms", 10**3), ("us", 10**6), ("ns", 10**9)):
        whole = [str(1772409597 * size + n * size // 1000) for n in range(TIME.size)]
        written[f"epoch in {unit}"] = Text([*own, *_timed(whole)], {})
    for name, times in stamped.items():
        written[f"times: {name}"] = Text([*own, *_timed(times)], {})
    return written


def _memory(path: Path) -> float:
    """Return by how much the resident memory of a process rises that reads a long file [MB]."""
    _write_long(path)
    megabytes = memory_to_read(path, {})
    path.unlink()
    return megabytes


def _speed(path: Path, rows: int) -> tuple[float, float]:
    """Return the processor time to read a text here, and by pyarrow's reader in one thread [s]."""
    from pyarrow import csv

    time = np.arange(rows) * 5e-4
    position = 1e-3 * (1.0 + np.sin(60.0 * time))
    force = 450.0 * position + 2e-3 * np.random.default_rng(0).standard_normal(rows)
    columns = np.column_stack([time, position, force])
    np.savetxt(path, columns, delimiter=",", header="t,u,F", comments="", fmt="%.9g")
    readers = (
        lambda: read_any(path, Layout()),
        lambda: csv.read_csv(path, csv.ReadOptions(use_threads=False)),
    )
    taken = np.array([[_processor(read) for read in readers] for _ in range(TURNS + 1)])
    own, peer = np.median(taken[1:], axis=0)  # the first imports
    return float(own), float(peer)


def _processor(read: Callable[[], object]) -> float:
    begun = process_time()
    read()
    return process_time() - begun


def _write_long(path: Path) -> None:
    if path.suffix == ".mcap":
        position = 1e-3 * np.sin(62.8 * np.arange(ROWS) * 5e-4)
        unknown = np.full(ROWS, np.nan)
        write_samples_bag(path, SampleBlock(10**18, 0, 5e-4, position, 450.0 * position, unknown))
        return
    import pyarrow
    from pyarrow import csv, parquet

    schema = pyarrow.schema([(name, pyarrow.float64()) for name in ("t", "u", "F")])
    writer = (csv.CSVWriter if path.suffix == ".csv" else parquet.ParquetWriter)(path, schema)
    part = 500_000
    with writer:
        for first in range(0, ROWS, part):
            time = np.round((first + np.arange(part)) * 5e-4, 4)
            position = np.round(1e-3 * np.sin(62.8 * time), 9)
            columns = [time, position, np.round(450.0 * position + 0.01 * np.sin(1e3 * time), 6)]
            writer.write_table(pyarrow.table(columns, schema=schema))
