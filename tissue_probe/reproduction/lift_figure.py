"""Figure 11: stiff tissue, no contact, softer tissue."""

from __future__ import annotations

from tissue_probe.reproduction.drawing import LABELS, draw_runs
from tissue_probe.reproduction.experiment import NO_CONTACT, SimulatedTissue, SineExperiment
from tissue_probe.reproduction.filters import AFEKF, EKF, EVERY, ROBUST
from tissue_probe.reproduction.finding import ReproducedQuantity, Reproduction, describe_settling

LIFTED, LOWERED = 4.0, 6.0  # s; four seconds on either tissue, section V-D
# The values are not stated; these fit the axes of the figure.
LIFTED_PROBE = SineExperiment(
    (
        (0.0, SimulatedTissue(1600.0, 30.0)),
        (LIFTED, NO_CONTACT),
        (LOWERED, SimulatedTissue(500.0, 8.0)),
    ),
    duration=10.0,
)


def fig11() -> Reproduction:
    """Draw stiffness, damping and covariance trace through both changes."""
    runs, truth = {each: each.run(LIFTED_PROBE) for each in EVERY}, LIFTED_PROBE.truth()
    samples = round(LOWERED / LIFTED_PROBE.time[1])
    findings = []
    for symbol, name, known in zip(("k", "β"), ("stiffness", "damping"), truth, strict=True):
        values = {each: getattr(estimates, name) for each, estimates in runs.items()}
        for what, begin, end in (("lifted", LIFTED, samples), ("on softer tissue", LOWERED, None)):
            time = {
                each: describe_settling(v[:end], known[:end], begin) for each, v in values.items()
            }
            findings.append(
                ReproducedQuantity(
                    f"{symbol} within 5 %, {what}",
                    "AFEKF very quickly, EKF and UKF very slowly",
                    f"AFEKF {time[AFEKF]}, EKF {time[EKF]}",
                    time[ROBUST],
                )
            )
    figure = draw_runs(LIFTED_PROBE.time, runs, truth, list(LABELS))
    return Reproduction(figure, tuple(findings))
