"""One recording as one row: its answer as flat data, or the sentence that says why there is none.

A row is computed in one process, which starts no other, and its values are numbers and texts: any
engine that spreads work (joblib, Dask, Snakemake) can call it, and any table holds it.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, Literal

import tissue_probe
from tissue_probe import arguments as take
from tissue_probe.analysis.comparing import ComparisonResult, compare
from tissue_probe.analysis.diagnosing import DiagnosisResult, diagnosis_of
from tissue_probe.analysis.estimating import EstimateResult, estimate
from tissue_probe.analysis.measurements import Measurements, read_by
from tissue_probe.analysis.question import Asked
from tissue_probe.errors import ParameterError, TissueProbeError
from tissue_probe.one_line import sentence
from tissue_probe.physics.composition import Composition
from tissue_probe.recording.layout import Layout
from tissue_probe.studies.key import key_of, key_of_question, state_of
from tissue_probe.studies.moduli import moduli
from tissue_probe.studies.provenance import UNITS_FROM, provenance, units_not_told

Task = Literal["estimate", "compare", "diagnose"]
TASKS: tuple[Task, ...] = ("estimate", "compare", "diagnose")

#: The names that rows have, beside those with a dot.
ROW_HAS = (
    *("path", "task", "version", "question", "key", "size", "changed", "inode"),
    *("status", "sentence", "seconds", "samples", "duration", "notes"),
    *("stiffness", "stiffness_sd", "damping", "damping_sd", "quality"),
    *("frequency", "storage", "storage_sd", "loss", "loss_sd"),
    *("noise", "error", "heldout_error", "over_noise", "verdict", "missing"),
    *("own", *UNITS_FROM),
)

#: Those of them that a list of recordings shows, where the rows have them; after the factors.
SHOWN = (
    *("status", "stiffness", "damping", "quality", "verdict", "missing", "over_noise", "seconds"),
)

#: Statements on a file's signals, which ``read`` takes.
SIGNAL_STATEMENTS = tuple(each.name for each in fields(Layout))
#: Keywords that ``estimate`` takes.
FILTERED = ("estimator", "settings", "model", "effects", "rig", "restart_at_site", "site")


def check_question(task: Task, question: Mapping[str, Any]) -> None:
    """Refuse a keyword that a task does not take.

    Raises
    ------
    ParameterError
        Names those that it takes.
    """
    known = (*(FILTERED if task == "estimate" else Asked.__annotations__), *SIGNAL_STATEMENTS)
    if unknown := [name for name in question if name not in known]:
        raise ParameterError(f"{task} takes no `{unknown[0]}`; it takes {', '.join(known)}")


@take.checks(path=take.path, task=take.choice(*TASKS))
def row(path: str | Path, task: Task = "estimate", **question: Any) -> dict[str, Any]:
    """Return the answer about one recording as flat data.

    A recording that cannot be read or answered is a row as well, which says why.

    Parameters
    ----------
    path : path
        The recording.
    task : {"estimate", "compare", "diagnose"}
        Which of the functions of these names answers.
    **question
        Keywords of ``read``, and of the task's function.

    Returns
    -------
    dict
        ``path``, ``task``, ``version``, ``question`` (the key of task, keywords and version),
        ``key`` (of the question and the file's bytes), ``size`` [bytes], ``changed`` [ns since
        1970] and ``inode`` of the file, ``seconds`` (taken), ``status``: ``done``, ``refused`` (the
        recording or the question is at fault) or ``failed`` (the program is), and its ``sentence``.
        Where it is done: ``samples``, ``duration`` [s], ``own`` (whether this suite recorded
        it), ``position_unit_from`` and ``force_unit_from`` (values of ``signals.UnitFrom``),
        ``stiffness`` and ``stiffness_sd`` [N/m], ``damping`` and ``damping_sd`` [N s/m],
        ``notes``; where one frequency drives Kelvin-Voigt tissue ``frequency`` [Hz], ``storage``
        and ``loss`` with ``_sd`` [N/m]; and by the task ``quality`` (the filter's status),
        ``noise`` and ``error``, ``heldout_error`` [N, or m where the force is the input],
        ``over_noise``, ``verdict``, ``missing`` (effects, with commas), ``probability.EFFECT``,
        ``value.NAME`` and ``value.NAME.sd`` of each fitted value [SI].

    Raises
    ------
    ParameterError
        If the task takes no such keyword.
    """
    check_question(task, question)
    began = time.perf_counter()
    file = Path(path)
    told: dict[str, Any] = {"path": str(path), "task": task, "version": tissue_probe.__version__}
    try:
        told |= state_of(file)  # before it is read: a change meanwhile is another state
        told |= {"question": key_of_question(task, question)}
        told |= {"key": key_of(file, told["question"])}
        told |= {"status": "done", "sentence": "", **_answer(file, task, question)}
    except (TissueProbeError, OSError) as error:
        told |= {"status": "refused", "sentence": sentence(error)}
    except Exception as error:
        # A mistake of the program in one recording of thousands: the others are not lost by it.
        told |= {"status": "failed", "sentence": f"{type(error).__name__}: {error}"}
    told["seconds"] = time.perf_counter() - began
    return told


def _answer(path: Path, task: Task, question: dict[str, Any]) -> dict[str, Any]:
    signals = {name: given for name, given in question.items() if name in SIGNAL_STATEMENTS}
    asked = {name: given for name, given in question.items() if name not in SIGNAL_STATEMENTS}
    layout = Layout(**signals)
    layout.check_signals()
    measured = read_by(layout, [path])
    found, composition = _by_task(task, measured, asked)
    told = _samples(measured) | provenance(measured.parts[0]) | found
    said = units_not_told(measured.parts[0].recording)
    told["notes"] = "\n".join(filter(None, [told["notes"], *said]))
    if not composition.is_kelvin_voigt:
        return told
    longest = max((each for part in measured.parts for each in part.recording.blocks), key=len)
    return told | moduli(told, longest.position, longest.sample_period)


def _by_task(
    task: Task, measured: Measurements, asked: dict[str, Any]
) -> tuple[dict[str, Any], Composition]:
    """Return the answer of the task's function, and the model that it is of."""
    if task == "estimate":
        filtered = estimate(measured, **asked)
        return _estimated(filtered), _filtered_model(filtered, asked.get("effects", ()))
    # Other rows are computed beside it: it shares its work with no copy of itself.
    compared = compare(measured, workers=1, **asked)
    told = _compared(compared)
    if task == "compare":
        return told, compared.fit.composition
    diagnosed = diagnosis_of(compared, workers=1)
    return told | _diagnosed(diagnosed), diagnosed.found.ladder.final.composition


def _filtered_model(found: EstimateResult, effects: Any) -> Composition:
    if not found.model:
        return Composition()
    from tissue_probe.physics.model_file import load

    return load(found.model, take.several(take.path, "paths")("effects", effects)).composition


def _samples(measured: Measurements) -> dict[str, Any]:
    blocks = [block for part in measured.parts for block in part.recording.blocks]
    return {
        "samples": sum(map(len, blocks)),
        "duration": float(sum(len(block) * block.sample_period for block in blocks)),
    }


def _estimated(found: EstimateResult) -> dict[str, Any]:
    return {
        "stiffness": found.stiffness,
        "stiffness_sd": found.stiffness_deviation,
        "damping": found.damping,
        "damping_sd": found.damping_deviation,
        "quality": found.status.name.lower(),
        "notes": "\n".join(found.notes),
    }


def _compared(found: ComparisonResult) -> dict[str, Any]:
    return {
        **_values(found.to_dict()["parameters"]),
        "noise": found.noise,
        "error": found.rmse,
        "heldout_error": found.heldout_rmse,
        "notes": "\n".join(found.notes),
    }


def _diagnosed(found: DiagnosisResult) -> dict[str, Any]:
    answer = found.to_dict()
    errors = answer["errors"]
    probabilities: dict[str, float] = {}
    for model in answer["models"]:
        for effect in model["effects"]:
            name = f"probability.{effect}"
            probabilities[name] = probabilities.get(name, 0.0) + model["probability"]
    return {
        **_values({each["name"]: each for each in answer["values"]}),
        **probabilities,
        "verdict": answer["verdict"],
        "missing": ", ".join(answer["effects"]),
        "noise": errors["noise"],
        "error": errors["fitted"],
        "heldout_error": errors["heldout"],
        "over_noise": errors["over_noise"],
    }


def _values(found: dict[str, Any]) -> dict[str, Any]:
    """Return fitted values and their errors, stiffness and damping under their own names."""
    told: dict[str, Any] = {}
    for name, each in found.items():
        plain = name if name in ("stiffness", "damping") else f"value.{name}"
        sd = f"{plain}_sd" if plain == name else f"{plain}.sd"
        told |= {plain: each["value"], sd: each["deviation"]}
    return told
