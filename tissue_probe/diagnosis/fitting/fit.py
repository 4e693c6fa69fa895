"""A model fitted to measurements: its values and its residual.

Contents: the numbers that are kept of a fit, and those that follow from them alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.entry import Entry
from tissue_probe.quantities import POSITION, Quantity
from tissue_probe.signals import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Fit:
    """A model fitted to measurements; errors are in the unit of ``output``.

    Attributes
    ----------
    composition : Composition
        The model.
    measurements : tuple of Measurement
        The observations that it was fitted to.
    entries : tuple of Entry
        The declarations of the values: ``composition.values``, then those of further runs
        (``Runs``).
    values : array, shape (q,)
        Constants and parameters, in this order.
    starts : tuple of array
        The states at the first sample of each measurement.
    covariance : array, shape (q, q)
        Of the values' errors; rows of values that were held are 0.
    residuals : tuple of array
        Measured minus simulated output.
    evened : tuple of array
        The same with flicker noise, and the motion that a force's noise makes, whitened: noise
        alone would leave white noise of each measurement's ``noise``.
    misfits : tuple of float
        Sum of squared residuals of each measurement over its noise, flicker noise weighed as such.
    cost : float
        Sum of the misfits, and of squared departures from the priors.
    unknowns : int
        How many parameters were free (the rig's tolerances and the starts not counted).
    start_penalty : float
        The cost of the freedom of the effects' states at the start (Laplace's evidence): the log of
        how many times narrower the data make their prior, of each state up to a parameter's cost.
    heldout : tuple of array
        Residuals of each eighth of the record when the values are fitted to the other seven
        (to first order in the change of the values).
    converged : bool
        Whether the search settled.
    rounding : float
        The residual that an encoder's rounding leaves in the simulated force, rms [N], where the
        model smooths or corrects the position; 0 where it does not.
    colour, unevenness : float
        How slow the residual is, and how far from even over the frequencies (``whiteness``).
    strain : float
        Sum of squared departures from the priors, those of the rig's tolerances and of the starts.
    exhausted : tuple of str
        Values that ended where the search of them ends: constants of the rig `FARTHEST` standard
        deviations off, others at a bound of their entry.
    alone : tuple of str
        Values that one of the held-out parts tells, and all the others hardly: no part tests them.
    """

    composition: Composition
    measurements: tuple[Measurement, ...]
    entries: tuple[Entry, ...]
    values: FloatArray
    starts: tuple[FloatArray, ...]
    covariance: FloatArray
    residuals: tuple[FloatArray, ...]
    evened: tuple[FloatArray, ...]
    heldout: tuple[FloatArray, ...]
    misfits: tuple[float, ...]
    cost: float
    unknowns: int
    start_penalty: float
    converged: bool
    rounding: float
    colour: float
    unevenness: float
    strain: float
    exhausted: tuple[str, ...] = ()
    alone: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the values."""
        return tuple(entry.name for entry in self.entries)

    @property
    def learnt(self) -> int:
        """How many parameters were free and did not end at a bound."""
        return self.unknowns - len(self.exhausted)

    @property
    def samples(self) -> int:
        """How many samples were fitted."""
        return sum(int(np.sum(measurement.used)) for measurement in self.measurements)

    @cached_property
    def left_at(self) -> tuple[float, ...]:
        """Angular frequency at which each residual is largest, as near a resonance [rad/s]."""
        return tuple(
            _loudest(residual) / measurement.sample_period
            for measurement, residual in zip(self.measurements, self.residuals, strict=True)
        )

    @cached_property
    def rmse(self) -> float:
        """Root mean square of the residual."""
        return self._rms(self.residuals)

    @cached_property
    def heldout_rmse(self) -> float:
        """Root mean square of the residual of the held-out samples."""
        return self._rms(self.heldout)

    def error(self, index: int) -> float:
        """Root mean square of the residual of one measurement."""
        counted = self.residuals[index][self.measurements[index].counted]
        return float(np.sqrt(np.mean(counted**2)))

    @property
    def worst(self) -> int:
        """Which measurement holds most of the squared residual over the noise."""
        return int(np.argmax(self.misfits))

    @property
    def output(self) -> Quantity:
        """The channel that the model predicts, and its unit."""
        return self.composition.output

    def _rms(self, parts: Sequence[FloatArray]) -> float:
        counted = [part[m.counted] for part, m in zip(parts, self.measurements, strict=True)]
        return float(np.sqrt(np.mean(np.concatenate(counted) ** 2)))

    @cached_property
    def ratio(self) -> float:
        """Residual over noise, root mean square: 1 where nothing is left to explain."""
        squares = [
            misfit * self._noise_in(measurement)
            for misfit, measurement in zip(self.misfits, self.measurements, strict=True)
        ]
        return float(np.sqrt(sum(squares) / self.samples))

    def _noise_in(self, measurement: Measurement) -> float:
        """Return the share of the white noise in its square with that of rounding."""
        return 1.0 / (1.0 + (self.rounding / measurement.noise.own) ** 2)

    @property
    def floor(self) -> float:
        """Cost that noise alone would leave, an encoder's rounding counted as such."""
        return float(sum(m.used.sum() / self._noise_in(m) for m in self.measurements))

    @property
    def noise(self) -> float:
        """Standard deviation of the output's white noise over all measurements."""
        squares = [m.noise.own**2 * np.sum(m.used) for m in self.measurements]
        return float(np.sqrt(sum(squares) / self.samples))

    @property
    def counted_too(self) -> str:
        """The noise that is counted beside the white noise, in words."""
        kinds = sorted((m.noise for m in self.measurements), key=lambda noise: noise.is_white)
        return kinds[0].counted_too

    @property
    def is_coloured(self) -> bool:
        """Whether noise of the input counts as noise of the output."""
        return not all(m.noise.is_white for m in self.measurements)

    @property
    def excess(self) -> float:
        """Root mean square of the residual beyond the output's white noise."""
        return float(np.sqrt(max(self.rmse**2 - self.noise**2, 0.0)))

    @property
    def bic(self) -> float:
        """Bayesian information criterion, the noise's level being unknown.

        A residual that an encoder's rounding explains does not count against a model that contains
        it; the model pays for it as for noise that is larger by as much. Where less is left, the
        rounding counts as white noise of that size.
        """
        return self.misfit + self.unknowns * float(np.log(self.samples)) + self.start_penalty

    @property
    def misfit(self) -> float:
        """The criterion's term for the residual: minus twice the logarithm of the likelihood."""
        cost = max(self.cost, np.finfo(float).tiny)  # zeros are fitted without a rest
        if self.rounding > 0.0:
            share = (self.rounding / self.noise) ** 2
            left = max(cost - self.samples * share, cost / (1.0 + share))
            cost = left + self.samples * np.log1p(share)
        return float(self.samples * np.log(cost))

    @property
    def predicted(self) -> tuple[FloatArray, ...]:
        """Simulated output of each measurement."""
        return tuple(
            measurement.output_values - residual
            for measurement, residual in zip(self.measurements, self.residuals, strict=True)
        )

    @property
    def tip(self) -> tuple[FloatArray, ...]:
        """Displacement of the tip in each measurement, as far as the model says [m]."""
        if self.output is POSITION:
            return self.predicted
        stiffness = self.named().get("load_cell_stiffness", np.inf)
        return tuple(
            measurement.position - force / stiffness
            for measurement, force in zip(self.measurements, self.predicted, strict=True)
        )

    def without(self, samples: Sequence[BoolArray], most: float) -> list[Measurement] | None:
        """Return the measurements without some of the samples that were fitted.

        None where that leaves out none, or more than a share ``most`` of all.
        """
        pairs = list(zip(self.measurements, samples, strict=True))
        count = sum(int(np.sum(each.used & some)) for each, some in pairs)
        if not 0 < count <= most * self.samples:
            return None
        return [each.without(each.used & some) for each, some in pairs]

    def named(self) -> dict[str, float]:
        """Return values by name."""
        return dict(zip(self.names, map(float, self.values), strict=True))

    def deviations(self) -> dict[str, float]:
        """Return standard deviations of the values by name.

        Where position and force may be apart in time by T, the stiffness k poses as a damping of up
        to k T: that counts as one deviation.
        """
        deviations = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        named = dict(zip(self.names, map(float, deviations), strict=True))
        apart = max(measurement.time_doubt for measurement in self.measurements)
        if apart and named.get("damping"):
            shifted = apart * abs(self.named().get("stiffness", 0.0))
            named["damping"] = float(np.hypot(named["damping"], shifted))
        return named


def _loudest(residual: FloatArray) -> float:
    """Return the angle between two samples at which a residual is largest."""
    power = np.abs(np.fft.rfft(np.hanning(residual.size) * (residual - residual.mean()))) ** 2
    return 2.0 * np.pi * int(np.argmax(power)) / residual.size
