"""The test of one window: whether the model leaves more below a band than the noise above it.

    residual = force - response(values, start)
    its cosines (DCT-II, orthonormal): c_k, of frequency k / (2 T)

Of a right model c_k is noise alone: white, beside the load cell's 1/f noise and what the noise of
the position makes of the force. The cosines above the band tell how much white noise there is;
those below it are fitted by generalised least squares: the model's parameters, the states at the
first sample and the place of the touch are free, the rig's constants within their tolerances. With
K cosines and p free values

    F = cost / (K - p),  of K - p and nu degrees of freedom (nu of the estimate of the noise)

(G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, 2.1.2 and 5.3, linear at the values found).
A model is linearised anew until the cost stays the same, so it may have any effects.

What is above the band is noise only as far as the force has it by itself; a second F compares the
two. An error of the encoder is in the position, and the force does not feel it. The window's chance
is twice the smaller one of the two tests (C. E. Bonferroni, 1936).

Contents: the search for a window's values, its noise, the test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import dct

from tissue_probe.diagnosis.chance import MEDIAN_SIZE, f_beyond
from tissue_probe.diagnosis.fitting.problem import Problem, StartPrior
from tissue_probe.diagnosis.observation.flicker import Evening
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.noise import Noise
from tissue_probe.diagnosis.residuals.noise_floor import noise_floor
from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.monitoring.tested_model import TestedModel
from tissue_probe.physics.response import course, respond
from tissue_probe.signals import BoolArray, FloatArray

#: A search ends where a step would lower the cost by less than this: of K - p, about a hundred and
#: more, it is beside the scatter of sqrt(2 (K - p)) nothing.
SETTLED_COST = 0.1
#: Steps of a search at the most: a linear model settles in three.
MOST_STEPS = 20
#: A step that raises the cost is damped so many times more, up to the most.
DAMPED, MOST_DAMPED = 10.0, 1e8
#: The median of squares tells a variance as well as the mean of this share of them (P. Rousseeuw,
#: C. Croux, JASA 88 (1993), 1273).
EFFICIENCY = 0.37
#: The same of the noise that a force tells by itself, which is right to 2 % on 4000 samples.
EFFICIENCY_ALONE = 0.31
#: Least noise [N], of samples that have none.
LEAST = 1e-12


@dataclass(frozen=True)
class Tested:
    """What the test of one window says.

    Attributes
    ----------
    stamp : int
        Time of the window's first sample [ns since the epoch].
    span : float
        The window's length [s].
    chance : float
        That a right model leaves as much by chance.
    rejected : bool
        Whether that is less than the settings allow.
    error_over_noise : float
        Residual below the band over its noise, rms; about 1 of a right model.
    noise : float
        White noise of the force [N].
    values : dict
        Each parameter and constant as the window has it (SI).
    """

    stamp: int
    span: float
    chance: float
    rejected: bool
    error_over_noise: float
    noise: float
    values: dict[str, float]

    #: pytest takes classes of this name for tests.
    __test__ = False


@dataclass
class _Place:
    """Where a search stands."""

    values: FloatArray
    start: FloatArray
    cosines: FloatArray
    sensitivity: FloatArray


class WindowTest:
    """Tests one window after another; each search begins where the last one ended.

    Parameters
    ----------
    model : TestedModel
        The model whose residual is tested.
    settings : MonitorSettings
        Band, and the chance at which a window is rejected.
    """

    def __init__(self, model: TestedModel, settings: MonitorSettings) -> None:
        self._model, self._settings = model, settings
        self._found: FloatArray | None = None

    def forget(self) -> None:
        """Begin the next search with the model's own values: another site, or another tissue."""
        self._found = None

    def test(self, stamp: int, position: FloatArray, force: FloatArray, period: float) -> Tested:
        """Test a window of even samples, each finite.

        Parameters
        ----------
        stamp : int
            Of the first sample [ns since the epoch].
        position, force : array, shape (n,)
            Displacement of the coil [m], force [N].
        period : float
            Time between two samples [s].
        """
        measured = Measurement(position, force, period, noise=Noise(1.0))
        search = _Search(self._model, measured, self._settings)
        search.run(self._found)
        self._found = search.at.values
        cost, freedom = search.cost(search.at), search.freedom
        below = float(f_beyond(np.array([cost / freedom]), freedom, search.noise_freedom)[0])
        chance = min(2.0 * min(below, search.chance_above), 1.0)
        names = search.problem.runs.names
        return Tested(
            stamp,
            force.size * period,
            chance,
            chance < self._settings.chance,
            float(np.sqrt(cost / freedom)),
            search.noise,
            dict(zip(names, search.at.values.tolist(), strict=True)),
        )


