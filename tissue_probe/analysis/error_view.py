"""A model's error beside all that it is looked at over: time, frequency, depth, speed, phase.

Contents: the samples of one stretch, and which of them a look at one axis means.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from tissue_probe import arguments as take
from tissue_probe.analysis import fit_shown
from tissue_probe.diagnosis.transforms import analytic, welch, without_line
from tissue_probe.likeness import Alike
from tissue_probe.quantities import Quantity
from tissue_probe.signals import BoolArray, FloatArray

if TYPE_CHECKING:
    from tissue_probe.diagnosis.fitting.fit import Fit
    from tissue_probe.diagnosis.residuals.localise import Localisation

#: Longest segment of a spectrum [s]; at least so many segments lie in a record.
RESOLUTION, SEGMENTS = 1.0, 8
#: Of a band of frequencies those samples are meant that hold this share of its energy: more would
#: be the whole record wherever the band is everywhere, fewer only its highest peak.
ENERGY_SHARE = 0.5
#: The quantities that samples are placed by.
PLACING_AXES = ("time", "indentation", "speed", "phase")


def place(name: str, given: Any) -> float:
    """Take a place on an axis, which may be infinitely far."""
    if isinstance(given, float) and math.isinf(given):
        return given
    return float(take.number()(name, given))


def _is_mask(given: object, shape: tuple[int, ...]) -> bool:
    """Whether it says yes or no of each sample."""
    return isinstance(given, np.ndarray) and given.dtype == bool and given.shape == shape


@dataclass(frozen=True, eq=False)
class ErrorView(Alike):
    """The samples of one stretch, each array of shape (n,).

    Attributes
    ----------
    output : Quantity
        The predicted channel, force or position.
    sample_period, noise : float
        Time between two samples [s]; standard deviation of the output's white noise.
    measured, predicted, residual : array
        Output, the model's, and their difference [unit of the output].
    indentation, speed : array
        Displacement [m] and speed [m/s] of the tip, as far as the model says; inwards positive.
    position : array
        Displacement of the moved part [m], as measured.
    used : array of bool
        Which samples were fitted.
    where : Localisation
        Where the model fails.
    """

    output: Quantity
    sample_period: float
    noise: float
    measured: FloatArray
    predicted: FloatArray
    residual: FloatArray
    indentation: FloatArray
    speed: FloatArray
    position: FloatArray
    used: BoolArray
    where: Localisation

    @property
    def time(self) -> FloatArray:
        """Time of each sample after the first [s]."""
        return np.asarray(np.arange(self.measured.size) * self.sample_period, dtype=np.float64)

    @cached_property
    def phase(self) -> FloatArray:
        """Phase of the motion's cycle [degrees]: 0 where deepest, -90 on the way in."""
        angle = np.angle(analytic(without_line(self.position)))
        return np.asarray(np.rad2deg(angle), dtype=np.float64)

    @take.checks(axis=take.choice(*PLACING_AXES))
    def along(self, axis: str) -> FloatArray:
        """Return the samples' places on an axis: ``time``, ``indentation``, ``speed``, ``phase``.

        Raises
        ------
        ParameterError
            If there is no such axis.
        """
        return np.asarray(getattr(self, axis), dtype=np.float64)

    @take.checks()
    def spectrum(self, samples: BoolArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Return frequencies [Hz] and the density of the residual's power, of some samples only."""
        if samples is not None and not _is_mask(samples, self.residual.shape):
            take.refuse("samples", samples, f"an array of {self.residual.size} truths")
        part = self.residual if samples is None else self.residual * samples
        counted = 1.0 if samples is None else max(float(samples.mean()), 1.0 / samples.size)
        segment = min(round(RESOLUTION / self.sample_period), part.size // SEGMENTS)
        frequencies, density = welch(part, self.sample_period, max(segment, 8))
        return frequencies[1:], density[1:] / counted

    @take.checks(axis=take.choice("frequency", *PLACING_AXES), low=place, high=place)
    def between(self, axis: str, low: float, high: float) -> BoolArray:
        """Return which samples lie between two places on an axis.

        Of ``frequency`` [Hz] those are meant in which the residual's part in that band is largest:
        they hold half of its energy. Of ``phase``, ``low`` may lie above ``high``: the interval
        then goes on through +-180 degrees.
        """
        if axis == "frequency":
            return self._with_most_of(low, high)
        places = self.along(axis)
        if axis == "phase" and low > high:
            return np.asarray((places >= low) | (places <= high))
        return np.asarray((places >= low) & (places <= high))

    def _with_most_of(self, low: float, high: float) -> BoolArray:
        transformed = np.fft.rfft(self.residual)
        frequencies = np.fft.rfftfreq(self.residual.size, self.sample_period)
        transformed[(frequencies < low) | (frequencies > high)] = 0.0
        power = np.abs(analytic(np.fft.irfft(transformed, self.residual.size))) ** 2
        order = np.argsort(power)[::-1]
        within = np.cumsum(power[order]) <= ENERGY_SHARE * power.sum()
        chosen = np.zeros(power.size, dtype=bool)
        chosen[order[within]] = True
        return chosen


def error_view(fit: Fit, index: int) -> ErrorView:
    """Return the view of one of a fit's measurements."""
    shown, tip = fit.measurements[index], fit.tip[index]
    return ErrorView(
        fit.output,
        shown.sample_period,
        shown.noise.own,
        shown.output_values,
        fit.predicted[index],
        fit.residuals[index],
        tip,
        np.gradient(tip, shown.sample_period),
        shown.position,
        np.array(shown.used, dtype=bool),
        fit_shown.where(fit, index),
    )
