"""The newer laws of the library: how often each is named, false alarms, the time.

Contents: the order of the records, and what is told while they are diagnosed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.laws.cases import plan_cases
from benchmarks.laws.kept_rows import KeptRows
from benchmarks.laws.outcome import LawOutcome
from benchmarks.laws.tables import describe
from tissue_probe.challenge.simulator import Rig

#: Clean records on each rig: on both together the 300 of which the goal speaks.
COUNT = 150


def _print_at_once(line: str) -> None:
    print(line, flush=True)


def measure(
    folder: Path,
    laws: Sequence[str],
    rigs: Sequence[Rig],
    count: int,
    first_seed: int,
    say: Callable[[str], None] = _print_at_once,
) -> list[LawOutcome]:
    """Return the outcome of each record; one that was measured before is taken from its file.

    Ctrl-C ends the measurement: of the records so far there are tables, too.

    Parameters
    ----------
    folder : Path
        Where outcomes are kept, line by line.
    laws : sequence of str
        Newer laws, each hidden at three strengths under five excitations on each rig.
    rigs : sequence of str
        "exact", "tolerant".
    count : int
        Clean records on each rig; beside each one of 2 s there is one with an earlier effect.
    first_seed : int
        Of the first record.
    say : callable
        Told of each record.
    """
    kept, outcomes = KeptRows(folder), []
    say(f"outcomes are kept in {kept.path}: the same command goes on there")
    try:
        for outcome in kept.ask_all(plan_cases(laws, rigs, count, first_seed)):
            outcomes.append(outcome)
            say(_line(outcome))
    except KeyboardInterrupt:
        say(f"interrupted: these are the first {len(outcomes)} records")
    return outcomes


def _line(outcome: LawOutcome) -> str:
    case, said = outcome.case, outcome.said
    hidden = "+".join(case.hidden) or case.part
    marks = "absorbed" if outcome.absorbed else ""
    if case.part == "law" and not outcome.absorbed:
        marks = "alone" if outcome.is_alone else "among" if outcome.is_among else "MISSED"
        by_name = "" if outcome.by_name is None else f" {outcome.by_name:+.0f}"
        marks += f" ({outcome.cause}{by_name})" if outcome.cause else ""
        marks += "" if outcome.second is None else f" second {outcome.second:.2f}"
    elif case.part != "law" and outcome.before:
        same = (outcome.before.verdict, outcome.before.effects) == (said.verdict, said.effects)
        marks += "" if same else f" before: {outcome.before.verdict} {outcome.before.effects}"
    return (
        f"{case.seed} {case.rig:8s} {case.excitation:9s} {hidden} ({outcome.ratio:.1f}): "
        f"{said.verdict} {describe(outcome)} {said.seconds:.1f} s {marks}"
    )
