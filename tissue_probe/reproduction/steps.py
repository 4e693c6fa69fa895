"""Figures 3 and 4: stiffness and damping double at once, in simulation."""

from __future__ import annotations

from functools import cache

from tissue_probe.reproduction.drawing import Runs, draw_runs
from tissue_probe.reproduction.experiment import SimulatedTissue, SineExperiment
from tissue_probe.reproduction.filters import AFEKF, EKF, EVERY, ROBUST
from tissue_probe.reproduction.finding import ReproducedQuantity, Reproduction, describe_settling

DOUBLED = 2.0  # s, section III-D
# The values are not stated; these fit the axes of the figures.
STEPPED = SineExperiment(
    ((0.0, SimulatedTissue(500.0, 10.0)), (DOUBLED, SimulatedTissue(1000.0, 20.0))), duration=4.0
)


@cache
def run() -> Runs:
    """Run every filter on the experiment."""
    return {each: each.run(STEPPED) for each in EVERY}


def fig3() -> Reproduction:
    """Draw the estimated stiffness."""
    return _reproduce("stiffness", "k")


def fig4() -> Reproduction:
    """Draw the estimated damping."""
    return _reproduce("damping", "β")


def _reproduce(name: str, symbol: str) -> Reproduction:
    runs, truth = run(), STEPPED.truth()
    known = truth[0 if name == "stiffness" else 1]
    values = {each: getattr(estimates, name) for each, estimates in runs.items()}
    before = slice(round(DOUBLED / STEPPED.time[1]))
    started = {each: describe_settling(values[each][before], known[before]) for each in runs}
    changed = {each: describe_settling(values[each], known, DOUBLED) for each in runs}
    return Reproduction(
        draw_runs(STEPPED.time, runs, truth, [name]),
        (
            ReproducedQuantity(
                f"{symbol} within 5 % from the start",
                "< 200 ms",
                f"EKF {started[EKF]}, AFEKF {started[AFEKF]}",
                started[ROBUST],
            ),
            ReproducedQuantity(
                f"{symbol} within 5 % after doubling",
                "AFEKF quickly, EKF and UKF much slower",
                f"AFEKF {changed[AFEKF]}, EKF {changed[EKF]}",
                changed[ROBUST],
            ),
        ),
    )
