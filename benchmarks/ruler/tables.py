"""The marks of records whose truth is known, as tables.

Contents: shares with their 95 % intervals, for each protocol and in all.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np
from rich.table import Table
from scipy.stats import binomtest

from benchmarks.ruler import probabilities
from benchmarks.ruler.marks import Outcome

#: Error on the second record over its noise, up to which it counts as noise.
NOISE = 1.1
#: Share of the intervals that hold the truth where they are right.
COVERED = 0.95
IN_ALL = "in all"


def tables(title: str, outcomes: Sequence[Outcome]) -> Iterator[Table]:
    """Yield the marks of each protocol, of each hidden part, and the sentences of refusals."""
    yield _marks(f"{title}, by protocol", outcomes, lambda outcome: outcome.protocol)
    hidden = [outcome for outcome in outcomes if outcome.hidden]
    if hidden:
        yield _marks(f"{title}, by what is hidden", hidden, lambda outcome: outcome.hidden)
    told = [outcome.stated for outcome in outcomes if outcome.stated is not None]
    yield probabilities.table(f"{title}: how sure it was", told)
    refused = Counter(outcome.refused for outcome in outcomes if outcome.refused)
    if refused:
        table = Table("refused with", "times", title=f"{title}: refused", title_justify="left")
        for sentence, times in refused.most_common():
            table.add_row(sentence, str(times))
        yield table


def _marks(title: str, outcomes: Sequence[Outcome], kind: Callable[[Outcome], str]) -> Table:
    table = Table(title=title, title_justify="left")
    for column in (
        "", "none hidden: adequate", "hidden: family first", "as the touch", "its name first",
        "error / noise, median", f"<= {NOISE:g}", "intervals that hold the truth", "p", "refused",
    ):  # fmt: skip
        table.add_column(column, justify="right" if column else "left", overflow="fold")
    for name in dict.fromkeys(map(kind, outcomes)):
        table.add_row(name, *_row([each for each in outcomes if kind(each) == name]))
    table.add_section()
    table.add_row(IN_ALL, *_row(outcomes))
    table.caption = (
        "in brackets: 95 % interval of the share (Clopper and Pearson), in %\n"
        "as the touch: a constant of the force told as another place of touch, one and the same\n"
        "error: of the last model on the second record; a record refused counts as above\n"
        "p: of so many intervals or fewer, or as few as rare, were 95 % of them right"
    )
    table.caption_justify = "left"
    return table


def _row(outcomes: Sequence[Outcome]) -> Iterator[str]:
    clean = [each for each in outcomes if not each.hidden]
    hidden = [each for each in outcomes if each.hidden]
    yield share(each.right for each in clean)
    yield share(each.right for each in hidden)
    yield str(sum(each.paired for each in hidden))
    yield share(each.exact for each in hidden)
    errors = [each.error for each in outcomes if each.error is not None]
    yield f"{np.median(errors):.3f}" if errors else "-"
    yield share(each.error is not None and each.error <= NOISE for each in outcomes)
    inside, intervals = (sum(getattr(each, of) for each in clean) for of in ("inside", "intervals"))
    yield f"{inside} of {intervals}" if intervals else "-"
    yield f"{binomtest(inside, intervals, COVERED).pvalue:.2g}" if intervals else "-"
    yield str(sum(bool(each.refused) for each in outcomes))


def share(right: Iterable[bool]) -> str:
    """Return how many of how many, with the 95 % interval of the share in %."""
    marks = list(right)
    if not marks:
        return "-"
    interval = binomtest(sum(marks), len(marks)).proportion_ci(0.95, "exact")
    low, high = (f"{100.0 * end:.0f}" for end in interval)
    return f"{sum(marks)} of {len(marks)} ({low} to {high})"
