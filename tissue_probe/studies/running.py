"""A study's rows computed, side by side: only those that are not there yet."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import tissue_probe
from tissue_probe import arguments as take
from tissue_probe.errors import ParameterError
from tissue_probe.studies.dataset import Dataset, write_tables
from tissue_probe.studies.key import key_of, key_of_question, state_of
from tissue_probe.studies.plan import StudyPlan, read_plan
from tissue_probe.studies.provenance import doubts
from tissue_probe.studies.result import StudyResult
from tissue_probe.studies.row import ROW_HAS, SIGNAL_STATEMENTS, check_question, row

#: A batch is written when it has so many rows, or after so long [s]: so much is computed again
#: where the machine dies.
BATCH, BATCH_TIME = 200, 10.0
#: The folder of the batches, beside the table of all.
ROWS_FOLDER = "rows"

Progress = Callable[[int, int], None]


def _plan(name: str, given: Any) -> StudyPlan | Path:
    """Take a plan, or the path of its file."""
    return given if isinstance(given, StudyPlan) else take.path(name, given)


@take.checks(
    plan=_plan, workers=take.optional(take.whole(1)), progress=take.optional(take.function)
)
def study(
    plan: StudyPlan | str | Path, *, workers: int | None = None, progress: Progress | None = None
) -> StudyResult:
    """Compute the row of each recording of a study, and keep them in its folder.

    The folder has ``table.csv`` and ``table.parquet`` of all rows once they are done, and ``rows``,
    the batches as they came.

    A recording whose file, question and version are as in a row that is there is not computed
    again. An interrupt (Ctrl-C) ends the run; rows that are done are kept.

    Parameters
    ----------
    plan : Plan, or path of a YAML file
        See ``read_plan``.
    workers : int, optional
        Processes on this machine, as many as it has cores by default. Within
        ``joblib.parallel_config(backend="dask")`` the cluster's workers do it.
    progress : callable, optional
        Told how many recordings are done, and how many there are.

    Raises
    ------
    ParameterError
        If the plan is none.
    FileError
        If the rows cannot be written.
    """
    plan = plan if isinstance(plan, StudyPlan) else read_plan(plan)
    check_question(plan.task, plan.question)
    _refuse_names(plan.factors)
    recordings = {os.path.realpath(path): factors for path, factors in plan.recordings.items()}
    kept, asked = Dataset(plan.output / ROWS_FOLDER), key_of_question(plan.task, plan.question)
    before = {each["path"]: each for each in kept.read()}
    done = dict(_held(before, recordings, asked))
    wanted = [path for path in recordings if path not in done]
    other = {path: each for path, each in done.items() if each != before.get(path)}
    kept.amend({**dict.fromkeys(wanted), **other})
    kept.write([each for path, each in other.items() if path not in before])
    computed = _counted(_computed(wanted, plan, workers), len(done), len(recordings), progress)
    done |= {each["path"]: each for each in _written(kept, computed, recordings)}
    notes = [
        f"{each} was damaged and is set aside: its recordings were computed again"
        for each in kept.damaged
    ]
    notes += [
        f"{path} has changed since its row was computed: it was computed again"
        for path in wanted
        if before.get(path, {}).get("question") == asked and "key" in before[path]
    ]
    rows = [done[path] for path in recordings]
    write_tables(plan.output, rows)
    notes += [*_alike(rows), *doubts(rows)]
    return StudyResult(tuple(rows), len(wanted), tuple(notes), plan.question)


def _refuse_names(factors: Sequence[str]) -> None:
    """Refuse factors called as columns of rows are, and those that seem to set a keyword."""
    if taken := [name for name in factors if name in ROW_HAS or "." in name]:
        raise ParameterError(f"a factor is called {taken[0]}, as a column of rows is: rename it")
    if taken := [name for name in factors if name == "rig" or name in SIGNAL_STATEMENTS]:
        raise ParameterError(
            f"a factor is called {taken[0]}, and one question, with its `{taken[0]}`, is asked of "
            "all recordings of a study: run a study for each, or rename the factor"
        )


def _held(
    before: Mapping[str, Mapping[str, Any]], recordings: Mapping[str, Mapping[str, str]], asked: str
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the recordings whose row is there, and the row with their factors as they are now.

    A file in the state of the row is not read; of any other the key tells.
    """
    by_path = {path: each for path, each in before.items() if each.get("question") == asked}
    by_key = {each["key"]: each for each in by_path.values() if "key" in each}
    own = frozenset(ROW_HAS)
    for path, factors in recordings.items():
        try:
            state = state_of(Path(path))
            found = by_path.get(path)
            if found is None or any(found.get(name) != value for name, value in state.items()):
                found = by_key.get(key_of(Path(path), asked)) if by_key else None
        except OSError:
            continue
        if found is not None:
            told = {name: value for name, value in found.items() if name in own or "." in name}
            yield path, {**told, **state, "path": path, **factors}


def _counted(
    rows: Iterable[dict[str, Any]], done: int, of: int, progress: Progress | None
) -> Iterator[dict[str, Any]]:
    """Yield rows, and tell how many there are once each is taken."""
    for count, each in enumerate(rows, done + 1):
        yield each
        if progress is not None:
            progress(count, of)


def _written(
    kept: Dataset, rows: Iterable[dict[str, Any]], recordings: Mapping[str, Mapping[str, str]]
) -> Iterator[dict[str, Any]]:
    """Yield rows that are on disk, with their factors; those that wait are written in any case."""
    waiting: list[dict[str, Any]] = []
    last = time.monotonic()
    try:
        for each in rows:
            waiting.append({**each, **recordings[each["path"]]})
            if len(waiting) >= BATCH or time.monotonic() - last > BATCH_TIME:
                kept.write(waiting)
                written, waiting, last = waiting, [], time.monotonic()
                yield from written
    finally:
        kept.write(waiting)
    yield from waiting


def _computed(
    paths: Sequence[str], plan: StudyPlan, workers: int | None
) -> Iterator[dict[str, Any]]:
    """Yield the rows as they are done.

    Where a process dies (out of memory, a signal), its neighbours' work is lost with it: the rest
    is done again, one recording at a time, so that the one that kills is known.
    """
    left = dict.fromkeys(paths)
    if not left:
        return
    try:
        for each in _side_by_side(paths, plan, workers):
            del left[each["path"]]
            yield each
    except BrokenProcessPool:
        yield from (_alone(path, plan) for path in left)


def _side_by_side(
    paths: Sequence[str], plan: StudyPlan, workers: int | None
) -> Iterator[dict[str, Any]]:
    from joblib import Parallel, delayed

    parallel = Parallel(n_jobs=workers or -1, return_as="generator_unordered")
    yield from parallel(delayed(row)(path, plan.task, **plan.question) for path in paths)


def _alone(path: str, plan: StudyPlan) -> dict[str, Any]:
    """Return the row of one recording, computed in a process that has nothing else to do."""
    from joblib.externals.loky import get_reusable_executor

    try:
        worker = get_reusable_executor(max_workers=1)
        found: dict[str, Any] = worker.submit(row, path, plan.task, **plan.question).result()
    except BrokenProcessPool:
        return {
            "path": path,
            "task": plan.task,
            "version": tissue_probe.__version__,
            "status": "failed",
            "sentence": "its process was ended from outside: is there too little memory?",
        }
    return found


def _alike(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Tell files that are the same twice, as their keys are."""
    seen: dict[str, str] = {}
    for each in rows:
        first = seen.setdefault(each.get("key", each["path"]), each["path"])
        if first != each["path"]:
            yield f"{each['path']} has the same bytes as {first}: it counts twice"
