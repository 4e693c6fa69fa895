"""The outcomes as tables: a row a law, what was named instead, false alarms, the time.

Contents: each table, with what is to be reached.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from rich.table import Table

from benchmarks.laws.cases import STEADY, TIMED
from benchmarks.laws.outcome import LawOutcome

#: To be reached: named alone, named or in a set, false alarms [%]; time over that before [-].
ALONE, AMONG, ALARMS, LONGER = ">= 70 %", ">= 90 %", "<= 2 %", "<= 1.5"


def tables(outcomes: Sequence[LawOutcome]) -> Iterator[Table]:
    """Yield the tables of a run, each of the records that there are."""
    laws = [each for each in outcomes if each.case.part == "law"]
    for rig in dict.fromkeys(each.case.rig for each in laws):
        own = [each for each in laws if each.case.rig == rig]
        yield _rows_of_laws(rig, own)
        missed = [each for each in own if not (each.is_right or each.absorbed)]
        if missed:
            yield _said_instead(rig, missed)
    yield _alarms([each for each in outcomes if each.case.part != "law"])
    yield _time([each for each in outcomes if each.before])


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", caption_justify="left")
    for column in columns:
        table.add_column(column, justify="left" if column == columns[0] else "right")
    return table


def _rows_of_laws(rig: str, outcomes: Sequence[LawOutcome]) -> Table:
    table = _table(
        f"Newer laws, {rig} rig",
        "hidden",
        *("records", "named\nalone", "alone, or\nin a set", "second\nrecord"),
        *("steady\nsine", "named\nalone", "alone, or\nin a set", "absorbed"),
    )
    for law in dict.fromkeys(each.case.law for each in outcomes):
        table.add_row(law, *_row([each for each in outcomes if each.case.law == law]))
    table.add_section()
    table.add_row("all", *_row(outcomes))
    table.add_row("to reach", "", ALONE, AMONG)
    table.caption = (
        "in a set: of at most three effects, or of one family\n"
        "second record: error over noise where exactly what was hidden is added, median\n"
        "steady sine: apart, since one record of it cannot tell many laws; absorbed: by\n"
        "Kelvin-Voigt, and counted nowhere else"
    )
    return table


def _row(outcomes: Sequence[LawOutcome]) -> Iterator[str]:
    shown = [each for each in outcomes if not each.absorbed]
    for steady in (False, True):
        own = [each for each in shown if (each.case.excitation == STEADY) == steady]
        yield str(len(own))
        yield share([each.is_alone for each in own])
        yield share([each.is_among for each in own])
        if not steady:
            errors = [each.second for each in own if each.second is not None]
            yield f"{np.median(errors):.2f}" if errors else "-"
    yield str(len(outcomes) - len(shown))


def _said_instead(rig: str, outcomes: Sequence[LawOutcome]) -> Table:
    table = _table(f"What was said where the law was not first, {rig} rig", "hidden", "cause")
    table.add_column("said")
    for law in dict.fromkeys(each.case.law for each in outcomes):
        own = [each for each in outcomes if each.case.law == law]
        for cause in sorted({each.cause for each in own}):
            said = Counter(describe(each) for each in own if each.cause == cause)
            told = ", ".join(f"{name} {times}" for name, times in said.most_common())
            table.add_row(law, cause, told)
    table.caption = (
        "cause: by the criterion (BIC) of the model with the law, fitted by name. search: it is\n"
        "better by more than 10, so that the search did not find it; not to be told: within 10;\n"
        "search, by name too: that model leaves more than noise, or has no fit"
    )
    return table


def describe(outcome: LawOutcome) -> str:
    """Return what is said of a record in a few words."""
    said = outcome.said
    tied = [name for name in said.tied if name not in said.effects]
    named = "/".join(["+".join(said.effects), *tied])
    seen = " (unseen)" if outcome.case.law in said.unseen else ""
    return f"{named or said.verdict}{seen}"


def _alarms(outcomes: Sequence[LawOutcome]) -> Table:
    table = _table(
        "Records without a newer law", "", "rig", "records", "library before", "library", "to reach"
    )
    for part, title, goal in (
        ("clean", "clean: effect found", ALARMS),
        ("idle", "clean, a channel beside: effect found", ALARMS),
        ("earlier", "earlier effect hidden: named first", ""),
    ):
        own = [each for each in outcomes if each.case.part == part and not each.absorbed]
        for rig in dict.fromkeys(each.case.rig for each in own):
            rows = [each for each in own if each.case.rig == rig]
            table.add_row(title, rig, str(len(rows)), *_before_and_now(part, rows), goal)
    return table


def _before_and_now(part: str, outcomes: Sequence[LawOutcome]) -> Iterator[str]:
    def count(effects: Iterable[tuple[str, tuple[str, ...], tuple[str, ...]]]) -> str:
        if part == "earlier":
            return share([set(named) == set(hidden) for _, named, hidden in effects])
        return share([verdict != "adequate" for verdict, *_ in effects])

    asked = [each for each in outcomes if each.before]
    yield count((e.before.verdict, e.before.effects, e.case.hidden) for e in asked if e.before)
    yield count((e.said.verdict, e.said.effects, e.case.hidden) for e in outcomes)


def _time(outcomes: Sequence[LawOutcome]) -> Table:
    table = _table(
        f"Processor time of a diagnosis of {TIMED:g} s of samples [s]",
        *("", "records", "library before", "library", "over the one before", "to reach"),
    )
    for parts, title in (
        (("clean",), "clean"),
        (("earlier",), "an earlier effect hidden"),
        (("clean", "earlier"), "all"),
    ):
        own = [
            (each.before.seconds, each.said.seconds)
            for each in outcomes
            if each.before and each.case.part in parts
        ]
        if own:
            before, now = np.sum(own, axis=0)
            means = (f"{total / len(own):.2f}" for total in (before, now))
            table.add_row(title, str(len(own)), *means, f"{now / before:.2f}", LONGER)
    table.caption = "means; both in one process, in the same run, their models loaded"
    return table


def share(right: Sequence[bool]) -> str:
    """Return how many of how many, and the share."""
    if not right:
        return "-"
    return f"{sum(right)} of {len(right)}, {100.0 * np.mean(right):.0f} %"
