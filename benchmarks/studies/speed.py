"""How soon a study is answered, each run in a process of its own, whose start counts.

Contents: runs of ``tissue_probe.study``, their times and the memory of the process that asks.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import yaml

from benchmarks import memory
from benchmarks.studies.parts import results_of
from benchmarks.studies.recordings import ASKED, FITTED, PATTERN, Laboratory

#: Recordings of a whole study; a specimen is measured so often.
COUNT, REPEATS = 10_000, 10
#: So many of them are answered by one worker.
COMPARED = 2000
#: So many are diagnosed; the time of ``DIAGNOSED_OF`` is that times their ratio.
DIAGNOSED, DIAGNOSED_OF = 40, 1000
#: To reach: seconds of ``COUNT`` recordings, of ``DIAGNOSED_OF``, of a second run of ``COUNT``; MB.
SECONDS, DIAGNOSE_SECONDS, AGAIN, MEMORY, FACTOR = 360.0, 1200.0, 5.0, 500.0, 1.8
SEED = 63_000
#: A run that takes longer is ended [s].
LONGEST = 600.0


def measure(count: int, say: Callable[[str], None] = print) -> dict[str, float]:
    """Return each result by its name, which tells the unit; a part that fails is not there."""
    specimens = max(-(-count // REPEATS), 4)
    with TemporaryDirectory() as name:
        folder = Path(name)
        say(f"{specimens * REPEATS} recordings of 2 s are written")
        Laboratory(specimens, REPEATS).write(folder / "data", SEED)
        found = {"recordings": float(len(_names(folder)))}
        for part in (_whole, _workers, _diagnosed):
            found |= results_of(partial(part, folder, say), say)
        return found


def _whole(folder: Path, say: Callable[[str], None]) -> dict[str, float]:
    """Estimate all by two workers, and once more without changes."""
    say("estimated by two workers, and once more without changes")
    count = len(_names(folder))
    first = _run(folder, "all", "*.csv", workers=2)
    found = {
        "estimated [s]": first["seconds"],
        f"the same, for {COUNT} [s]": first["seconds"] * COUNT / count,
        "memory of the parent [MB]": first["memory"],
        "estimated, and not done": first["not done"],
    }
    again = _run(folder, "all", "*.csv", workers=2)
    return found | {
        "computed by a second run without changes": again["computed"],
        "a second run, with its start [s]": again["seconds"],
        f"a second run of {count} [s]": again["inside"],
        "memory of the parent [MB]": max(first["memory"], again["memory"]),
    }


def _workers(folder: Path, say: Callable[[str], None]) -> dict[str, float]:
    """Compare two workers with one: rows a second, from the first row to the last."""
    some = _listed(folder, COMPARED, "some.csv")
    say(f"{some} of them by one worker, and by two")
    one, two = (_run(folder, f"by{n}", "some.csv", workers=n) for n in (1, 2))
    return {
        "recordings by one worker and by two": float(some),
        "a row by one worker [ms]": 1e3 / one["rows a second"],
        "a row by two workers [ms]": 1e3 / two["rows a second"],
        "two workers against one [times]": two["rows a second"] / one["rows a second"],
        "the same, with their start [times]": one["seconds"] / two["seconds"],
    }


def _diagnosed(folder: Path, say: Callable[[str], None]) -> dict[str, float]:
    few = _listed(folder, DIAGNOSED, "few.csv")
    say(f"{few} of them diagnosed")
    found = _run(folder, "few", "few.csv", workers=2, task="diagnose")
    return {
        f"{few} diagnosed [s]": found["seconds"],
        f"the same, for {DIAGNOSED_OF} [s]": found["seconds"] * DIAGNOSED_OF / few,
        "diagnosed, and not done": found["not done"],
    }


def goals(found: dict[str, float]) -> dict[str, str]:
    """Return what is to be reached, by the names of the results."""
    told = {
        f"the same, for {COUNT} [s]": f"<= {SECONDS:g}",
        "two workers against one [times]": f">= {FACTOR:g}",
        "computed by a second run without changes": "0",
        f"a second run of {COUNT} [s]": f"<= {AGAIN:g}",
        "memory of the parent [MB]": f"<= {MEMORY:g}",
        f"the same, for {DIAGNOSED_OF} [s]": f"<= {DIAGNOSE_SECONDS:g}",
        "estimated, and not done": "0",
        "diagnosed, and not done": "0",
    }
    return {name: told.get(name, "") for name in found}


def _names(folder: Path) -> list[str]:
    return sorted(path.name for path in (folder / "data").glob("*.csv"))


def _listed(folder: Path, count: int, file: str) -> int:
    """Leave a table of some recordings, and return how many these are."""
    names = _names(folder)[:count]
    (folder / file).write_text("\n".join(["path", *(f"data/{each}" for each in names)]) + "\n")
    return len(names)


def _run(
    folder: Path, name: str, recordings: str, workers: int, task: str = "estimate"
) -> dict[str, float]:
    told = {
        "recordings": f"data/{recordings}" if "*" in recordings else recordings,
        "task": task,
        "question": FITTED if task == "diagnose" else ASKED,
        "output": name,
        **({"pattern": PATTERN} if "*" in recordings else {}),
    }
    plan = folder / f"{name}.yaml"
    plan.write_text(yaml.safe_dump(told))
    script = f"from benchmarks.studies.speed import run; run({str(plan)!r}, {workers})"
    begun = time.perf_counter()
    call = [sys.executable, "-c", script]
    done = subprocess.run(call, check=True, stdout=subprocess.PIPE, timeout=LONGEST)
    seconds = time.perf_counter() - begun
    return {"seconds": seconds, **json.loads(done.stdout.splitlines()[-1])}


def run(plan: str, workers: int) -> None:
    """Answer a study here; print what it took."""
    import tissue_probe as tp

    times: list[float] = []

    def note(done: int, of: int) -> None:
        times.append(time.perf_counter())

    begun = time.perf_counter()
    found = tp.study(plan, workers=workers, progress=note)
    inside = time.perf_counter() - begun
    told = {
        "inside": inside,
        "computed": found.computed,
        "memory": memory.status("VmHWM"),
        "not done": sum(row["status"] != "done" for row in found.rows),
    }
    if len(times) > 1:
        told["rows a second"] = (len(times) - 1) / (times[-1] - times[0])
    print(json.dumps(told))
