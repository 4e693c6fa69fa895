"""From the rows of a study to its page.

Contents: the work, the exclusions, values, factors, effects and recordings that the page tells.
"""

from __future__ import annotations

import datetime
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from shlex import quote
from typing import Any
from urllib.parse import quote as quote_url

import tissue_probe
from tissue_probe.analysis.as_options import as_options
from tissue_probe.analysis.question import Asked
from tissue_probe.errors import ParameterError
from tissue_probe.quantities import SIDE
from tissue_probe.report.study_page import Factor, Forest, Level, Line, StudyFacts, StudyPage
from tissue_probe.studies.exclusion import explain_exclusion
from tissue_probe.studies.over_frequency import plots_over_frequency
from tissue_probe.studies.result import StudyResult, deviation_of
from tissue_probe.studies.row import ROW_HAS, SHOWN, SIGNAL_STATEMENTS
from tissue_probe.studies.spread import Spread

#: Lines of a forest, rows of the list: a reader looks at no more, and the page stays light.
LINES_DRAWN, LISTED = 100, 1000
#: Levels of a factor that are compared; one with more (specimens, days) is only counted.
LEVELS = 12
PARAMETER_UNITS = {"stiffness": "N/m", "damping": "N s/m"}
NAMES = {"stiffness": "Stiffness k", "damping": "Damping beta"}


def page_of(
    found: StudyResult, folder: Path, value: str, specimen: str, by: str | None
) -> StudyPage:
    """Return the page of a study that lies in a folder.

    Raises
    ------
    ParameterError
        If no recording in the statistics has such a value.
    """
    rows, factors = found.rows, _factors(found)
    columns = [*factors, *(name for name in SHOWN if any(name in each for each in rows))]
    links = {each["path"]: _link(each, folder) for each in rows}
    own = [each for each in rows if not links[each["path"]]]
    spread, note = _spread(found, value, specimen, by)
    excluded = [each for each in rows if explain_exclusion(each)]
    return StudyPage(
        title=f"Study of {len(rows)} recordings",
        work=_work(found, excluded),
        notes=found.notes,
        excluded=[
            StudyFacts(_name(each), links[each["path"]], (each["status"], explain_exclusion(each)))
            for each in excluded[:LISTED]
        ],
        forests=list(_forests(found, value, specimen, by, links)),
        over_frequency=list(plots_over_frequency(rows, by, links)),
        spread=list(_spread_lines(spread)) if spread else (),
        spread_note=note,
        factors=[_factor(found, name, value, specimen) for name in factors],
        verdicts=Counter(each["verdict"] for each in rows if "verdict" in each),
        effects=_effects(found),
        columns=columns,
        recordings=[
            StudyFacts(
                _name(each), links[each["path"]], [_cell(each.get(name, "")) for name in columns]
            )
            for each in rows[:LISTED]
        ],
        left=f"The others are in table.csv: {len(rows) - LISTED}." if len(rows) > LISTED else "",
        command=_command(own[0], found.question, folder) if own else "",
        files=[name for name in ("table.csv", "table.parquet") if (folder / name).exists()],
        created=f"tissue_probe {tissue_probe.__version__}; {_now()}",
    )


def _now() -> str:
    return datetime.datetime.now().astimezone().isoformat(" ", "seconds")


def _factors(found: StudyResult) -> list[str]:
    names = dict.fromkeys(name for each in found.rows for name in each)
    return [name for name in names if name not in ROW_HAS and "." not in name]


def _name(row: Mapping[str, Any]) -> str:
    return Path(row["path"]).name


def report_folder(row: Mapping[str, Any]) -> str:
    """Return where, in a study's folder, a recording's own report belongs.

    The key is in it: the report of a recording that has changed since is another one.
    """
    return f"reports/{Path(row['path']).stem}-{row.get('key', '')[:8]}"


def _link(row: Mapping[str, Any], folder: Path) -> str:
    address = f"{report_folder(row)}/report.html"
    return quote_url(address) if (folder / address).exists() else ""


def _command(row: Mapping[str, Any], question: Mapping[str, Any], folder: Path) -> str:
    known = {*Asked.__annotations__, *SIGNAL_STATEMENTS}
    stated = {name: given for name, given in question.items() if name in known}
    stated["output"] = str(folder / report_folder(row))
    return " ".join(["tissue_probe improve", quote(row["path"]), *as_options(stated)])


