"""How soon a study is answered, each run in a process of its own, whose start counts.

Contents: runs of ``tissue_probe.study``, their times and the memory of the process that asks.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import yaml

from benchmarks import memory
from benchmarks.studies.recordings import ASKED, FITTED, PATTERN, Laboratory

#: Recordings of a whole study; a specimen is measured so often.
COUNT, REPEATS = 10_000, 10
#: So many of them are answered by one worker and by two: the start of these is a small part.
COMPARED = 1000
#: So many are diagnosed; the time of ``DIAGNOSED_OF`` is that times their ratio.
DIAGNOSED, DIAGNOSED_OF = 40, 1000
#: To reach: seconds of ``COUNT`` recordings, of ``DIAGNOSED_OF``, of a second run of ``COUNT``; MB.
SECONDS, DIAGNOSE_SECONDS, AGAIN, MEMORY, FACTOR = 360.0, 1200.0, 5.0, 500.0, 1.8
SEED = 63_000


def measure(count: int, say: Callable[[str], None] = print) -> dict[str, float]:
    """Return each result by its name, which tells the unit."""
    specimens = max(-(-count // REPEATS), 4)
    with TemporaryDirectory() as name:
        folder = Path(name)
        say(f"{specimens * REPEATS} recordings of 2 s are written")
        Laboratory(specimens, REPEATS).write(folder / "data", SEED)
        count = len(_names(folder))
        say("estimated by two workers, and once more without changes")
        first = _run(folder, "all", "*.csv", workers=2)
        again = _run(folder, "all", "*.csv", workers=2)
        some = _listed(folder, COMPARED, "some.csv")
        say(f"{some} of them by one worker, and by two")
        one, two = (_run(folder, f"by{n}", "some.csv", workers=n) for n in (1, 2))
        few = _listed(folder, DIAGNOSED, "few.csv")
        say(f"{few} of them diagnosed")
        diagnosed = _run(folder, "few", "few.csv", workers=2, task="diagnose")
    return {
        "recordings": float(count),
        "estimated [s]": first["seconds"],
        f"the same, for {COUNT} [s]": first["seconds"] * COUNT / count,
        "two workers against one [times]": one["seconds"] / two["seconds"],
        "recordings by one worker and by two": float(some),
        "a second run without changes [s]": again["seconds"],
        f"the same, above its start, for {COUNT} [s]": again["inside"] * COUNT / count,
        "memory of the parent [MB]": max(first["memory"], again["memory"]),
        f"{few} diagnosed [s]": diagnosed["seconds"],
        f"the same, for {DIAGNOSED_OF} [s]": diagnosed["seconds"] * DIAGNOSED_OF / few,
        "rows that are not done": first["not done"] + diagnosed["not done"],
    }


def goals(found: dict[str, float]) -> dict[str, str]:
    """Return what is to be reached, by the names of the results."""
    told = {
        f"the same, for {COUNT} [s]": f"<= {SECONDS:g}",
        "two workers against one [times]": f">= {FACTOR:g}",
        f"the same, above its start, for {COUNT} [s]": f"<= {AGAIN:g}",
        "memory of the parent [MB]": f"<= {MEMORY:g}",
        f"the same, for {DIAGNOSED_OF} [s]": f"<= {DIAGNOSE_SECONDS:g}",
        "rows that are not done": "0",
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
    done = subprocess.run([sys.executable, "-c", script], check=True, stdout=subprocess.PIPE)
    seconds = time.perf_counter() - begun
    return {"seconds": seconds, **json.loads(done.stdout.splitlines()[-1])}


def run(plan: str, workers: int) -> None:
    """Answer a study here; print what it took."""
    import tissue_probe as tp

    begun = time.perf_counter()
    found = tp.study(plan, workers=workers)
    inside = time.perf_counter() - begun
    away = sum(row["status"] != "done" for row in found.rows)
    print(json.dumps({"inside": inside, "memory": memory.status("VmHWM"), "not done": away}))
