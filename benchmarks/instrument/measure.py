"""Records of the instrument's measure, two at a time.

Contents: processes, and telling of each record.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed

from benchmarks.instrument.groups import outcome_of
from benchmarks.instrument.outcome import Outcome

#: Records at a time.
PROCESSES = 2
#: A diagnosis's own threads would wait for those of the other one.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def measure(
    groups: Sequence[str], count: int, first_seed: int, say: Callable[[str], None] = print
) -> list[Outcome]:
    """Return the marks of ``count`` records of each group, in the order of groups and seeds.

    ``say`` is told of each as it is marked.
    """
    os.environ.update(ONE_THREAD)
    wanted = [(group, first_seed + i) for group in groups for i in range(count)]
    # Begun anew and not copied: a copy would have this process's threads' locks.
    with ProcessPoolExecutor(PROCESSES, multiprocessing.get_context("spawn")) as pool:
        asked = {pool.submit(outcome_of, *one): one for one in wanted}
        found = {}
        for future in as_completed(asked):
            found[asked[future]] = future.result()
            say(told(found[asked[future]]))
    return [found[one] for one in wanted]


def told(outcome: Outcome) -> str:
    """Return what was said of a record, and what is wrong with it, in a line."""
    begin = f"{outcome.group} {outcome.seed}, {outcome.kind}: {outcome.told}"
    wrong = "; ".join(outcome.wrong)
    return f"{begin}{f' | WRONG: {wrong}' if wrong else ' | right'} [{outcome.seconds:.0f} s]"
