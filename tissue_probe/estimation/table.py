"""The estimators there are. A new one is a file beside this one and a line here."""

from tissue_probe.estimation import afekf, ekf, robust_ekf, ukf
from tissue_probe.estimation.kernel import KalmanFilter

ESTIMATORS = {
    "robust_ekf": KalmanFilter(robust_ekf, force_offset=True),
    "ekf": KalmanFilter(ekf),
    "ukf": KalmanFilter(ukf),
    "afekf": KalmanFilter(afekf),
}
