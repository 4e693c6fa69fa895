"""The estimators there are. A new one is a file beside this one and a line here."""

from pathlib import Path

from tissue_probe.estimation import afekf, afukf, ekf, robust_ekf, ukf
from tissue_probe.estimation.kernel import ByHand, KalmanFilter

HERE = Path(__file__).parent

ESTIMATORS: dict[str, KalmanFilter | ByHand] = {
    "robust_ekf": KalmanFilter(robust_ekf, force_offset=True),
    "ekf": KalmanFilter(ekf),
    "ukf": KalmanFilter(ukf),
    "afekf": KalmanFilter(afekf),
    "afukf": KalmanFilter(afukf),
    "lock_in": ByHand(HERE / "lock_in.py"),
    "rls": ByHand(HERE / "rls.py"),
}
