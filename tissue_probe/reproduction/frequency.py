"""Figures 9, 15 and 16: how the estimates depend on the frequency of the coil.

The tissue has a relaxation branch, so that its stiffness rises and its damping falls with
frequency. A further change in a filter with Euler's step is its error: the same filter with the
exact step is drawn beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from matplotlib.figure import Figure

from tissue_probe.reproduction.drawing import LABELS, draw_line, legend, panels
from tissue_probe.reproduction.experiment import SimulatedTissue, SineExperiment
from tissue_probe.reproduction.filters import (
    EVERY,
    ROBUST,
    UKF,
    UNSURE_OF_TISSUE,
    ShownFilter,
    exact,
    paper_filters,
)
from tissue_probe.reproduction.finding import ReproducedQuantity, Reproduction
from tissue_probe.reproduction.liver import LIVER
from tissue_probe.signals import FloatArray

SINE_FREQUENCIES = (1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0)  # Hz
AVERAGED = 200  # samples of the moving average, section V-A
FAILED = (0.2, 0.5)  # of the true stiffness, of the true damping
# Not stated; fits the axes of figure 9.
SILICONE = SimulatedTissue(330.0, 2.0, relaxing_stiffness=400.0, relaxation_rate=60.0)
WIDE_UKF, WIDE_EKF, WIDE_AFEKF = paper_filters(UNSURE_OF_TISSUE)
#: Where in a period of the coil, which has moved for half a second, measuring begins.
PERIOD_STARTS = tuple((i + 0.25) / 12.0 for i in range(12))


def join_experiment(tissue: SimulatedTissue, frequency: float, start: float) -> SineExperiment:
    """Return an experiment that begins at a part of a period of the moving coil."""
    lead = (np.ceil(0.5 * frequency) + start) / frequency
    return SineExperiment(((0.0, tissue),), frequency=frequency, lead=lead, seed=round(100 * start))


@cache
def sweep(tissue: SimulatedTissue, of: ShownFilter) -> FloatArray:
    """Return k, beta and trace after one second, shape (3, starts, frequencies)."""
    found = [
        [_after_one_second(of, join_experiment(tissue, f, s)) for f in SINE_FREQUENCIES]
        for s in PERIOD_STARTS
    ]
    return np.moveaxis(np.array(found), 2, 0)


def _after_one_second(of: ShownFilter, experiment: SineExperiment) -> list[float]:
    last = of.run(experiment)[-AVERAGED:]
    return [float(np.mean(getattr(last, name))) for name in LABELS]


def fig9() -> Reproduction:
    """Draw the sweep over silicone rubber."""
    reference = exact(UKF)
    figure = _draw(SILICONE, (*EVERY, reference))
    return Reproduction(figure, (_rise(SILICONE, UKF, reference, "rises, level from 25 Hz"),))


def fig15() -> Reproduction:
    """Draw the sweep over liver, with a prior sure that the tip rests and unsure of the tissue."""
    filters = (WIDE_UKF, WIDE_EKF, WIDE_AFEKF)
    reference = exact(WIDE_EKF)
    figure = _draw(LIVER, (*filters, ROBUST, reference))
    told = ", ".join(f"{each.estimator.upper()} {_failures(LIVER, each)}" for each in filters)
    told += f"; EKF with the exact step {_failures(LIVER, reference)}"
    failures = ReproducedQuantity(
        f"k wrong by 20 % or β by 50 %, of {len(PERIOD_STARTS) * len(SINE_FREQUENCIES)} runs",
        "above 15 Hz EKF and AFEKF, not UKF",
        told,
        _failures(LIVER, ROBUST),
    )
    return Reproduction(figure, (_rise(LIVER, WIDE_UKF, exact(WIDE_UKF), "rises"), failures))


def _draw(tissue: SimulatedTissue, filters: Sequence[ShownFilter]) -> Figure:
    """Draw the medians over the starts, and every single run as a dot."""
    figure, axes = panels(list(LABELS), "frequency [Hz]")
    fine = np.linspace(SINE_FREQUENCIES[0], SINE_FREQUENCIES[-1], 200)
    truth = np.array([tissue.at(frequency) for frequency in fine]).T
    for panel, known in zip(axes.values(), truth, strict=False):
        panel.plot(fine, known, color="0.8", linewidth=6.0, label="true")
        panel.set_ylim(-0.3 * known.max(), 1.8 * known.max())
    for each in filters:
        for panel, values in zip(axes.values(), sweep(tissue, each), strict=True):
            draw_line(panel, np.array(SINE_FREQUENCIES), np.median(values, axis=0), each)
            panel.plot(SINE_FREQUENCIES, values.T, ".", color=each.color, markersize=4)
    axes["covariance_trace"].set_yscale("log")
    legend(figure)
    return figure


def _rise(
    tissue: SimulatedTissue, euler: ShownFilter, reference: ShownFilter, stated: str
) -> ReproducedQuantity:
    """Say by how much k rises from 1 to 30 Hz, and which part of it is Euler's."""
    true = tissue.at(SINE_FREQUENCIES[-1])[0] - tissue.at(SINE_FREQUENCIES[0])[0]
    rise = {
        each: np.diff(np.median(sweep(tissue, each)[0], axis=0)[[0, -1]]).item()
        for each in (euler, reference, ROBUST)
    }
    return ReproducedQuantity(
        f"rise of k, 1 to 30 Hz (true {true:.0f} N/m)",
        stated,
        f"{euler.estimator.upper()} {rise[euler]:.0f} N/m; exact step {rise[reference]:.0f} N/m: "
        f"{rise[euler] - rise[reference]:.0f} N/m are Euler's",
        f"{rise[ROBUST]:.0f} N/m",
    )


