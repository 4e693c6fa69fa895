"""What a user has today: sparse regression of the force balance (SINDy; Brunton et al., 2016).

Contents: one column or more for each effect, linear in its amplitude, at typical values of whatever
else it has; STLSQ of PySINDy; a ranking.

With the nominal rig the tip is at x = u - F / k0, and F + beta0 (u' - x') - m x'' is the force of
the tissue; what k x + beta x' leaves of it is regressed. ``force_gain`` and
``encoder_quantization`` have no column: the first would be the target itself, the second is no
function of the state.
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray
from pysindy import STLSQ
from scipy.fft import next_fast_len
from scipy.interpolate import make_interp_spline
from scipy.signal import butter, filtfilt, lfilter
from threadpoolctl import threadpool_limits

from tissue_probe.challenge.grading import GradedDiagnosis
from tissue_probe.challenge.simulator import SimulatedRecord
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.signals import FloatArray

CUTOFF = 100.0
"""Of the low-pass that position and force go through, forth and back, before derivatives are taken
[Hz]: once for both, so that the linear terms still balance."""

SPACING, MARGIN = 8, 24
"""Every eighth sample is regressed, since neighbours share their noise; and none at the ends."""

THRESHOLDS = np.geomspace(1e-4, 1.0, 25)
"""Of STLSQ, in newtons of rms that a column contributes."""

PENALTY = 5.0

NOMINAL = Specimen(stiffness=0.0, damping=0.0)

BoolArray = NDArray[np.bool_]
Columns = dict[str, list[FloatArray]]


@threadpool_limits.wrap(limits=1)  # many small systems: threads would only wait for each other
def diagnose(measured: SimulatedRecord) -> GradedDiagnosis:
    """Rank effects by how much worse the force balances without their columns."""
    base, target, library = _force_balance(measured)
    names = [name for name, columns in library.items() for _ in columns]
    columns = np.column_stack([column for group in library.values() for column in group])
    projected = _without(base, np.column_stack([target, columns]))
    target, columns = projected[:, 0], projected[:, 1:]
    scale = np.sqrt(np.mean(columns**2, axis=0))
    shown = scale > 1e-9 * np.abs(columns).max()
    names = [name for name, kept in zip(names, shown, strict=True) if kept]
    columns = columns[:, shown] / scale[shown]
    support = _support(columns, target)
    chosen, columns = np.array(names)[support], columns[:, support]
    missed = {
        name: _left(columns[:, chosen != name], target) for name in dict.fromkeys(chosen.tolist())
    }
    ranking = tuple(sorted(missed, key=lambda name: -missed[name]))
    return GradedDiagnosis("missing" if ranking else "adequate", ranking, frozenset(), ranking)


def _support(columns: FloatArray, target: FloatArray) -> BoolArray:
    """Return which columns STLSQ keeps at the threshold that the criterion prefers."""
    support = np.zeros(columns.shape[1], dtype=bool)
    lowest = _criterion(columns[:, support], target)
    for threshold in THRESHOLDS:
        optimizer = STLSQ(threshold=threshold, alpha=1e-6, max_iter=50)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that nothing is left is no surprise
            kept = np.asarray(optimizer.fit(columns, target[:, None]).coef_)[0] != 0.0
        if not kept.any():
            break
        criterion = _criterion(columns[:, kept], target)
        if criterion < lowest:
            support, lowest = kept, criterion
    return support


def _criterion(columns: FloatArray, target: FloatArray) -> float:
    """Return a BIC; the penalty is fivefold, since the noise is not white."""
    size = target.size
    return size * np.log(_left(columns, target)) + PENALTY * columns.shape[1] * np.log(size)


def _left(columns: FloatArray, target: FloatArray) -> float:
    """Return the mean square that columns leave [N^2]."""
    return float(np.mean(_without(columns, target) ** 2))


def _without(base: FloatArray, columns: FloatArray) -> FloatArray:
    """Return what the base leaves of other columns."""
    return columns - base @ np.linalg.lstsq(base, columns)[0]


def _force_balance(measured: SimulatedRecord) -> tuple[FloatArray, FloatArray, Columns]:
    """Return [x, x'], the tissue's force, and each effect's columns, at every eighth sample."""
    period, low_pass = measured.sample_period, butter(4, 2.0 * CUTOFF * measured.sample_period)
    position, force = (filtfilt(*low_pass, each) for each in (measured.position, measured.force))
    u, du = (_derivative(position, order, period) for order in (0, 1))
    F, dF, ddF = (_derivative(force, order, period) for order in (0, 1, 2))
    tip = position - force / NOMINAL.load_cell_stiffness
    x, v, a = (_derivative(tip, order, period) for order in (0, 1, 2))
    target = F + NOMINAL.load_cell_damping * (du - v) - NOMINAL.tip_mass * a
    t = measured.time
    in_air = x < 0.0
    relaxed = {tau: _low_pass(v, tau, period) for tau in (0.015, 0.05, 0.3)}
    library: Columns = {
        "standard_linear_solid": [relaxed[0.05]],
        "generalized_maxwell": [relaxed[0.015], relaxed[0.3]],
        "springpot": [_fractional(x, 0.35, period)],
        "cubic_stiffening": [x**3],
        "exponential_stiffening": [np.expm1(x / 1e-3)],
        "hertz_contact": [np.maximum(x, 0.0) ** 1.5],
        "saturating_spring": [x * np.abs(x) / (1e-3 + np.abs(x))],
        "hunt_crossley": [np.maximum(x, 0.0) * v],
        "contact_loss": [x * in_air, v * in_air],
        "adhesion": [x * (in_air & (v < 0.0)), v * (in_air & (v < 0.0))],
        "coulomb_friction": [np.tanh(v / 1e-3)],
        "stribeck_friction": [np.tanh(v / 1e-3) * np.exp(-((v / 5e-3) ** 2))],
        "bouc_wen_hysteresis": [_hysteresis(x, 1e-4)],
        "backlash": [np.sign(F)],
        "added_mass": [a],
        "structural_mode": [_resonance(a, frequency, period) for frequency in (20.0, 40.0)],
        "load_cell_stiffness_error": [ddF],
        "force_bias": [np.ones_like(x)],
        "force_drift": [t],
        "tissue_motion": _waves(t, 0.3) + _waves(t, 1.3),
        "mains_hum": _waves(t, 50.0) + _waves(t, 60.0),
        "force_lag": [dF],
        "channel_delay": [dF - 5e-4 * ddF],
        "encoder_interpolation": _waves(u, 1.0 / 20e-6),
        "stiffness_step": [x * (t > share * t[-1]) for share in (0.25, 0.4, 0.5, 0.6, 0.75)],
        "stiffness_ramp": [x * t],
    }
    kept = slice(MARGIN, -MARGIN, SPACING)
    library = {name: [column[kept] for column in columns] for name, columns in library.items()}
    return np.column_stack([x, v])[kept], target[kept], library


def _derivative(signal: FloatArray, order: int, period: float) -> FloatArray:
    """Return a derivative of the quintic spline through the samples."""
    times = np.arange(signal.size) * period
    return make_interp_spline(times, signal, k=5)(times, order)


def _low_pass(signal: FloatArray, tau: float, period: float) -> FloatArray:
    decay = np.exp(-period / tau)
    return lfilter([1.0 - decay], [1.0, -decay], signal)


def _resonance(drive: FloatArray, frequency: float, period: float) -> FloatArray:
    """Return the response of a mass on a spring, damping ratio 0.1, by the bilinear transform."""
    w, s = 2.0 * np.pi * frequency, 2.0 / period
    c = 0.2 * w * s
    denominator = [s**2 + c + w**2, 2.0 * (w**2 - s**2), s**2 - c + w**2]
    return lfilter(w**2 * np.array([1.0, 2.0, 1.0]), denominator, drive)


def _fractional(signal: FloatArray, order: float, period: float) -> FloatArray:
    """Return the derivative of fractional order, from rest at the first sample."""
    size = next_fast_len(2 * signal.size, real=True)
    s = 2j * np.pi * np.fft.rfftfreq(size, period)
    response = np.zeros_like(s)
    response[1:] = s[1:] ** order
    return np.fft.irfft(response * np.fft.rfft(signal - signal[0], size), size)[: signal.size]


def _hysteresis(x: FloatArray, width: float) -> FloatArray:
    """Return Bouc and Wen's z, between -1 and 1."""
    z = np.zeros_like(x)
    for n, step in enumerate(np.diff(x) / width):
        z[n + 1] = z[n] + step - 0.5 * (abs(step) * z[n] + step * abs(z[n]))
    return z


def _waves(over: FloatArray, frequency: float) -> list[FloatArray]:
    phase = 2.0 * np.pi * frequency * over
    return [np.sin(phase), np.cos(phase)]
