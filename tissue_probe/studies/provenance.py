"""Whether rows can stand beside each other: what tells their units, and what was asked of them.

Values of rows are in SI units. Files that tell their own units can so be mixed; where some tell
them and others do not, or a statement overrules some, a factor of a thousand may be in between.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from tissue_probe.analysis.measurements import ReadRecording
from tissue_probe.errors import ParameterError
from tissue_probe.signals import SCALED, Recording, UnitFrom

#: Columns of rows: what tells the unit of each signal.
UNITS_FROM = tuple(f"{role}_unit_from" for role in SCALED)
#: Names of columns that tell their unit.
_EXAMPLES = {"position": "u_mm", "force": "F_mN"}


def provenance(part: ReadRecording) -> dict[str, Any]:
    """Return whether this suite recorded it, and what tells the units; of bags it is the file."""
    found = part.recording.units_from
    units = {f"{role}_unit_from": str(found.get(role, UnitFrom.FILE)) for role in SCALED}
    return {"own": part.is_own, **units}


def units_not_told(recording: Recording) -> Iterator[str]:
    """Yield a sentence for each signal whose unit the file does not tell."""
    for role, what in recording.units_from.items():
        if what is UnitFrom.NAME:
            yield f"the file tells no unit of the {role}: it is taken in SI units"
        if what is UnitFrom.STATEMENT:
            yield f"the file tells no unit of the {role}: it is taken as `{role}_unit` states"


def doubts(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield in sentences why values of some rows may be in other units, or of other rigs."""
    done = [each for each in rows if each["status"] == "done"]
    for role in SCALED:
        yield from _doubts_of_units(done, role)
    if (own := [each for each in done if each.get("own")]) and len(own) < len(done):
        yield (
            f"{_some(own, done)} recorded by this suite, the others were not, and one rig is "
            "supposed of all: run a study for each rig if there are two"
        )


def _doubts_of_units(done: Sequence[Mapping[str, Any]], role: str) -> Iterator[str]:
    by: dict[str, list[Mapping[str, Any]]] = {}
    for each in done:
        by.setdefault(each.get(f"{role}_unit_from", ""), []).append(each)
    if overruled := by.get(UnitFrom.OVERRULED):
        yield (
            f"{_some(overruled, done)} taken in the `{role}_unit` of the question although the "
            f"file tells another: leave out `{role}_unit` if the files are right"
        )
    if (supposed := by.get(UnitFrom.NAME)) and UnitFrom.FILE in by:
        yield (
            f"{_some(supposed, done)} taken in SI units since the file tells no unit of the "
            f"{role}, and others tell theirs: write it into the column's name, such as "
            f"{_EXAMPLES[role]}"
        )


def _some(some: Sequence[Mapping[str, Any]], of: Sequence[Any]) -> str:
    first = Path(some[0]["path"]).name
    verb = "was" if len(some) == 1 else "were"
    return f"{len(some)} of {len(of)} recordings ({first} first) {verb}"


def refuse_two_questions(rows: Sequence[Mapping[str, Any]], by: str | None) -> None:
    """Refuse rows of one group that do not answer one question, such as those of two studies.

    Parameters
    ----------
    rows : sequence of mapping
        Have ``question``, the key of task, keywords (the rig is one) and version.
    by : str, optional
        The factor of the groups; without one all are a group.

    Raises
    ------
    ParameterError
        Names the group.
    """
    asked: dict[str, set[str]] = {}
    for each in rows:
        asked.setdefault(str(each[by]) if by else "", set()).add(each.get("question", ""))
    for group, found in asked.items():
        if len(found) > 1:
            which = f"rows with {by} {group}" if by else "the rows"
            raise ParameterError(
                f"{which} answer {len(found)} questions (another task, rig, keyword or version), "
                "whose values are not to be put together: compare them by a factor that tells "
                "these apart, or take one"
            )
