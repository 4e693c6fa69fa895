"""Each tool on each set, and the page of documents that says it.

Contents: the rows, a table, and the page.
"""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Callable, Sequence
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
#: Peers in an environment of their own: what each is, the module it needs, and its program.
PEERS = {
    "jax-sysid, 4 states and 8 neurons": ("jax_sysid", "jax_sysid_peer.py"),
    "freq-statespace, 2 states and a cubic": ("freq_statespace", "freq_statespace_peer.py"),
    "MuJoCo's sysid, cubic spring and damping": ("mujoco.sysid", "mujoco_sysid_peer.py"),
}


def measure(
    data: Path, pythons: Sequence[Path], say: Callable[[str], None] = print
) -> list[Result]:
    """Return the results of all tools on the sets whose files are there.

    Parameters
    ----------
    data : path
        The folder of the sets.
    pythons : sequence of path
        The Python of each environment that has some of ``PEERS``; one that none has is left out.
    say : callable
        Told each result.
    """
    tools: dict[str, Callable[[Set, Path], Result]] = {
        ours.DIAGNOSIS: ours.diagnose,
        ours.LAW: ours.fit_law,
        sindy.NAME: sindy.measure,
    }
    for name, (module, program) in PEERS.items():
        python = next((each for each in pythons if _has_module(each, module)), None)
        if python:
            tools[name] = partial(_run_peer, python, name, program)
        else:
            say(f"{name} is left out: no --peer has {module}.")
    found = []
    for of in (each for each in SETS if each.path(data).is_file()):
        for name, tool in tools.items():
            found.append(limited(name, tool, of, data))
            say(str(found[-1]))
    return found


def _has_module(python: Path, module: str) -> bool:
    asked = subprocess.run([str(python), "-c", f"import {module}"], capture_output=True)
    return asked.returncode == 0


def _run_peer(python: Path, name: str, program: str, of: Set, data: Path) -> Result:
    files = [str(of.path(data, part)) for part in ("train", *of.tests)]
    command = [str(python), str(Path(__file__).with_name(program)), *files]
    ran = subprocess.run(command, capture_output=True, text=True)
    if ran.returncode:
        raise RuntimeError(f"{name} failed on {of.name}: {ran.stderr[-2000:]}")
    told = json.loads(ran.stdout.splitlines()[-1])
    errors = tuple(of.per_unit * each for each in told["errors"])
    return Result(of.name, name, "", errors, told["seconds"])


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

Two public sets of system identification, each with a training recording and test recordings that
their authors have fixed. A tool learns from the training recording and predicts the position in the
tests. Silverbox is an electronic oscillator with a cubic spring; its arrow test grows beyond the
amplitudes of the training, and "no extrapolation" is the part that does not. Bouc-Wen is a
simulated oscillator with hysteresis.

```sh
python -m benchmarks beside --data FOLDER --peer PYTHON [--peer PYTHON]
```

measures all rows except "published", and writes this page. FOLDER holds the data, which are not
part of the project: both sets are at [nonlinearbenchmark.org](https://www.nonlinearbenchmark.org).
PYTHON is the interpreter of an environment with jax-sysid, freq-statespace or mujoco[sysid].

Errors are root mean squares. The first {starting} samples of a test initialise a model and are not
counted. Seconds are processor time of the training ({processor}); a tool that takes more than
{most:g}, predictions included, is ended. PySINDy's lags and threshold are chosen on a quarter of
the training recording. "improve" is given the authors' effects by name, and MuJoCo's sysid the
form of the spring; "diagnose" has to find them. The column "verdict" is ours alone.
"""


def _heads(of: Set) -> list[str]:
    tests = [each.removesuffix("_test").replace("_", " ") for each in of.tests]
    return ["", "verdict", *(f"{each} [{of.unit}]" for each in tests), "seconds"]


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
