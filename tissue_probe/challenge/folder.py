"""Challenges as files: recordings in one folder, the answers sealed elsewhere.

Contents: writing recordings and answers, reading answers.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tissue_probe.challenge.simulator import Challenge, HiddenTruth, SimulatedRecord
from tissue_probe.errors import ParameterError
from tissue_probe.recording.bags.samples_bag import write_samples_bag
from tissue_probe.signals import SampleBlock

Format = Literal["csv", "mcap"]

VERSION = 1
"""Of the file of answers."""


def write_recordings(folder: Path, name: str, challenge: Challenge, ending: Format) -> None:
    """Write ``NAME.csv`` or ``.mcap`` and ``NAME_second``; nothing in them tells what is hidden.

    CSV has the columns t [s], u [m], F [N], positive in compression.

    Raises
    ------
    ValueError
        If the ending is another.
    FileExistsError
        If there is such a file: a recording is never overwritten.
    OSError
        If a file cannot be written.
    """
    if ending not in ("csv", "mcap"):
        raise ParameterError(f"recordings are csv or mcap, not {ending!r}")
    folder.mkdir(parents=True, exist_ok=True)
    for measured, stem in ((challenge.recording, name), (challenge.second, f"{name}_second")):
        path = folder / f"{stem}.{ending}"
        if ending == "mcap":
            write_samples_bag(path, _block(measured))
        else:
            _write_csv(path, measured)


def _block(measured: SimulatedRecord) -> SampleBlock:
    unknown = np.full(measured.time.size, np.nan)
    return SampleBlock(0, 0, measured.sample_period, measured.position, measured.force, unknown)


def _write_csv(path: Path, measured: SimulatedRecord) -> None:
    columns = np.column_stack([measured.time, measured.position, measured.force])
    with path.open("x", encoding="utf-8") as file:
        np.savetxt(file, columns, fmt="%.10g", delimiter=",", header="t,u,F", comments="")


def seal(path: Path, answers: Mapping[str, HiddenTruth], folder: Path) -> None:
    """Write the answers by the recordings' names, as JSON.

    Raises
    ------
    ValueError
        If the file would lie among the recordings.
    FileExistsError
        If the file exists.
    """
    check_sealed(path, folder)
    told = {
        "version": VERSION,
        "answers": {name: asdict(answer) for name, answer in answers.items()},
    }
    with path.open("x", encoding="utf-8") as file:
        json.dump(told, file, indent=1)
        file.write("\n")


def check_sealed(path: Path, folder: Path) -> None:
    """Refuse a file of answers among the recordings (ValueError), or one there already."""
    if folder.resolve() in path.resolve().parents:
        raise ParameterError(f"{path} lies among the recordings; seal the answers elsewhere")
    if path.exists():
        raise FileExistsError(f"{path} exists; answers are never overwritten, choose another name")


def read_answers(path: Path) -> dict[str, dict[str, Any]]:
    """Return the fields of each ``HiddenTruth`` by the recording's name.

    Raises
    ------
    ValueError
        If the file holds no answers of this version.
    OSError
        If it cannot be read.
    """
    sealed = read_json(path)
    if sealed.get("version") != VERSION or not isinstance(sealed.get("answers"), dict):
        raise ParameterError(
            f"{path} holds no answers of version {VERSION}; give what `make` sealed"
        )
    answers: dict[str, dict[str, Any]] = sealed["answers"]
    return answers


def read_json(path: Path) -> dict[str, Any]:
    """Read a JSON object; ValueError if it is none."""
    try:
        value = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ParameterError(f"{path} is not JSON: {error}") from error
    if not isinstance(value, dict):
        raise ParameterError(f"{path} holds no JSON object")
    return value
