"""How the force answers to the position, to a first look: stiffness, damping, mass and lag.

Contents: a regression good enough to see a wrong sign, unit or clock.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.diagnosis.transforms import correlation, smooth_values, without_line
from tissue_probe.signals import FloatArray

_WINDOW, _DEGREE = 9, 4  # of the smoothing polynomial
_TINY = 1e-12  # of a signal that spans 1: a straight line has no more left
_FORGETTING_RATES = 6  # two a decade and more, from the record's length down
_COLLINEAR = 0.97  # a sine's acceleration is its position turned round


@dataclass(frozen=True)
class CoarseResponse:
    """The regression F(t + lag) = c + d t + k u + b u' + m u'', the channels smoothed alike.

    Attributes
    ----------
    stiffness, damping, mass : float
        k [N/m], b [N s/m], m [kg]; where the motion is too near a sine of one frequency to tell
        mass from stiffness, the mass is 0 and k = k - m w^2.
    elastic, viscous, inertial : float
        Share of each term in the force: its rms over that of the force, signed as k, b, m.
    separable : bool
        Whether mass and stiffness were told apart.
    frequency : float
        w / 2 pi: root of mean u''^2 over mean u^2 [Hz].
    unexplained : float
        Residual over the force, rms.
    """

    stiffness: float
    damping: float
    mass: float
    elastic: float
    viscous: float
    inertial: float
    separable: bool
    frequency: float
    unexplained: float


@dataclass(frozen=True)
class Regressors:
    """Position, velocity and acceleration, smoothed, the trend taken out; shape (3, n).

    ``force`` is smoothed in the same way, shape (n,).
    """

    columns: FloatArray
    force: FloatArray
    sample_period: float


def regressors(position: FloatArray, force: FloatArray, sample_period: float) -> Regressors:
    """Prepare the regression from position and force, each scaled to a span of 1.

    Derivatives are those of a polynomial of degree 4 through 9 samples (Savitzky and Golay).
    """
    columns = [
        smooth_values(position, _WINDOW, _DEGREE, order, sample_period) for order in range(3)
    ]
    return Regressors(
        np.array([without_line(column) for column in columns]),
        without_line(smooth_values(force, _WINDOW, _DEGREE)),
        sample_period,
    )


def coarse_response(of: Regressors, lag: int = 0) -> CoarseResponse:
    """Regress the force, ``lag`` samples later, on the position and its derivatives."""
    count = of.force.size
    columns = of.columns[:, max(0, -lag) : count - max(0, lag)]
    force = of.force[max(0, lag) : count - max(0, -lag)]
    scales = _rms(columns) + _TINY
    likeness = columns[0] @ columns[2] / (scales[0] * scales[2] * force.size)
    separable = bool(likeness**2 < _COLLINEAR)
    used = 3 if separable else 2
    values = np.zeros(3)
    values[:used] = np.linalg.lstsq((columns / scales[:, None])[:used].T, force, rcond=None)[0]
    rest = force - (values / scales) @ columns
    force_rms = _rms(force) + _TINY
    shares = values / force_rms
    stiffness, damping, mass = (float(value) for value in values / scales)
    elastic, viscous, inertial = map(float, shares)
    return CoarseResponse(
        stiffness,
        damping,
        mass,
        elastic,
        viscous,
        inertial,
        separable,
        float(np.sqrt(scales[2] / scales[0]) / (2.0 * np.pi)),
        float(_rms(rest) / force_rms),
    )


def measure_active_share(position: FloatArray, force: FloatArray, sample_period: float) -> float:
    """Return the share of a force (rms) that nothing passive explains.

    Passive is k u + b u' + m u'' and branches of Maxwell, k_i q_i with q_i' = u' - r_i q_i, none of
    these values below zero (M. Biot, J. Appl. Phys. 25 (1954), 1385); beside them a line.

    Parameters
    ----------
    position, force : array, shape (n,)
        Each of any scale.
    sample_period : float
        Time between two samples [s].
    """
    from scipy.optimize import nnls  # takes long to import, and is asked of doubtful records only

    derivatives = [smooth_values(position, _WINDOW, _DEGREE, k, sample_period) for k in range(3)]
    forgetting = np.exp(
        -np.geomspace(1.0, position.size / _FORGETTING_RATES, _FORGETTING_RATES) / position.size
    )
    moves = np.diff(derivatives[0], prepend=derivatives[0][0])
    ages = np.arange(position.size)
    branches = [correlation(moves, (a**ages)[::-1])[: position.size] for a in forgetting]
    line = np.stack([np.ones(position.size), np.linspace(-1.0, 1.0, position.size)])
    columns = np.array([*derivatives, *branches, *line, *-line])
    columns /= _rms(columns)[:, None] + _TINY
    smooth = smooth_values(force, _WINDOW, _DEGREE)
    left = nnls(columns.T, smooth)[1] / np.sqrt(force.size)
    return float(left / (_rms(without_line(smooth)) + _TINY))


def best_lag(of: Regressors, longest: int) -> int:
    """Return by how many samples the force is late, at most ``longest``, negative if early.

    Found where the regression explains most of the force; the sums of products over all lags come
    from one correlation a column.
    """
    force, columns = of.force, of.columns / (_rms(of.columns)[:, None] + _TINY)
    products = np.array([correlation(force, column) for column in columns])
    zero = force.size - 1
    products = products[:, zero - longest : zero + longest + 1]
    gram = columns @ columns.T + 1e-9 * force.size * np.eye(3)
    explained = np.sum(products * np.linalg.solve(gram, products), axis=0)
    return int(np.argmax(explained)) - longest


def _rms(values: FloatArray) -> FloatArray:
    found: FloatArray = np.sqrt(np.mean(values**2, axis=-1))
    return found
