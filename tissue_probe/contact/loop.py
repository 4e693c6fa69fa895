"""The loop of an admittance that presses on tissue, and its margins.

The controller moves a virtual mass by the measured force,

    M x'' + D x' + S y = F,    y = P(s) x,    P(s) = 1 / (1 + T s)

x is commanded, y is where the robot is: its position loop lags by T. The tissue answers to y,
F = -(k + beta s) exp(-tau s) y, after the delay tau of sensor, filter and controller. Broken at the
force, the loop is

    L(s) = (k + beta s) exp(-tau s) P / (M s^2 + D s + S P)

ros2_controllers' admittance controller is of this form: it takes the spring's way from the measured
joints. Margins are those of K. Åström and R. Murray, Feedback Systems (2008), section 9.3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from tissue_probe.signals import FloatArray

#: Points a decade of frequency at which crossings are sought: between two of them a loop without
#: delay turns by some hundredths of a turn, beside a resonance damped by 1 % by a tenth.
A_DECADE = 400
#: Points a turn of the delay.
A_TURN = 20
#: From so many turns of the delay on, every frequency counts as one where -1 may be met: the next
#: is 2 % off, and the loop's gain there the same to as much.
DELAY_TURNS = 50
#: No margin beyond this is told: crossings where the loop's gain is less are not sought.
LARGEST_MARGIN = 100.0


@dataclass(frozen=True)
class Margins:
    """How far a loop is from its stability limit.

    Attributes
    ----------
    gain : float
        By which factor a tissue may be stiffer, damping in proportion; infinite where any may.
        Below 1 the loop is unstable, with this tissue or with a softer one.
    phase : float
        By how much the loop may turn further at its crossovers [rad]; infinite where it has none.
    crossover : float
        Highest frequency at which the loop's gain is 1 [Hz]; 0 where it is less everywhere.
    """

    gain: float
    phase: float
    crossover: float


@dataclass(frozen=True)
class Admittance:
    """A virtual mass on a damper and a spring, moved by a measured force.

    Attributes
    ----------
    mass, damping, spring : float
        M [kg], D [N s/m], S [N/m]; all above 0.
    delay : float
        tau, of the force that arrives, after the motion that made it [s].
    lag : float
        T, of the robot's position after the commanded one [s].
    """

    mass: float
    damping: float
    spring: float
    delay: float
    lag: float = 0.0

    @property
    def is_stable_in_air(self) -> bool:
        """Whether it comes to rest without tissue (A. Hurwitz' condition of the third degree)."""
        middle = (self.mass + self.damping * self.lag) * self.damping
        return middle > self.mass * self.lag * self.spring

    def open_loop(
        self, omega: FloatArray, stiffness: float, damping: float
    ) -> NDArray[np.complex128]:
        """Return L at angular frequencies [rad/s] with a tissue [N/m, N s/m], shape (n,)."""
        s = 1j * omega
        followed = 1.0 / (1.0 + self.lag * s)
        own = self.mass * s**2 + self.damping * s + self.spring * followed
        felt = (stiffness + damping * s) * np.exp(-self.delay * s) * followed
        return np.asarray(felt / own, dtype=np.complex128)

    def margins(self, stiffness: float, damping: float) -> Margins:
        """Return the margins with a tissue.

        Softer tissues of the same kind have no less: the gain margin is that of all crossings.

        Parameters
        ----------
        stiffness, damping : float
            Of the tissue [N/m], above 0; [N s/m].
        """
        if not self.is_stable_in_air:
            return Margins(0.0, -np.inf, 0.0)
        omega = self._frequencies(stiffness, damping)
        loop = self.open_loop(omega, stiffness, damping)
        gain, turned = np.abs(loop), np.angle(-loop)

        def phase(at: float) -> float:
            return float(np.angle(-self.open_loop(np.array([at]), stiffness, damping)[0]))

        def excess(at: float) -> float:
            return float(np.log(np.abs(self.open_loop(np.array([at]), stiffness, damping)[0])))

        # -1 is met where the angle of -L passes 0, and not where it jumps by a turn.
        passing = (turned[:-1] * turned[1:] <= 0.0) & (np.abs(np.diff(turned)) < np.pi)
        meets = [brentq(phase, omega[i], omega[i + 1]) for i in np.flatnonzero(passing)]
        crossing = np.flatnonzero((gain[:-1] - 1.0) * (gain[1:] - 1.0) < 0.0)
        crossovers = [brentq(excess, omega[i], omega[i + 1]) for i in crossing]
        often = omega > self._often
        largest = max([float(np.exp(excess(at))) for at in meets], default=0.0)
        largest = max(largest, float(gain[often].max(initial=0.0)))
        near = min((abs(phase(at)) * (at <= self._often) for at in crossovers), default=np.inf)
        return Margins(
            gain=1.0 / largest if largest * LARGEST_MARGIN > 1.0 else np.inf,
            phase=near if largest < 1.0 else -near,
            crossover=max(crossovers, default=0.0) / (2.0 * np.pi),
        )

    @property
    def _often(self) -> float:
        """Angular frequency from which on the delay has turned the loop often [rad/s]."""
        return 2.0 * np.pi * DELAY_TURNS / self.delay if self.delay > 0.0 else np.inf

    def _frequencies(self, stiffness: float, damping: float) -> FloatArray:
        """Return angular frequencies about all crossings [rad/s].

        At the last one the gain is below 1 / ``LARGEST_MARGIN``: mass or damper alone hold it.
        """
        stiff, damp = self.spring + LARGEST_MARGIN * stiffness, LARGEST_MARGIN * damping
        last = (damp + np.sqrt(damp**2 + 4.0 * self.mass * stiff)) / (2.0 * self.mass)
        if self.damping > damp:
            last = min(last, stiff / (self.damping - damp))
        own = self.spring / self.damping, np.sqrt(self.spring / self.mass)
        low, high = np.log10(0.01 * min(*own, last)), np.log10(last)
        spread = np.logspace(low, high, round(A_DECADE * (high - low)))
        if not self.delay > 0.0:
            return spread
        step = 2.0 * np.pi / (A_TURN * self.delay)
        turning = step * np.arange(1, round(min(last, self._often) / step) + 1)
        return np.unique(np.concatenate([spread, turning]))
