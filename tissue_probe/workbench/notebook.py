"""A notebook that repeats each step that was made on the page, by the Python interface.

Contents: its cells.
"""

from __future__ import annotations

import json
from typing import Any

from tissue_probe.workbench.desk import Desk


def notebook(desk: Desk) -> str:
    """Return the notebook's file."""
    cells = [
        _text("# The steps of the workbench, again", "Put the recordings beside this notebook."),
        _code("import tissue_probe as tp"),
    ]
    names: dict[int, str] = {}
    for opened in desk.files.values():
        if opened.number not in (desk.fitted, desk.second) or opened.measured is None:
            continue
        names[opened.number] = "recording" if opened.number == desk.fitted else "second"
        layout = "".join(f", {name}={value!r}" for name, value in opened.layout.items())
        name = names[opened.number]
        cells += [_code(f"{name} = tp.read({opened.name!r}{layout})", name)]
    if desk.fitted in names:
        cells += _ladder(desk)
    told = {
        "cells": cells,
        "metadata": {
            "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
            "language_info": {"name": "python"},
        },
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    for number, cell in enumerate(cells):
        cell["id"] = f"step-{number}"
    return json.dumps(told, indent=1) + "\n"


def _ladder(desk: Desk) -> list[dict[str, Any]]:
    asked = {n: v for n, v in desk.asked.parameters().items() if v not in (None, {}, False, "auto")}
    if desk.effects:
        asked["effects"] = [path.rpartition("/")[2] for path in desk.effects]
    stated = "".join(f", {name}={value!r}" for name, value in asked.items())
    cells = [
        _text("## Where the model fails"),
        _code(f"rung0 = tp.compare(recording{stated})", "rung0"),
        _code("rung0.plot()"),
    ]
    for number, rung in enumerate(desk.rungs[1:], start=1):
        cells += [
            _text(f"## With {rung.added}"),
            _code(f"rung{number} = rung{number - 1}.plus({rung.added!r})", f"rung{number}"),
            _code(f"rung{number}.plot()"),
        ]
    last = f"rung{max(len(desk.rungs) - 1, 0)}"
    if desk.second is not None:
        samples = {n: v for n, v in desk.asked.of_samples().items() if v not in (None, "auto")}
        stated_again = "".join(f", {name}={value!r}" for name, value in samples.items())
        cells += [
            _text("## On the second recording, nothing fitted"),
            _code(f"tp.compare(second, model={last}.model{stated_again})"),
        ]
    if desk.ranking is not None and desk.ranking.result is not None:
        validate = ", validate=second" if desk.second is not None else ""
        base = [rung.number for rung in desk.rungs].index(desk.ranking.rung) if any(
            rung.number == desk.ranking.rung for rung in desk.rungs
        ) else 0  # fmt: skip
        if base:
            kept = {n: v for n, v in asked.items() if n not in ("rig", "tissue", "effects")}
            stated = f", model=rung{base}.model" + "".join(f", {n}={v!r}" for n, v in kept.items())
        cells += [
            _text("## Missing effects"),
            _code(f"diagnosis = tp.diagnose(recording{validate}{stated})", "diagnosis"),
        ]
    cells += [_text("## The model"), _code(f'{last}.model.save("model.yaml")')]
    return cells


def _text(*lines: str) -> dict[str, Any]:
    return {"cell_type": "markdown", "metadata": {}, "source": "\n\n".join(lines)}


def _code(*lines: str) -> dict[str, Any]:
    return {
        "cell_type": "code", "metadata": {}, "source": "\n".join(lines), "outputs": [],
        "execution_count": None,
    }  # fmt: skip
