"""What a specimen does: the force of a pressed one, the motion of a driven one, by SciPy alone.

Contents: equations of motion. Nothing of ``tissue_probe`` is imported.

    pressed  F = f(x, x') + the forces of branches,  x given
    driven   m x'' = F(t) - f(x, x', z),             F given
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d
from scipy.signal import cont2discrete, dlsim, lfilter

Array = np.ndarray
Law = Callable[[Array, Array], Array]
#: Steps between two samples. A depth is straight in each: corners are rounded over more, and the
#: error is a thousandth of the noise or less. A motion that is read ten times a period has 200 of
#: them a period, of which Runge and Kutta's rule errs by 1e-8 a radian.
STEPS = 20


def points(times: Sequence[float], values: Sequence[float], rounding: float) -> Callable:
    """Return a course along straight lines, its corners rounded over so many seconds."""

    def course(fine: Array) -> Array:
        straight = np.interp(fine, times, values)
        return gaussian_filter1d(straight, rounding / (fine[1] - fine[0]), mode="nearest")

    return course


def pressed(
    course: Callable,
    count: int,
    period: float,
    law: Law,
    branches: Sequence[tuple] = (),
    stretch: Callable = lambda depth: depth,
) -> tuple[Array, Array, Array]:
    """Return times [s], depths [m] and forces [N] of a tip that follows a course, from rest.

    Parameters
    ----------
    course : callable
        Of times at even steps.
    count, period
        Of the samples [-], [s].
    law : callable
        Force at once, of depth and speed.
    branches : sequence of (float, float)
        Stiffness [N/m] and rate [1/s] of what relaxes: q' = E s' - r q.
    stretch : callable
        What stretches the branches, of depth.
    """
    step = period / STEPS
    fine = step * np.arange((count - 1) * STEPS + 1)
    depth = course(fine)
    force, stretched = law(depth, np.gradient(depth, step)), stretch(depth)
    for stiffness, rate in branches:
        kept = np.exp(-rate * step)
        gain = stiffness * (1.0 - kept) / (rate * step)  # exact of a straight line in each step
        force = force + lfilter([gain], [1.0, -kept], np.diff(stretched, prepend=stretched[0]))
    return fine[::STEPS], depth[::STEPS], force[::STEPS]


def driven(
    force: Array, period: float, mass: float, law: Callable, state: Sequence[float] = (0.0, 0.0)
) -> Array:
    """Return the positions [m] of a mass that a smooth force drives.

    Parameters
    ----------
    force : array, shape (n,)
        At the samples [N]; a cubic spline between them.
    period, mass : float
        [s], [kg].
    law : callable
        Returns the specimen's force, and the rates of its further states, of the state.
    state : sequence of float
        Position, velocity and further states at the first sample.
    """
    step = period / STEPS
    between = CubicSpline(period * np.arange(force.size), force)
    pushes = between(0.5 * step * np.arange(2 * STEPS * (force.size - 1) + 1)).tolist()

    def rate(push: float, now: list[float]) -> list[float]:
        back, *others = law(now)
        return [now[1], (push - back) / mass, *others]

    def on(now: list[float], slope: list[float], interval: float) -> list[float]:
        return [value + interval * change for value, change in zip(now, slope, strict=True)]

    now, found = list(state), []
    # Runge and Kutta's rule of fourth order; plain numbers are quicker here than short arrays.
    for index in range(0, len(pushes) - 1, 2):
        if index % (2 * STEPS) == 0:
            found.append(now[0])
        begin, middle, end = pushes[index : index + 3]
        one = rate(begin, now)
        two = rate(middle, on(now, one, step / 2.0))
        three = rate(middle, on(now, two, step / 2.0))
        four = rate(end, on(now, three, step))
        slopes = zip(one, two, three, four, strict=True)
        now = on(now, [(a + 2.0 * (b + c) + d) / 6.0 for a, b, c, d in slopes], step)
    return np.array([*found, now[0]])


def held(force: Array, period: float, mass: float, damping: float, stiffness: float) -> Array:
    """Return the positions [m] of a mass on a linear specimen; each sample's force is held."""
    rates = np.array([[0.0, 1.0], [-stiffness / mass, -damping / mass]])
    driven_by, read = np.array([[0.0], [1.0 / mass]]), np.array([[1.0, 0.0]])
    system = cont2discrete((rates, driven_by, read, np.zeros((1, 1))), period)
    return dlsim(system, force)[1][:, 0]


def rubbing(force: Array, period: float, mass: float, damping: float, friction: float) -> Array:
    """Return the positions [m] of a mass that dry friction holds until the force exceeds it.

    The force goes straight from sample to sample. Each of the small steps is exact for its mean
    force but for the instant in which the mass comes to rest.
    """
    step, position, velocity, found = period / STEPS, 0.0, 0.0, []
    kept = np.exp(-damping / mass * step)
    middles = (np.arange((force.size - 1) * STEPS) + 0.5) / STEPS
    for index, push in enumerate(np.interp(middles, np.arange(force.size), force).tolist()):
        if index % STEPS == 0:
            found.append(position)
        if velocity == 0.0 and abs(push) <= friction:
            continue
        way = np.sign(velocity) if velocity else np.sign(push)
        speed = (push - friction * way) / damping  # at which it would settle
        after = speed + (velocity - speed) * kept
        if after * velocity < 0.0:
            velocity = 0.0
            continue
        position += speed * step + (velocity - after) * mass / damping
        velocity = after
    return np.array([*found, position])
