"""Figures 7 and 8: one soft material at 10 Hz, its parameters and the force."""

from __future__ import annotations

from functools import cache

import numpy as np

from tissue_probe.reproduction.drawing import LABELS, Runs, draw_line, draw_runs, legend, panels
from tissue_probe.reproduction.experiment import FORCE_NOISE, SimulatedTissue, SineExperiment
from tissue_probe.reproduction.filters import AFEKF, EKF, EVERY, ROBUST
from tissue_probe.reproduction.finding import (
    ReproducedQuantity,
    Reproduction,
    describe_settling,
    error,
)

# 440 N/m is the value of eq. 42 for EcoFlex 00-10; the damping fits the axis of figure 7b.
BASELINE = SineExperiment(((0.0, SimulatedTissue(440.0, 5.0)),))


@cache
def run() -> Runs:
    """Run every filter on the experiment."""
    return {each: each.run(BASELINE) for each in EVERY}


def fig7() -> Reproduction:
    """Draw stiffness, damping and covariance trace from the start."""
    runs, truth = run(), BASELINE.truth()
    found = [_findings(name, known) for name, known in zip(("k", "β"), truth, strict=True)]
    trace = {each: f"{estimates.covariance_trace[-1]:.2g}" for each, estimates in runs.items()}
    last = ReproducedQuantity(
        "covariance trace at the end",
        "falls, that of the AFEKF less",
        f"EKF {trace[EKF]}, AFEKF {trace[AFEKF]}",
        trace[ROBUST],
    )
    figure = draw_runs(BASELINE.time, runs, truth, list(LABELS))
    return Reproduction(figure, (*found[0], *found[1], last))


def _findings(symbol: str, known: np.ndarray) -> tuple[ReproducedQuantity, ReproducedQuantity]:
    name = "stiffness" if symbol == "k" else "damping"
    values = {each: getattr(estimates, name) for each, estimates in run().items()}
    times = {each: describe_settling(values[each], known) for each in values}
    errors = {each: error(values[each], known) for each in values}
    return (
        ReproducedQuantity(
            f"{symbol} within 5 %",
            "steady within 200 ms",
            f"EKF {times[EKF]}, AFEKF {times[AFEKF]}",
            times[ROBUST],
        ),
        ReproducedQuantity(
            f"error of {symbol} after 1 s",
            "near the contact model's 440 N/m" if symbol == "k" else "not known",
            f"EKF {errors[EKF]}, AFEKF {errors[AFEKF]}",
            errors[ROBUST],
        ),
    )


def fig8() -> Reproduction:
    """Draw the predicted force beside the measured one."""
    force, time = BASELINE.samples().force, BASELINE.time
    figure, axes = panels(["force [N]", "predicted - measured [N]"], "time [s]")
    whole, difference = axes.values()
    whole.plot(time, force, color="0.7", linewidth=4.0, label="measured")
    for each, estimates in run().items():
        draw_line(whole, time, estimates.predicted_force, each)
        draw_line(difference, time, -estimates.innovation, each)
    whole.set_ylim(-1.4, 1.4)
    # The error of a start from zero runs out of the picture.
    difference.set(ylim=(-0.1, 0.1), xlim=(0.0, 0.5))
    legend(figure)
    late = {each: _rms(estimates.innovation) for each, estimates in run().items()}
    return Reproduction(
        figure,
        (
            ReproducedQuantity(
                f"rms force error after 0.5 s (noise {1e3 * FORCE_NOISE:.0f} mN)",
                "all well, AFEKF noisier",
                f"EKF {late[EKF]}, AFEKF {late[AFEKF]}",
                late[ROBUST],
            ),
        ),
    )


def _rms(innovation: np.ndarray) -> str:
    return f"{1e3 * np.sqrt(np.mean(innovation[1000:] ** 2)):.2f} mN"
