"""A tip that a known force drives: by SciPy's integrator, as exactly as that goes.

    m x'' = F(t) - k x - beta x' - law,    e' = x' - r e

Contents: the equation of motion, of several sets of values at once; the closed form of a linear
tip.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.instrument.laws import Law, Values
from benchmarks.instrument.multisine import Multisine

Array = np.ndarray
#: Relative error of a step: far below the least noise, a 10,000th of the motion.
TOLERANCE = 1e-10
#: Names of a linear tip's values.
LINEAR = ("tip_mass", "stiffness", "damping")


def driven(
    law: Law,
    values: Values,
    force: Callable[[float], float | Array],
    times: Array,
    start: tuple[float, float],
    travel: float,
) -> Array:
    """Return the position of the tip [m], shape (sets, times) or (times,) of one set of values.

    Parameters
    ----------
    law : Law
        Of the tissue beside k and beta.
    values : mapping
        ``LINEAR`` and the law's, numbers or arrays of shape (sets,).
    force : callable
        Of the time [s]: the force [N] on all tips alike, or on each.
    times : array
        Sorted [s]; the first is that of the start.
    start : tuple of float
        Position [m], and speed [m/s]; the branch has yielded.
    travel : float
        Size of the motion [m]; errors of a step are below ``TOLERANCE`` of it.
    """
    own = {name: np.atleast_1d(np.asarray(value, float)) for name, value in values.items()}
    several = np.ndim(force(times[0])) or any(value.size > 1 for value in own.values())
    sets = max(np.size(force(times[0])), *(value.size for value in own.values()))
    mass, stiffness, damping = (own[name] for name in LINEAR)
    rate = own[law.rate] if law.rate else np.zeros(1)

    def slope(time: float, state: Array) -> Array:
        x, v, e = state.reshape(3, sets)
        pull = stiffness * x + damping * v + law.force(own, x, v, e)
        return np.concatenate([v, (force(time) - pull) / mass, v - rate * e])

    begin = np.repeat([start[0], start[1], 0.0], sets)
    speed = travel * float(np.sqrt(np.max(stiffness / mass)))
    scale = np.repeat([travel, speed, travel], sets)
    found = solve_ivp(
        slope, (times[0], times[-1]), begin, "DOP853", times, rtol=TOLERANCE,
        atol=TOLERANCE * scale,
    )  # fmt: skip
    if not found.success:
        raise ValueError(f"the tip's motion cannot be integrated: {found.message}")
    position = found.y[:sets]
    return position if several else position[0]


def linear(
    values: Mapping[str, float], force: Multisine, times: Array, start: tuple[float, float]
) -> Array:
    """Return the same of a linear tip in closed form, from the time 0 on: forced and free motion.

    Any values, also those of a tip that creeps back (damping beyond the critical).
    """
    mass, stiffness, damping = (values[name] for name in LINEAR)
    forced = force.through(lambda s: 1.0 / (mass * s**2 + damping * s + stiffness))
    left = start[0] - float(forced(0.0))
    speed = start[1] - float(forced.through(lambda s: s)(0.0))
    root = np.sqrt(complex(damping**2 - 4.0 * mass * stiffness))
    fast, slow = ((-damping - root) / (2.0 * mass), (-damping + root) / (2.0 * mass))
    share = (speed - slow * left) / (fast - slow)
    free = share * np.exp(fast * times) + (left - share) * np.exp(slow * times)
    return forced(times) + free.real
