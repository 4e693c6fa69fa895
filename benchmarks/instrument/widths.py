"""How well the best possible fit knows the values: the widths of an exact simulation.

    sd = sqrt diag (J'J)^-1 sigma,    J = d position / d values

Contents: sensitivities by central differences, and widths.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

Array = np.ndarray
#: Change of a value, as a share: its cube root of the integrator's error, so that the error of the
#: difference (1e-10 / 1e-3) and that of the third derivative (1e-3 squared) are alike small.
CHANGE = 1e-3


def widths(
    simulate: Callable[[Mapping[str, Array]], Array], values: Mapping[str, float], noise: float
) -> dict[str, float]:
    """Return the standard deviation of each value.

    Parameters
    ----------
    simulate : callable
        Of values of shape (sets,): outputs, shape (sets, samples).
    values : mapping
        The true ones, none of them 0.
    noise : float
        Standard deviation of the output's white noise.
    """
    names, count = list(values), len(values)
    factors = np.ones((2 * count, count))
    factors[range(count), range(count)] += CHANGE
    factors[range(count, 2 * count), range(count)] -= CHANGE
    sets = {name: values[name] * factors[:, i] for i, name in enumerate(names)}
    outputs = simulate(sets)
    # By relative changes: the normal matrix of values in their own units is near to singular.
    slopes = (outputs[:count] - outputs[count:]) / (2.0 * CHANGE)
    covariance = np.linalg.inv(slopes @ slopes.T) * noise**2
    return {
        name: float(abs(values[name]) * np.sqrt(covariance[i, i])) for i, name in enumerate(names)
    }
