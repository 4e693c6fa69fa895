"""What a study is of: its recordings with their factors, the question, and where the rows go."""

from __future__ import annotations

import csv
import glob
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tissue_probe import bounded_yaml
from tissue_probe.errors import ParameterError
from tissue_probe.studies.row import TASKS, Task

#: Fields of a study's file.
FIELDS = ("recordings", "pattern", "task", "question", "output")


@dataclass(frozen=True)
class StudyPlan:
    """A study as it is asked for.

    Attributes
    ----------
    recordings : mapping of path to factors
        Such as the specimen, the day, the operator; each has the same ones.
    task : {"estimate", "compare", "diagnose"}
        Of each recording.
    question : mapping
        Keywords of ``row``.
    output : path
        Folder of the rows.
    """

    recordings: Mapping[Path, Mapping[str, str]]
    task: Task = "estimate"
    question: Mapping[str, Any] = field(default_factory=dict)
    output: Path = Path("study")

    @property
    def factors(self) -> tuple[str, ...]:
        """The names of the factors."""
        return tuple(next(iter(self.recordings.values()), {}))


def read_plan(path: str | Path) -> StudyPlan:
    """Return the study that a YAML file describes; its paths count from the file's folder.

    Fields: ``recordings``, a pattern of paths (``data/*.csv``) or a table (``.csv``) with a column
    ``path`` and one a factor; ``pattern``, where factors stand in the names of files
    (``{specimen}_{day}.csv``); ``task``; ``question``; ``output``.

    Raises
    ------
    ParameterError
        If it describes none; says what is wrong in which field.
    """
    path = Path(path)
    try:
        told = bounded_yaml.read(path)
    except bounded_yaml.YamlError as error:
        raise ParameterError(f"{path}: it {error}") from None
    if not isinstance(told, dict) or "recordings" not in told:
        raise ParameterError(
            f"{path} describes no study: give `recordings`, such as recordings: data/*.csv"
        )
    if unknown := [name for name in told if name not in FIELDS]:
        raise ParameterError(f"{path}: no field {unknown[0]}; there are {', '.join(FIELDS)}")
    if told.get("task", "estimate") not in TASKS:
        raise ParameterError(f"{path}: task is {told['task']!r}; it is one of {', '.join(TASKS)}")
    question = told.get("question") or {}
    if not isinstance(question, dict):
        raise ParameterError(f"{path}: question has no names: give lines such as lowpass: 100.0")
    return StudyPlan(
        recordings_of(str(told["recordings"]), told.get("pattern"), path.parent),
        told.get("task", "estimate"),
        question,
        path.parent / str(told.get("output", path.stem)),
    )


def recordings_of(
    wanted: str, pattern: str | None = None, folder: Path = Path()
) -> dict[Path, dict[str, str]]:
    """Return the recordings that a pattern of paths or a table names, with their factors.

    Raises
    ------
    ParameterError
        If there are none, one is named twice or is not there, or a factor is missing.
    """
    table = folder / wanted
    if pattern is None and table.suffix == ".csv" and table.is_file() and _is_list(table):
        return _listed(table)
    found = [Path(each) for each in sorted(glob.glob(str(table), recursive=True))]
    if not found:
        raise ParameterError(f"recordings: no file is named {table}")
    if pattern is None:
        return {each: {} for each in found}
    return {each: _factors_in(each, pattern) for each in found}


def _is_list(table: Path) -> bool:
    with table.open(newline="", encoding="utf-8-sig") as file:
        return "path" in next(csv.reader(file), [])


def _listed(table: Path) -> dict[Path, dict[str, str]]:
    with table.open(newline="", encoding="utf-8-sig") as file:
        lines = list(csv.DictReader(file))
    found: dict[Path, dict[str, str]] = {}
    for number, line in enumerate(lines, 2):
        empty = [name for name, value in line.items() if name and not (value or "").strip()]
        if empty:
            raise ParameterError(f"{table}, line {number}: no {empty[0]} is given: fill it in")
        path = table.parent / line.pop("path")
        if path in found:
            raise ParameterError(f"{table}, line {number}: {path} is named a second time")
        if not path.exists():
            raise ParameterError(f"{table}, line {number}: there is no {path}")
        found[path] = {name: value.strip() for name, value in line.items() if name}
    if not found:
        raise ParameterError(f"{table} names no recording")
    return found


def _factors_in(path: Path, pattern: str) -> dict[str, str]:
    """Return what a file's name says by a pattern such as ``{specimen}_{day}.csv``."""
    names = re.findall(r"\{(\w+)\}", pattern)
    if twice := [name for name, count in Counter(names).items() if count > 1]:
        raise ParameterError(f"pattern {pattern}: {{{twice[0]}}} stands in it twice")
    parts: Sequence[str] = re.split(r"\{\w+\}", pattern)
    groups = (f"(?P<{name}>.+?)" for name in names)
    text = "".join(
        re.escape(part) + group for part, group in zip(parts, [*groups, ""], strict=True)
    )
    match = re.fullmatch(text, path.name)
    if match is None:
        raise ParameterError(f"pattern {pattern}: {path.name} is no such name")
    return match.groupdict()
