"""A diagnosis in a process of its own: ``python -m tissue_probe.analysis.monitor_worker``.

A ``MonitorQuestion`` or ``RecordsQuestion`` comes in, a ``MonitorAnswer`` or ``RecordsVerdict``, or
the sentence why there is none, goes out, as ``side_answer`` has it.

Contents: the process, and the answers to both questions.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tissue_probe import side_answer
from tissue_probe.monitoring.experiments import find_possible_experiments, measure_coil_response
from tissue_probe.monitoring.identification import RecordsQuestion, RecordsVerdict
from tissue_probe.monitoring.question import MonitorAnswer, MonitorQuestion
from tissue_probe.physics.rigs import RIGS
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from tissue_probe.analysis.diagnosing import DiagnosisResult
    from tissue_probe.analysis.question import ModelQuestion

#: Effects that are less probable are not told.
WORTH_TELLING = 0.01


def answer(question: MonitorQuestion | RecordsQuestion, say: side_answer.Say) -> MonitorAnswer:
    """Answer either question, without a word before."""
    if isinstance(question, RecordsQuestion):
        return answer_records(question)
    return answer_question(question)


def answer_question(question: MonitorQuestion) -> MonitorAnswer:
    """Diagnose the samples of a question.

    Raises
    ------
    TissueProbeError
        If they, or the model, cannot be used; says why, and the remedy.
    """
    from tissue_probe.analysis.diagnosing import diagnose_read
    from tissue_probe.analysis.measurements import read

    columns = _columns(question.position, question.force, question.sample_period)
    measured = read(columns, force_polarity="compression")
    return MonitorAnswer(**_tell(diagnose_read(_ask(question), measured)))


def answer_records(question: RecordsQuestion) -> RecordsVerdict:
    """Diagnose the records of a question together, and choose the next excitation.

    Raises
    ------
    TissueProbeError
        If they, or the model, cannot be used; says why, and the remedy.
    """
    from tissue_probe.analysis.diagnosing import diagnose_read
    from tissue_probe.analysis.measurements import Measurements, read

    first = question.records[0]
    coil = measure_coil_response(first.position, first.force, first.command)
    made = [each.excitation for each in question.records]
    possible = find_possible_experiments(question.bounds, coil, made, question.probability)
    columns = [_columns(each.position, each.force, each.sample_period) for each in question.records]
    measured = read(*columns, force_polarity="compression")
    named = (
        replace(part, name=Path(each.path).name, path=Path(each.path)) if each.path else part
        for part, each in zip(measured.parts, question.records, strict=True)
    )
    found = diagnose_read(_ask(question), Measurements(tuple(named)), possible=possible)
    advice = found.found.suggestion
    excitation: dict[str, object] = {}
    if advice is not None and advice.excitation:
        excitation = {**advice.excitation, "amplitude": possible.amplitude / coil.gain}
    return RecordsVerdict(
        **_tell(found),
        probability=found.found.ladder.posterior.probabilities[0],
        excitation=excitation,
        duration=advice.duration if excitation and advice is not None else 0.0,
    )


def _columns(position: FloatArray, force: FloatArray, period: float) -> dict[str, FloatArray]:
    return {"t": np.arange(force.size, dtype=np.float64) * period, "u": position, "F": force}


def _ask(asked: MonitorQuestion | RecordsQuestion) -> ModelQuestion:
    from tissue_probe.analysis.question import question

    return question(
        starts="moving",
        rig=RIGS[asked.rig],
        model=asked.model or None,
        effects=asked.effects,
        constants=asked.constants,
    )


def _tell(found: DiagnosisResult) -> dict[str, Any]:
    """Return what both verdicts tell, by name."""
    told = found.answer
    likely = [(e.effect, e.probability) for e in told.ranking if e.probability is not None]
    likely = [each for each in likely if each[1] >= WORTH_TELLING]
    advice = told.suggested_excitation
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "model.yaml")
        found.model.save(path)
        proposed = path.read_text(encoding="utf-8")
    noise = told.noise_floor
    return {
        "verdict": told.verdict,
        "effects": tuple(sorted(likely, key=lambda each: -each[1])),
        "error_current": (told.rmse.training.base or np.nan) / (noise or np.nan),
        "error_proposed": (told.rmse.training.final or np.nan) / (noise or np.nan),
        "unseen": tuple(told.unseen),
        "experiment": ("" if advice is None else (found.next_experiment or advice.calibration)),
        "text": found.text,
        "proposed_model": proposed,
    }


if __name__ == "__main__":
    side_answer.answer_question(answer)
