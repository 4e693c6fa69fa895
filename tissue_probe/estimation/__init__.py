"""Stiffness and damping of the tissue from the samples of a probe.

estimator = Estimator("ekf", EstimatorSettings())
estimates = estimator.process(block)
"""

from tissue_probe.estimation.estimator import Estimator
from tissue_probe.estimation.settings import EstimatorSettings
from tissue_probe.estimation.table import ESTIMATORS

__all__ = ["ESTIMATORS", "Estimator", "EstimatorSettings"]
