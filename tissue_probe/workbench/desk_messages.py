"""The desk as a page is told of it: all but the samples, as JSON holds it.

Contents: names and layout of that.
"""

from __future__ import annotations

import time
from dataclasses import asdict
from typing import Any, cast

from tissue_probe.analysis import fit_shown
from tissue_probe.analysis.choices import RIG_CARDS
from tissue_probe.analysis.comparing import ComparisonResult
from tissue_probe.quantities import SIDE
from tissue_probe.recording.units import FORCE_UNITS, POSITION_UNITS, TIME_UNITS, VELOCITY_UNITS
from tissue_probe.workbench import examples
from tissue_probe.workbench.desk import Desk, Ranking, Rung
from tissue_probe.workbench.map_messages import tell_map
from tissue_probe.workbench.opened_file import Opened
from tissue_probe.workbench.page_messages import (
    AnswerMessage,
    ChoicesMessage,
    DeskMessage,
    FileMessage,
    ItemMessage,
    JobMessage,
    MapMessage,
    ParameterMessage,
    PreviewMessage,
    ProblemMessage,
    QuantityMessage,
    RankingMessage,
    RungMessage,
    SecondMessage,
    StretchesMessage,
)
from tissue_probe.workbench.question import PAGE_ITEMS
from tissue_probe.workbench.refusal import RequestRefused

#: A slider goes to this many times its 95 % interval, and at least so far from the value in shares
#: of it: to see the influence of a parameter it must be moved by more than it is known.
INTERVALS, LEAST_REACH = 4.0, 0.5


def choices(live: bool, commands: bool) -> ChoicesMessage:
    """Return the choices of the forms, and whether ROS is heard and its nodes obey."""
    return {
        "question": [cast(ItemMessage, each._asdict()) for each in PAGE_ITEMS if each.label],
        "rigs": [
            {"name": each["name"], "whose": each["whose"], "drawing": each["drawing"]}
            for each in RIG_CARDS
        ],
        "position_unit": [*POSITION_UNITS, *VELOCITY_UNITS],
        "force_unit": [*FORCE_UNITS],
        "time_unit": [*TIME_UNITS],
        "examples": examples.describe_examples(),
        "live": live,
        "commands": commands,
    }


def desk(desk: Desk) -> DeskMessage:
    """Return the whole desk; files by their names, since no page is to know where they lie."""
    told: DeskMessage = {
        "files": [_file(opened) for opened in desk.files.values()],
        "fitted": desk.fitted,
        "second": desk.second,
        "asked": desk.asked.parameters(),
        "rungs": [_describe_rung(rung) for rung in desk.rungs],
        "ranking": _describe_ranking(desk.ranking),
        "map": _map(desk),
        "own": desk.own,
        "job": job(desk),
        "wants_rig": desk.wants_rig,
        "refusal": None if desk.refusal is None else _problem(desk.refusal),
    }
    return cast(DeskMessage, without_paths(desk, told))


def without_paths(desk: Desk, told: Any) -> Any:
    """Return a message with each file's name in the place of its path."""
    if isinstance(told, str):
        for opened in desk.files.values():
            told = told.replace(str(opened.path), opened.name)
        return told
    if isinstance(told, dict):
        return {key: without_paths(desk, value) for key, value in told.items()}
    return [without_paths(desk, each) for each in told] if isinstance(told, (list, tuple)) else told


def _problem(refused: RequestRefused) -> ProblemMessage:
    return {"told": str(refused), "fields": refused.fields}


def job(desk: Desk) -> JobMessage | None:
    """Return the job under way, with the rows of a ranking so far."""
    if desk.job is None:
        return None
    return {
        "title": desk.job.title,
        "doing": desk.job.doing,
        "share": desk.job.share,
        "seconds": round(time.time() - desk.job.begun, 1),
        "rows": desk.ranking.told if desk.ranking and desk.ranking.result is None else {},
    }


