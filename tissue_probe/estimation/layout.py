"""Where each number lives in the two arrays that every kernel works on.

``constants`` does not change while the stream runs: the settings, the sample period, and for each
state of the filter its prior, process noise and bounds. ``memory`` is all a filter carries from one
sample to the next.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tissue_probe.estimation.settings import EstimatorSettings
from tissue_probe.physics.rigs import RIGS


@dataclass(frozen=True)
class Prior:
    """The prior of one state, where no setting states it.

    ``mean``, ``deviation`` and the bounds are in the state's unit; ``walk`` is the variance that it
    gains in each second. A state that walks is begun anew after a gap.
    """

    mean: float
    deviation: float
    lower: float = -math.inf
    upper: float = math.inf
    walk: float = 0.0


SETTINGS = tuple(
    name
    for name, entry in EstimatorSettings.model_fields.items()
    if entry.annotation in (float, int)
)
DERIVED = ("sample_period", "force_variance", "batch", "window")
PER_STATE = ("prior", "prior_variance", "largest_variance", "process_variance", "lower", "upper")

# Samples whose innovations are held against the batch before (see ``verdict``): at least 50 ms, in
# which a hum beside a harmonic turns its phase, and so many that their sum is normal.
BATCH_TIME, BATCH_SAMPLES = 0.05, 100.0
# In which a wrong model is found, from a filter's start on [s]: three short batches that contradict
# it, and the one before them.
TEST_TIME = 4.0 * BATCH_TIME
# Time and samples of a window (see ``windows``): in 10 ms an encoder's steps average out, and
# 100 Hz, faster than tissue is palpated, still get through; sums of 16 samples are integrals to
# 1e-4.
WINDOW_TIME, WINDOW_SAMPLES = 0.01, 16
# How many numbers the verdict carries along.
VERDICT_SIZE = 56

#: Numbers that a model has carried along, beside the estimator's own: samples since the start, and
#: the place of the coil at the sample before [m].
OF_THE_MODEL = ("SAMPLES", "POSITION_BEFORE")

# How many times farther than others a standard deviation may grow; once for a state that is not
# listed.
CEILING = {"force_offset": 100.0}


@dataclass(frozen=True)
class StateLayout:
    """Places of the numbers of a filter whose states are ``states``, motion first.

    Attributes
    ----------
    states : tuple of str
        Names of the filter's states: the model's, then its parameters.
    extra : mapping
        Further numbers that the estimator carries along: names, and values at the start.
    known : mapping
        Constants of the model that are no settings: names and values.
    priors : mapping
        Of the states that the settings do not know.
    windowed : bool
        Whether samples are taken in by windows (``windows``), not one by one.
    considered : tuple of str
        Constants that are known roughly (``considered``).
    """

    states: tuple[str, ...]
    extra: Mapping[str, float] = field(default_factory=dict)
    known: Mapping[str, float] = field(default_factory=dict)
    priors: Mapping[str, Prior] = field(default_factory=dict)
    windowed: bool = False
    considered: tuple[str, ...] = ()

    def constant(self, name: str) -> int:
        """Place in ``constants`` of a setting, a derived number, or a constant of the model."""
        if name in self.known:
            return self.per_state(PER_STATE[-1]) + len(self.states) + list(self.known).index(name)
        return (*SETTINGS, *DERIVED).index(name)

    def per_state(self, name: str) -> int:
        """Place in ``constants`` of the first of the numbers that each state has."""
        return len(SETTINGS) + len(DERIVED) + PER_STATE.index(name) * len(self.states)

    def covariance(self, row: int, column: int) -> int:
        """Place in ``memory`` of P[row, column]; the upper triangle is kept, row by row."""
        count, (i, j) = len(self.states), sorted((row, column))
        return count + i * count - i * (i - 1) // 2 + j - i

    @property
    def history(self) -> int:
        """Place in ``memory`` of u[t], u[t-1], u[t-2], u[t-3]; the end of mean and covariance.

        Of u, u', u'' of a window where samples are taken in by windows.
        """
        count = len(self.states)
        return count + count * (count + 1) // 2

    @property
    def primed(self) -> int:
        """Place in ``memory`` of how many of the four inputs are known."""
        return self.history + 4

    @property
    def predicted(self) -> int:
        """Place in ``memory`` of the force predicted last [N]."""
        return self.history + 5

    @property
    def latest(self) -> int:
        """Place in ``memory`` of the innovation taken in last [N], and of its normalized square."""
        return self.history + 6

    @property
    def verdict(self) -> int:
        """Place in ``memory`` of the first of the numbers that ``verdict`` carries along."""
        return self.history + 8

    @property
    def rejected(self) -> int:
        """Place in ``memory`` of whether the model is rejected (see ``verdict``)."""
        return self.verdict + 2

    def carried(self, name: str) -> int:
        """Place in ``memory`` of one of the ``extra`` numbers."""
        return self.verdict + VERDICT_SIZE + list(self.extra).index(name)

    @property
    def considering(self) -> int:
        """Place in ``memory`` of W, d, L of the considered constants (see ``Filter``)."""
        return self.verdict + VERDICT_SIZE + len(self.extra)

    def view_considered(self, memory: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """Return W, d, L of the considered constants, shapes (n, q), (q,), (q, q), as views."""
        n, q, place = len(self.states), len(self.considered), self.considering
        W, d, L = np.split(memory[place : self.size], [n * q, n * q + q])
        return W.reshape(n, q), d, L.reshape(q, q)

    def by_constants(self, memory: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return W W^T, the covariance that is due to considered constants, shape (n, n)."""
        W, _, _ = self.view_considered(memory)
        return np.asarray(W @ W.T)

    @property
    def constant_count(self) -> int:
        """Length of ``constants``."""
        return self.per_state(PER_STATE[-1]) + len(self.states) + len(self.known)

    @property
    def size(self) -> int:
        """Length of ``memory``, without the equations' intermediate results."""
        q = len(self.considered)
        return self.considering + q * len(self.states) + q + q * q

    def constants(self, settings: EstimatorSettings, sample_period: float) -> NDArray[np.float64]:
        """Return the array ``constants`` for given settings and sample period [s]."""
        values = [float(getattr(settings, name)) for name in SETTINGS]
        values += [sample_period, force_variance(settings)]
        window = window_samples(sample_period) if self.windowed else 1
        between = max(window // 2, 1) * sample_period
        values += [max(BATCH_SAMPLES, BATCH_TIME / between), float(window)]
        for name in PER_STATE:
            for state in self.states:
                prior = self.priors.get(state)
                values.append(
                    _per_state(settings, name, state)
                    if prior is None
                    else _of_prior(prior, name, sample_period, settings.deviation_ceiling)
                )
        return np.array([*values, *self.known.values()])


def force_variance(settings: EstimatorSettings) -> float:
    """R [N^2]: the load cell's noise, and the encoder's rounding seen through its stiffness.

    An error of the position shifts the predicted force k0 (u - x); rounding to steps q has the
    variance q^2 / 12. Where the tip follows the position rigidly, it is seen through the tissue
    only (``windows``), and not counted here.
    """
    if RIGS[settings.rig].tip_is_position:
        return settings.force_noise**2
    rounding = settings.load_cell_stiffness * settings.encoder_resolution / math.sqrt(12.0)
    return settings.force_noise**2 + rounding**2


def window_samples(sample_period: float) -> int:
    """Return how many samples make a window: an even number."""
    return 2 * math.ceil(max(WINDOW_SAMPLES, WINDOW_TIME / sample_period * (1.0 - 1e-9)) / 2)


def _of_prior(prior: Prior, name: str, sample_period: float, ceiling: float) -> float:
    return {
        "prior": prior.mean,
        "prior_variance": prior.deviation**2,
        "largest_variance": (ceiling * prior.deviation) ** 2,
        "process_variance": prior.walk * sample_period,
        "lower": prior.lower,
        "upper": prior.upper,
    }[name]


def _per_state(settings: EstimatorSettings, name: str, state: str) -> float:
    if name == "prior_variance":
        return float(getattr(settings, f"{state}_prior_sd") ** 2)
    if name == "largest_variance":
        ceiling = CEILING.get(state, 1.0) * settings.deviation_ceiling
        return float((ceiling * getattr(settings, f"{state}_prior_sd")) ** 2)
    if name == "process_variance":
        return settings.velocity_noise if state == "tip_velocity" else 0.0
    field, default = {
        "prior": (f"{state}_prior", 0.0),
        "lower": (f"{state}_minimum", -math.inf),
        "upper": (f"{state}_maximum", math.inf),
    }[name]
    return float(getattr(settings, field, default))