def _failures(tissue: SimulatedTissue, of: ShownFilter) -> str:
    """Say how many runs miss k by 20 % or beta by 50 %, and the lowest frequency of these."""
    known = np.transpose([tissue.at(frequency) for frequency in SINE_FREQUENCIES])
    errors = np.abs(sweep(tissue, of)[:2] / known[:, None, :] - 1.0)
    right = (errors[0] < FAILED[0]) & (errors[1] < FAILED[1])
    if right.all():
        return "0"
    return f"{np.sum(~right)} from {SINE_FREQUENCIES[np.argmin(right.all(axis=0))]:.0f} Hz"


def fig16() -> Reproduction:
    """Draw the force at 30 Hz, of the start from which the paper's EKF goes farthest astray."""
    stiffness = sweep(LIVER, WIDE_EKF)[0, :, -1]
    worst = PERIOD_STARTS[np.argmax(np.abs(stiffness - LIVER.at(SINE_FREQUENCIES[-1])[0]))]
    experiment = join_experiment(LIVER, SINE_FREQUENCIES[-1], worst)
    force, time = experiment.samples().force, experiment.time
    figure, axes = panels(["force [N]"], "time [s]")
    shown, panel = time >= time[-1] - 0.04, axes["force [N]"]
    panel.plot(time[shown], force[shown], color="0.7", linewidth=4.0, label="measured")
    told = {}
    for each in (WIDE_UKF, WIDE_EKF, WIDE_AFEKF, ROBUST):
        predicted = each.run(experiment).predicted_force
        draw_line(panel, time[shown], predicted[shown], each)
        share = np.std((predicted - force)[shown]) / np.std(force[shown])
        told[each] = f"{100.0 * share:.1f} %"
    legend(figure)
    ours = told.pop(ROBUST)
    theirs = ", ".join(f"{each.estimator.upper()} {share}" for each, share in told.items())
    stated = "UKF close; EKF, AFEKF too large and late"
    return Reproduction(
        figure, (ReproducedQuantity("rms force error at 30 Hz", stated, theirs, ours),)
    )