def _file(opened: Opened) -> FileMessage:
    told: FileMessage = {
        "number": opened.number,
        "name": opened.name,
        "layout": opened.layout,
        "ready": opened.measured is not None,
        "table": opened.table,
        "problem": None,
        "preview": None,
    }
    if opened.problem is not None:
        told["problem"] = _problem(opened.problem)
    if opened.preview is not None:
        told["preview"] = cast(PreviewMessage, asdict(opened.preview))
    if opened.measured is not None:
        parts = [part.recording for part in opened.measured.parts]
        period = parts[0].blocks[0].sample_period
        told |= {
            "samples": len(opened.measured),
            "rate": 1.0 / period,
            "seconds": len(opened.measured) * period,
            "sites": len({site.site for part in parts for site in part.sites}),
            "notes": list(opened.measured.notes),
        }
    return told


def _describe_rung(rung: Rung) -> RungMessage:
    fit, output = rung.compared.fit, rung.compared.fit.output
    return {
        "number": rung.number,
        "added": rung.added,
        "title": fit_shown.title(fit),
        "output": cast(QuantityMessage, asdict(output)),
        "input": cast(QuantityMessage, asdict(fit.composition.input)),
        "rmse": rung.compared.rmse,
        "heldout": rung.compared.heldout_rmse,
        "noise": rung.compared.noise,
        "ratio": fit.ratio,
        "converged": fit.converged,
        "parameters": _parameters(rung.compared),
        "text": rung.compared.text,
        "notes": list(rung.compared.notes),
        "stretches": _stretches(rung.compared),
        "second": _second(rung),
        "second_told": rung.second_told,
    }


def _second(rung: Rung) -> SecondMessage | None:
    if rung.second is None:
        return None
    return {
        "rmse": rung.second.rmse,
        "noise": rung.second.noise,
        "stretches": _stretches(rung.second),
    }


def _stretches(compared: ComparisonResult) -> StretchesMessage:
    fit = compared.fit
    return {
        "names": list(compared.sources),
        "worst": fit.worst,
        "seconds": [m.times[-1] + m.sample_period for m in fit.measurements],
        "samples": [m.position.size for m in fit.measurements],
    }


def _parameters(compared: ComparisonResult) -> list[ParameterMessage]:
    """Return fitted values with their intervals, and how far a slider goes."""
    entries = {entry.name: entry for entry in compared.fit.entries}
    found = []
    for row in compared.parameters.to_dict():
        entry, value = entries[row["name"]], row["value"]
        known = max(INTERVALS * SIDE * row["deviation"], LEAST_REACH * abs(value))
        far = known or LEAST_REACH * abs(entry.default) or 1.0
        ends = {"from": max(value - far, entry.lower), "to": min(value + far, entry.upper)}
        found.append(cast(ParameterMessage, row | ends))
    return found


def _describe_ranking(ranking: Ranking | None) -> RankingMessage | None:
    if ranking is None:
        return None
    told: RankingMessage = {"rung": ranking.rung, "rows": ranking.told, "done": False}
    if ranking.result is not None:
        result = ranking.result
        suggestion = result.found.suggestion
        told |= {
            "done": True,
            "answer": cast(AnswerMessage, ranking.answer),
            "text": result.text,
            "shape": ranking.shape,
            "converged": result.converged,
            "physics": {row["effect"]: row["physics"] for row in _physics(ranking)},
            "rivals": list(result.rivals),
            "settings": _settings(ranking) if suggestion and suggestion.excitation else {},
        }
    return told


def _settings(ranking: Ranking) -> dict[str, str]:
    from tissue_probe.analysis.verdict_in_words import settings

    result = ranking.result
    assert result is not None
    assert result.found.suggestion is not None
    return settings(result.found.suggestion, result.asked.composition.rig)


def _physics(ranking: Ranking) -> list[dict[str, str]]:
    assert ranking.result is not None
    return [
        {"effect": effect.name, "physics": effect.physics}
        for fit in ranking.result.found.ladder.ranking
        for effect in fit.composition.effects[-1:]
    ]


def _map(desk: Desk) -> MapMessage | None:
    """Tell the map but its raster, which each page asks for once a map."""
    if desk.map is None or desk.mapped is None:
        return None
    file, number = desk.mapped
    site = desk.asked.of_samples()["site"]
    return {**tell_map(desk.map), "number": number, "file": file, "site": site}
