"""What the diagnosis says of records whose truth is known, and whether it is right.

Contents: asking through the public interface, and marks. Of ``tissue_probe`` nothing but its public
interface is imported.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import tissue_probe as tp
from benchmarks.ruler.dealt import Dealt, Record, Truth
from benchmarks.ruler.probabilities import Stated, stated

#: Half the width of a 95 % interval, in standard deviations.
HALF_WIDTH = 1.96
NAMING = ("missing", "ambiguous")
#: Standard deviations by which a value of the instrument is surely not 0.
SURELY = 3.0


@dataclass(frozen=True)
class Outcome:
    """What was said of one record.

    Attributes
    ----------
    protocol, seed, hidden, ratio
        Of the record: see ``Dealt`` and ``Truth``.
    refused : str
        The sentence, where there was no diagnosis; else empty.
    verdict : str
        As said.
    effects, ranking : list of str
        What is missing, and what ranks first, of at most three.
    right : bool
        Nothing hidden: ``adequate``. Else: the verdict names effects, and the first of the
        ranking is the hidden one or of its family; or ``paired``.
    paired : bool
        A constant of the force is told as another place of touch, and that both are one and the
        same in this record.
    exact : bool
        The same, by the hidden effect's own name.
    error : float or None
        Of the last model on the second record, over that record's noise.
    inside, intervals : int
        Nothing hidden: how many of how many 95 % intervals of the model asked about hold the true
        value.
    outside : dict of str to str
        Those that do not: value, half width, truth.
    seconds : float
        Time that the diagnosis took.
    stated : Stated or None
        With which probability; None where there was no diagnosis.
    """

    protocol: str
    seed: int
    hidden: str
    ratio: float
    refused: str = ""
    verdict: str = ""
    effects: tuple[str, ...] = ()
    ranking: tuple[str, ...] = ()
    right: bool = False
    paired: bool = False
    exact: bool = False
    error: float | None = None
    inside: int = 0
    intervals: int = 0
    outside: Mapping[str, str] | None = None
    seconds: float = 0.0
    stated: Stated | None = None


def measure(dealt: Iterable[Dealt], say: Callable[[str], None] = print) -> list[Outcome]:
    """Diagnose every record; ``say`` is told of each as it is marked."""
    outcomes = []
    for one in dealt:
        outcomes.append(mark(one))
        say(told(outcomes[-1]))
    return outcomes


def mark(dealt: Dealt) -> Outcome:
    """Diagnose a record with the second one beside it, and mark the diagnosis."""
    truth, began = dealt.truth, time.perf_counter()
    asked = {"protocol": dealt.protocol, "seed": dealt.seed}
    asked |= {"hidden": truth.hidden, "ratio": truth.ratio}
    try:
        found = answer(dealt.first, dealt.second, dealt.arguments)
    except Exception as error:
        # Whatever ends a diagnosis is a refusal, an untold exception of a library too.
        kind = "" if isinstance(error, tp.TissueProbeError) else f"{type(error).__name__}: "
        return Outcome(**asked, refused=f"{kind}{error}", seconds=time.perf_counter() - began)
    inside, outside = _intervals(found["ladder"][0]["parameters"], truth.values)
    ranking = found["ranking"]
    error = found["rmse"]["heldout"]["final"]
    return Outcome(
        **asked,
        verdict=found["verdict"],
        effects=tuple(found["effects"]),
        ranking=tuple(each["effect"] for each in ranking[:3]),
        right=is_right(found, truth),
        paired=is_paired(found, truth),
        exact=_right(found, truth.hidden, "effect", truth.effects),
        error=None if error is None else error / dealt.second.noise,
        inside=0 if truth.hidden else inside,
        intervals=0 if truth.hidden else inside + len(outside),
        outside={} if truth.hidden else outside,
        seconds=time.perf_counter() - began,
        stated=_stated(found, truth),
    )


def answer(first: Record, second: Record | None, arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return the answer for programs; the second record, if there is one, validates."""
    read = [
        record and tp.read(record.columns(), force_polarity="compression")
        for record in (first, second)
    ]
    return tp.diagnose(read[0], validate=read[1], **arguments).to_dict()


def is_right(found: Mapping[str, Any], truth: Truth) -> bool:
    """Whether an answer is right: see ``Outcome``."""
    return _right(found, truth.hidden, "family", truth.families) or is_paired(found, truth)


def is_paired(found: Mapping[str, Any], truth: Truth) -> bool:
    """Whether a constant of the force is told as what it cannot be told from: see ``Outcome``."""
    same = [
        each
        for each in found.get("instrument", [])
        if set(each["degenerate_with"]) & set(truth.effects)
        and abs(each["value"]) > SURELY * each["deviation"]
    ]
    return found["verdict"] == "adequate" and bool(same)


def _stated(found: Mapping[str, Any], truth: Truth) -> Stated:
    """Return what is stated; of hidden terms that are no form of the library a sibling is right."""
    families = {each["effect"]: each["family"] for each in found["ranking"]}
    alike = [name for name, family in families.items() if family in truth.families]
    models = [[name] for name in {*truth.effects, *alike}] if truth.hidden else []
    return stated(found, models, truth.families)


def _right(found: Mapping[str, Any], hidden: str, key: str, answers: tuple[str, ...]) -> bool:
    if not hidden:
        return found["verdict"] == "adequate"
    first = found["ranking"][:1]
    return found["verdict"] in NAMING and bool(first) and first[0][key] in answers


def _intervals(
    parameters: Mapping[str, Mapping[str, Any]], truths: Mapping[str, float]
) -> tuple[int, dict[str, str]]:
    """Return how many intervals hold the truth, and those that do not."""
    inside, outside = 0, {}
    for name, true in truths.items():
        entry = parameters.get(name)
        if entry is None or not entry["deviation"]:
            continue  # held, or not in this model
        half = HALF_WIDTH * entry["deviation"]
        if abs(entry["value"] - true) <= half:
            inside += 1
        else:
            outside[name] = f"{entry['value']:.5g} +- {half:.2g}, true {true:.5g}"
    return inside, outside


def told(outcome: Outcome) -> str:
    """Return what was hidden in a record, and what was said of it, in a line."""
    hidden = f"{outcome.hidden} ({outcome.ratio:.1f})" if outcome.hidden else "none"
    begin = f"{outcome.protocol} {outcome.seed}, {hidden}"
    if outcome.refused:
        return f"{begin}: REFUSED: {outcome.refused}"
    error = "-" if outcome.error is None else f"{outcome.error:.3f}"
    missed = "; ".join(f"{name} {values}" for name, values in (outcome.outside or {}).items())
    return (
        f"{begin}: {'right' if outcome.right else 'WRONG'}: {outcome.verdict} "
        f"{'+'.join(outcome.effects)}; ranking {', '.join(outcome.ranking)}; error / noise {error}"
        f"{f'; outside: {missed}' if missed else ''} [{outcome.seconds:.0f} s]"
    )