class _Search:
    """The values that leave least of a window below the band."""

    def __init__(
        self, model: TestedModel, measured: Measurement, settings: MonitorSettings
    ) -> None:
        self.problem = Problem(model.composition, [measured], model.instrument)
        self._measured, self._settings = measured, settings
        count = measured.force.size
        reach = min(2.0 * settings.band * count * measured.sample_period, count / 2)
        self._below = slice(max(int(reach), 1))
        # Above the band the tip rings, as an error of the start lets it: noise is told farther up.
        self._above = slice(min(2 * self._below.stop, count // 2), None)
        self._nominal = self.problem.nominal.copy()
        for index, name in enumerate(self.problem.runs.names):
            if not self.problem.deviation[index] < np.inf and name in model.values:
                self._nominal[index] = model.values[name]
        self._flicker = _flicker(count, float(self.problem.instrument.flicker_noise or 0.0))
        self._by_position = np.zeros(count)
        self._own_noise = max(noise_floor(measured.force, measured.position), LEAST)
        self.noise = self._own_noise
        self.chance_above = 1.0

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the cosines below the band that are left by the free values."""
        return max(self._below.stop - self.problem.unknowns, 1)

    @property
    def noise_freedom(self) -> float:
        """Degrees of freedom of the estimate of the noise."""
        return EFFICIENCY * (self._measured.force.size - self._above.start)

    def run(self, begin_at: FloatArray | None) -> None:
        """Search from values of an earlier window, or from the model's own."""
        values = self._nominal if begin_at is None else begin_at
        self.at = self._place(values, self.problem.begin(values)[0].mean)
        if noise := self._measured.position_noise:
            self._by_position = (noise * self._felt(self.at)) ** 2
        damping = 0.0
        for _ in range(MOST_STEPS):
            self.noise = self._white(self.at.cosines)
            cost = self.cost(self.at)
            step, promised = self._step(self.at, damping)
            if not promised > SETTLED_COST:
                break
            there = self._move(step)
            if self.cost(there) < cost:
                self.at, damping = there, damping / DAMPED
            else:
                damping = max(DAMPED * damping, 1.0 / DAMPED**2)
                if damping > MOST_DAMPED:
                    break
        self.noise = self._white(self.at.cosines)

    def cost(self, at: _Place) -> float:
        """Return the weighted squares below the band, and those of all priors."""
        if not np.isfinite(at.cosines).all():
            return np.inf
        begin = self.problem.begin(at.values)[0]
        off, departure = begin.mean - at.start, self._departure(at.values)
        left = at.cosines[self._below] * self._weights
        return float(left @ left + departure @ departure + off @ begin.precision @ off)

    @property
    def _weights(self) -> FloatArray:
        power = self.noise**2 + self._flicker + self._by_position
        weights: FloatArray = 1.0 / np.sqrt(power[self._below])
        return weights

    def _departure(self, values: FloatArray) -> FloatArray:
        drawn = self.problem.drawn
        off: FloatArray = (self.problem.nominal - values)[drawn]
        return np.asarray(off / self.problem.deviation[drawn], dtype=float)

    def _place(self, values: FloatArray, start: FloatArray) -> _Place:
        ((residual, sensitivity),) = self.problem.simulate(values, [start])
        cosines = dct(residual, norm="ortho")
        return _Place(values, start, cosines, dct(sensitivity, axis=0, norm="ortho")[self._below])

    def _move(self, step: FloatArray) -> _Place:
        states, problem = self.problem.states, self.problem
        moved = np.clip(self.at.values + step[states:], problem.lower, problem.upper)
        return self._place(moved, self.at.start + step[:states])

    def _step(self, at: _Place, damping: float) -> tuple[FloatArray, float]:
        """Return a step of start and values, and by how much it should lower the cost."""
        problem, states = self.problem, self.problem.states
        begin: StartPrior = problem.begin(at.values)[0]
        columns = (at.sensitivity.T * self._weights).T
        normal = columns.T @ columns
        gradient = columns.T @ (at.cosines[self._below] * self._weights)
        own, drawn = np.arange(states), states + problem.drawn
        normal[:states, :states] += begin.precision
        gradient[own] += begin.precision @ (begin.mean - at.start)
        normal[drawn, drawn] += problem.deviation[problem.drawn] ** -2
        gradient[drawn] += self._departure(at.values) / problem.deviation[problem.drawn]
        free = np.concatenate([np.ones(states, bool), problem.free & self._may_move(gradient)])
        step = np.zeros(free.size)
        step[free] = _solve_damped(normal[np.ix_(free, free)], gradient[free], damping)
        return step, float(gradient @ step)

    def _may_move(self, gradient: FloatArray) -> BoolArray:
        """Return which values are not held by a bound."""
        problem, down = self.problem, gradient[self.problem.states :] < 0.0
        at_lower = (self.at.values <= problem.lower) & down
        return ~(at_lower | ((self.at.values >= problem.upper) & ~down))

    def _white(self, cosines: FloatArray) -> float:
        """Return the white noise that the cosines above the band tell [N].

        The median of their sizes over what is known of them: noise of the position, 1/f noise.
        Where that is more than the force has by itself, it is the latter.
        """
        sizes = np.abs(cosines[self._above])
        known = (self._flicker + self._by_position)[self._above]
        noise = np.median(sizes) / MEDIAN_SIZE
        for _ in range(MOST_STEPS if known.max() > 0.01 * noise**2 else 0):
            over = np.median(sizes / np.sqrt(noise**2 + known)) / MEDIAN_SIZE
            if abs(over - 1.0) < 1e-3:
                break
            noise = max(noise * over, LEAST)
        over, alone = np.array([(noise / self._own_noise) ** 2]), EFFICIENCY_ALONE * cosines.size
        self.chance_above = float(f_beyond(over, self.noise_freedom, alone)[0])
        is_more = 2.0 * self.chance_above < self._settings.chance
        return self._own_noise if is_more else max(float(noise), LEAST)

    def _felt(self, at: _Place) -> FloatArray:
        """Return by how much the force answers to the position at each cosine's frequency [N/m].

        By the answer to a push at one sample, small beside the motion.
        """
        measured, problem = self._measured, self.problem
        push = 1e-3 * (float(np.ptp(measured.position)) + 1e-9)
        pushed = measured.position.copy()
        pushed[pushed.size // 2] += push
        kernel = problem.kernel
        own = problem.runs.values_in(0, at.values)
        coil = course(kernel, pushed, measured.sample_period, own, at_rest=False)
        answer = respond(kernel, own, at.start, coil).output
        before = measured.force - dct(at.cosines, type=3, norm="ortho")
        spectrum = np.abs(np.fft.rfft(answer - before)) / push
        return np.interp(np.arange(pushed.size) / 2.0, np.arange(spectrum.size), spectrum)


def _flicker(count: int, level: float) -> FloatArray:
    """Return the power of 1/f noise of this rms [N] in each cosine, as ``Evening`` spreads it."""
    weights = Evening.of(count, level, np.ones(count)).weights
    return weights**-2.0 - 1.0


def _solve_damped(normal: FloatArray, gradient: FloatArray, damping: float) -> FloatArray:
    """Solve the normal equations, scaled, and damped as Marquardt did."""
    scale = np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    scaled = normal / np.multiply.outer(scale, scale)
    scaled.flat[:: scale.size + 1] += damping
    return np.linalg.lstsq(scaled, gradient / scale, rcond=1e-12)[0] / scale