def _work(found: StudyResult, excluded: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    rows = found.rows
    counts = Counter(each["status"] for each in rows)
    seconds = sum(each.get("seconds", 0.0) for each in rows)
    longest = sum(each.get("duration", 0.0) for each in rows)
    return {
        "Task": ", ".join(sorted({each["task"] for each in rows})),
        "Question": "; ".join(f"{name}: {given}" for name, given in found.question.items()) or "–",
        "Recordings": ", ".join(f"{count} {name}" for name, count in counts.items()),
        "In the statistics": f"{len(rows) - len(excluded)} of {len(rows)}",
        "Measured": f"{longest:.4g} s",
        "Computed": f"in {seconds:.3g} s of one processor; {found.computed} recordings by this run",
        "Version": ", ".join(sorted({each["version"] for each in rows})),
    }


def _spread(
    found: StudyResult, value: str, specimen: str, by: str | None
) -> tuple[Spread | None, str]:
    """Return the spread and a sentence on its value, or why there is none."""
    try:
        return found.spread(value, specimen=specimen, by=by), (
            f"Of {_called(value)}, over {specimen}; 95 % intervals. Each recording counts with the "
            "error that it states."
        )
    except ParameterError as error:
        return None, f"Not told: {error}."


def _spread_lines(found: Spread) -> Iterator[tuple[str, str]]:
    for line in found.text.splitlines()[1:]:
        name, _, told = line.partition(": ")
        yield name, told


def _called(value: str) -> str:
    unit = f" [{PARAMETER_UNITS[value]}]" if value in PARAMETER_UNITS else ""
    return f"{NAMES.get(value, value)}{unit}"


def _forests(
    found: StudyResult, value: str, specimen: str, by: str | None, links: Mapping[str, str]
) -> Iterator[Forest]:
    """Yield the plots; none where all recordings are left out of the statistics."""
    used = [each for each in found.rows if not explain_exclusion(each)]
    for name in dict.fromkeys((value, "stiffness", "damping")) if used else ():
        if name == value or any(name in each for each in used):
            forest = _forest(found, name, specimen, by, links)
            if forest.lines:
                yield forest


def _forest(
    found: StudyResult, value: str, specimen: str, by: str | None, links: Mapping[str, str]
) -> Forest:
    sd = deviation_of(value)
    spread, _ = _spread(found, value, specimen, by)
    factors = [] if spread is None else [specimen, *([by] if by else [])]
    rows = found.take_rows((value, sd, *factors))
    beside = spread.borrowed if spread else len(rows) * [math.nan]
    lines = [
        Line(
            _name(each),
            each[value],
            each[value] - SIDE * each[sd],
            each[value] + SIDE * each[sd],
            beside=float(other),
            link=links[each["path"]],
        )
        for each, other in zip(rows, beside, strict=True)
        if math.isfinite(each[value])
    ]
    means = [] if spread is None else spread.means.items()
    heads = [
        Line(f"mean of {name}" if name else "mean", each.value, each.low, each.high, mean=True)
        for name, each in means
    ]
    note = "Bars: 95 % intervals of each recording alone."
    if spread:
        note += " Rings: its value where its specimen and group count, too. Diamonds: means."
    if len(lines) > LINES_DRAWN:
        note += f" The first {LINES_DRAWN} of {len(lines)} recordings are drawn."
    return Forest(
        NAMES.get(value, value),
        PARAMETER_UNITS.get(value, "SI"),
        note,
        [*heads, *lines[:LINES_DRAWN]],
    )


def _factor(found: StudyResult, name: str, value: str, specimen: str) -> Factor:
    of = Counter(each[name] for each in found.rows if name in each)
    used = Counter(
        each[name] for each in found.rows if name in each and not explain_exclusion(each)
    )
    if len(of) > LEVELS:
        return Factor(name, (), note=f"{len(of)} values: {_few(sorted(of))}.")
    means: dict[str, str] = {}
    contrasts: list[tuple[str, str]] = []
    note = ""
    if name != specimen and len(of) > 1:
        spread, note = _spread(found, value, specimen, name)
        if spread:
            means = {level: str(mean) for level, mean in spread.means.items()}
            contrasts = [(f"{b} less {a}", str(each)) for (a, b), each in spread.contrasts.items()]
    levels = [
        Level(each, count, used[each], means.get(each, "")) for each, count in sorted(of.items())
    ]
    return Factor(name, levels, contrasts, note)


def _few(names: Sequence[str]) -> str:
    shown = ", ".join(names[:LEVELS])
    return f"{shown}, …" if len(names) > LEVELS else shown


def _effects(found: StudyResult) -> list[tuple[str, float, float, float]]:
    if not any("verdict" in each for each in found.rows):
        return []
    return [(name, each.value, each.low, each.high) for name, each in found.missing().items()]


def _cell(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
