"""A diagnosis in a process of its own: ``python -m tissue_probe.analysis.monitor_worker``.

A pickled ``Question`` comes in on standard input, a pickled ``Verdict``, or the sentence why there
is none, goes out on standard output; then the process ends.

Contents: the process, and the answer to a question.
"""

from __future__ import annotations

import pickle
import signal
import sys
import tempfile
from pathlib import Path

import numpy as np

from tissue_probe.errors import TissueProbeError
from tissue_probe.monitoring.question import Question, Verdict
from tissue_probe.one_line import sentence
from tissue_probe.physics.rigs import RIGS

#: Effects that are less probable are not told.
WORTH_TELLING = 0.01


def main() -> None:
    """Answer one question."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # meant for who asks
    question = pickle.load(sys.stdin.buffer)
    try:
        answer: Verdict | str = answer_question(question)
    except (TissueProbeError, OSError) as error:
        answer = sentence(error)
    pickle.dump(answer, sys.stdout.buffer)


def answer_question(question: Question) -> Verdict:
    """Diagnose the samples of a question.

    Raises
    ------
    TissueProbeError
        If they, or the model, cannot be used; says why, and the remedy.
    """
    from tissue_probe.analysis.diagnosing import diagnose
    from tissue_probe.analysis.measurements import read

    columns = {
        "t": np.arange(question.force.size) * question.sample_period,
        "u": question.position,
        "F": question.force,
    }
    found = diagnose(
        read(columns, force_polarity="compression"),
        workers=1,
        starts="moving",
        rig=RIGS[question.rig],
        model=question.model or None,
        effects=question.effects,
        constants=question.constants,
    )
    told = found.answer
    likely = [(e.effect, e.probability) for e in told.ranking if e.probability is not None]
    likely = [each for each in likely if each[1] >= WORTH_TELLING]
    advice = told.suggested_excitation
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "model.yaml")
        found.model.save(path)
        proposed = path.read_text(encoding="utf-8")
    noise = told.noise_floor
    return Verdict(
        verdict=told.verdict,
        effects=tuple(sorted(likely, key=lambda each: -each[1])),
        error_current=(told.rmse.training.base or np.nan) / (noise or np.nan),
        error_proposed=(told.rmse.training.final or np.nan) / (noise or np.nan),
        unseen=tuple(told.unseen),
        experiment="" if advice is None else (found.next_experiment or advice.calibration),
        text=found.text,
        proposed_model=proposed,
    )


if __name__ == "__main__":
    main()
