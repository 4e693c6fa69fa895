"""The filters that are compared: the paper's three as it had them, and the recommended one."""

from __future__ import annotations

from dataclasses import dataclass

from tissue_probe.estimation import Estimator, EstimatorSettings
from tissue_probe.reproduction.experiment import SineExperiment
from tissue_probe.signals import TissueEstimates

# Forward Euler (eqs. 6 and 7), P0 = I (the trace of figure 7c begins at 4), w_t of section V-A. The
# paper holds neither estimates nor their variances within bounds.
PAPER = EstimatorSettings(
    discretisation="euler",
    velocity_noise=1e-8,
    stiffness_prior_sd=1.0,
    damping_prior_sd=1.0,
    tip_position_prior_sd=1.0,
    tip_velocity_prior_sd=1.0,
    deviation_ceiling=1e6,
    stiffness_minimum=-1e6,
    stiffness_maximum=1e6,
    damping_minimum=-1e4,
    damping_maximum=1e4,
)
# Unsure of the tissue, and sure that the tip rests. The paper does not tell its prior; where
# measuring begins in the midst of a motion, filters with this one fail at high frequencies only, as
# the paper's do.
UNSURE_OF_TISSUE = PAPER.model_copy(
    update={
        "stiffness_prior_sd": 1e4,
        "damping_prior_sd": 20.0,
        "tip_position_prior_sd": 1e-5,
        "tip_velocity_prior_sd": 2e-3,
    }
)


@dataclass(frozen=True)
class ShownFilter:
    """An estimator under the name it has in figures, with its colour and dashes there."""

    label: str
    estimator: str
    settings: EstimatorSettings
    color: str
    dashes: str | tuple[int, tuple[float, ...]]

    def run(self, experiment: SineExperiment) -> TissueEstimates:
        """Estimate the tissue of an experiment after every sample."""
        return Estimator(self.estimator, self.settings).process(experiment.samples())


def paper_filters(settings: EstimatorSettings) -> tuple[ShownFilter, ShownFilter, ShownFilter]:
    """Return UKF, EKF and AFEKF of the paper, with one prior."""
    return (
        ShownFilter("paper's UKF", "ukf", settings, "#0072B2", "-"),
        ShownFilter("paper's EKF", "ekf", settings, "#E69F00", (0, (5, 2))),
        ShownFilter("paper's AFEKF", "afekf", settings, "#CC79A7", (0, (2, 1.5))),
    )


UKF, EKF, AFEKF = paper_filters(PAPER)
ROBUST = ShownFilter("robust_ekf", "robust_ekf", EstimatorSettings(), "#009E73", "-")
EVERY = (UKF, EKF, AFEKF, ROBUST)


def exact(of: ShownFilter) -> ShownFilter:
    """Return a filter of the paper with the exact step in place of Euler's, all else equal."""
    settings = of.settings.model_copy(update={"discretisation": "exact"})
    label = f"{of.estimator.upper()}, exact step"
    return ShownFilter(label, of.estimator, settings, "black", ":")
