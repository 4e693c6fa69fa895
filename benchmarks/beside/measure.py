"""Each tool on each set, and the page of documents that says it.

Contents: the rows, a table, and the page.
"""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from rich.table import Table

from benchmarks import machine
from benchmarks.beside import ours, sindy
from benchmarks.beside.data import SETS, STARTING, Set
from benchmarks.beside.limited import MOST_SECONDS, limited
from benchmarks.beside.results import Result

PAGE = Path(__file__).parents[2] / "docs" / "beside.md"
JAX_SYSID = "jax-sysid, 4 states and 8 neurons"
PEER = Path(__file__).with_name("jax_sysid_peer.py")


def measure(data: Path, python: Path | None, say: Callable[[str], None] = print) -> list[Result]:
    """Return the results of all tools on the sets whose files are there.

    Parameters
    ----------
    data : path
        The folder of the sets.
    python : path, optional
        The Python of an environment that has jax-sysid; without one that peer is left out.
    say : callable
        Told each result.
    """
    tools: dict[str, Callable[[Set, Path], Result]] = {
        ours.DIAGNOSIS: ours.diagnose,
        ours.LAW: ours.fit_law,
        sindy.NAME: sindy.measure,
    }
    if python:
        tools[JAX_SYSID] = partial(_run_jax_sysid, python)
    found = []
    for of in (each for each in SETS if each.path(data).is_file()):
        for name, tool in tools.items():
            found.append(limited(name, tool, of, data))
            say(str(found[-1]))
    return found


def _run_jax_sysid(python: Path, of: Set, data: Path) -> Result:
    files = [str(of.path(data, part)) for part in ("train", *of.tests)]
    ran = subprocess.run(
        [str(python), str(PEER), *files], capture_output=True, text=True, check=True
    )
    told = json.loads(ran.stdout.splitlines()[-1])
    errors = tuple(of.per_unit * each for each in told["errors"])
    return Result(of.name, JAX_SYSID, "", errors, told["seconds"])


def kept(found: list[Result]) -> list[dict[str, Any]]:
    """Return results as JSON holds them."""
    return [asdict(each) for each in found]


def tables(found: list[Result]) -> list[Table]:
    """Return a table of each set: tools, and published errors."""
    shown = []
    for of in SETS:
        table = Table(title=of.name, title_justify="left")
        for head in _heads(of):
            table.add_column(head)
        for row in _rows(of, found):
            table.add_row(*row)
        shown.append(table)
    return shown


def write_page(found: list[Result]) -> None:
    """Write the page of documents: what stands in it is what was measured."""
    parts = [_HEAD.format(starting=STARTING, most=MOST_SECONDS, **machine.describe())]
    for of in SETS:
        rows = [_heads(of), ["---"] * len(_heads(of)), *_rows(of, found)]
        parts += [f"## {of.name}\n", *("| " + " | ".join(row) + " |" for row in rows), ""]
        parts.append(f"The law of its authors is `{', '.join(of.law)}`. Data: {of.source}.\n")
    PAGE.write_text("\n".join(parts), encoding="utf-8")


_HEAD = """# Beside other tools

Public records with official splits: a tool learns from one record and predicts others.
The first {starting} samples of these start its model, and are not scored. One command measures all
rows but those that are published, and writes this page:

```sh
python -m benchmarks beside --data FOLDER --peer PYTHON
```

FOLDER holds the data, which are not part of the project; PYTHON is that of an environment with
jax-sysid. Errors are root mean squares. Seconds are those of the processor ({processor}), to learn;
a tool that takes more than {most:g}, predictions included, is ended. PySINDy chooses its lags and
its threshold by a quarter of the training record. Both sets are published at
[nonlinearbenchmark.org](https://www.nonlinearbenchmark.org), which has their terms.
"""


def _heads(of: Set) -> list[str]:
    tests = [each.removesuffix("_test").replace("_", " ") for each in of.tests]
    return ["", "says", *(f"{each} [{of.unit}]" for each in tests), "seconds"]


def _rows(of: Set, found: list[Result]) -> list[list[str]]:
    rows = [
        [each.tool, each.says, *map(_written, each.errors), _written_time(each.seconds)]
        for each in found
        if each.set == of.name
    ]
    published = [[name, "", *map(_written, errors), ""] for name, errors in of.published.items()]
    return [*rows, *published]


def _written(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.3g}"


def _written_time(seconds: float) -> str:
    return f"over {MOST_SECONDS:g}" if math.isinf(seconds) else _written(seconds)
