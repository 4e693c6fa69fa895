"""The experiment that the diagnosis suggests, as the models see it.

Contents: the motion, and each model's answer to it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import tissue_probe as tp
from tissue_probe.analysis.diagnosing import DiagnosisResult
from tissue_probe.workbench.decimation import lines
from tissue_probe.workbench.page_messages import NextMessage
from tissue_probe.workbench.refusal import RequestRefused

#: Width of the plot; of more columns there would be several a pixel.
PIXELS = 1500
#: Models that are drawn: a plot of more lines cannot be read.
MODELS_DRAWN = 3


def next_experiment(
    result: DiagnosisResult | None,
) -> tuple[NextMessage, dict[str, NDArray[Any]]]:
    """Return the suggested experiment: its motion, and the output that each rival model predicts.

    Raises
    ------
    Refused
        If nothing is diagnosed yet, or no excitation is suggested.
    """
    if result is None:
        raise RequestRefused("the ranking suggests the next experiment: compute it first")
    suggestion = result.found.suggestion
    if suggestion is None or not suggestion.excitation:
        raise RequestRefused("no excitation would tell more")
    fit = result.found.ladder.base
    rate = 1.0 / fit.measurements[0].sample_period
    rivals = dict(list(result.rivals.items())[:MODELS_DRAWN])
    signals: dict[str, NDArray[Any]] = {}
    for number, model in enumerate(rivals.values()):
        made = tp.simulate(
            model,
            dict(suggestion.excitation),
            duration=suggestion.duration,
            sample_rate=rate,
            mean=suggestion.preload,
        )
        signals["position"] = made.position
        signals[f"output{number}"] = getattr(made, fit.output.name)
    count = signals["position"].size
    numbers, drawn = lines(signals, 0, count, PIXELS)
    found: dict[str, NDArray[Any]] = {"time": numbers / rate}
    found |= {name: each.astype(np.float32) for name, each in drawn.items()}
    return {"models": list(rivals), "separation": suggestion.separation}, found
