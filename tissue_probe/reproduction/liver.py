"""Figure 14: five places of one liver, whose tissue relaxes."""

from __future__ import annotations

import numpy as np

from tissue_probe.reproduction.drawing import LABELS, band, legend, panels
from tissue_probe.reproduction.experiment import SimulatedTissue, SineExperiment
from tissue_probe.reproduction.filters import AFEKF, EVERY, ROBUST, UKF
from tissue_probe.reproduction.finding import ReproducedQuantity, Reproduction, describe_settling

# Not stated; near the axes of figures 14 and 15. Each place is as much stiffer or softer.
LIVER = SimulatedTissue(2000.0, 1.0, relaxing_stiffness=1700.0, relaxation_rate=190.0)
LIVER_PLACES = (0.9, 0.95, 1.0, 1.05, 1.1)


def place(share: float, seed: int) -> SineExperiment:
    """Return the experiment at a place that is ``share`` times as stiff and damped."""
    stiffness, damping = share * LIVER.stiffness, share * LIVER.damping
    branch = share * LIVER.relaxing_stiffness
    tissue = SimulatedTissue(stiffness, damping, branch, LIVER.relaxation_rate)
    return SineExperiment(((0.0, tissue),), duration=1.5, seed=seed)


def fig14() -> Reproduction:
    """Draw median and range over the places."""
    experiments = [place(share, seed) for seed, share in enumerate(LIVER_PLACES)]
    figure, axes = panels(list(LABELS), "time [s]")
    spreads, times = {}, {}
    for each in EVERY:
        runs = [each.run(experiment) for experiment in experiments]
        for name, panel in axes.items():
            values = np.array([getattr(run, name) for run in runs])
            band(panel, experiments[0].time, values, each)
        last = np.array([run.stiffness[-1] for run in runs])
        spreads[each] = f"{last.mean():.0f} ± {last.std():.0f} N/m"
        middle = len(LIVER_PLACES) // 2
        times[each] = describe_settling(runs[middle].stiffness, experiments[middle].truth()[0])
    stiffness, damping = np.mean([experiment.truth() for experiment in experiments], axis=(0, 2))
    axes["stiffness"].set_ylim(-0.25 * stiffness, 1.8 * stiffness)
    axes["damping"].set_ylim(-0.25 * damping, 1.8 * damping)
    axes["covariance_trace"].set_yscale("log")
    legend(figure)
    true = np.array([experiment.truth()[0][-1] for experiment in experiments])
    return Reproduction(
        figure,
        (
            ReproducedQuantity(
                f"k of five places (true {true.mean():.0f} ± {true.std():.0f} N/m)",
                "repeatable after the start",
                f"UKF {spreads[UKF]}, AFEKF {spreads[AFEKF]}",
                spreads[ROBUST],
            ),
            ReproducedQuantity(
                "k within 5 %, the middle place",
                "not stated",
                f"UKF {times[UKF]}, AFEKF {times[AFEKF]}",
                times[ROBUST],
            ),
        ),
    )
