"""Forces of a tissue beside its spring and its damper, by numbers.

Contents: the equations, the names of their values, to which effect and family of the library each
belongs. The equations are written from the literature named in the library's effects.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
Values = Mapping[str, "float | Array"]
#: The depth that laws refer to which are powers of it [m].
REFERENCE = 1e-3


@dataclass(frozen=True)
class Law:
    """A force [N] on the tip, positive against indentation, beside k x + beta x'.

    Attributes
    ----------
    effect, family : str
        Of the library.
    names : tuple of str
        Of its values, as the library calls them [SI].
    force : callable
        Of the values, the depth x [m], the speed x' [m/s], and the branch's compression e [m], for
        which e' = x' - r e.
    deep : bool
        Whether it is a law of the depth of contact: the tip must not come to 0.
    usual : bool
        Whether the library's values refer to 1 mm, or are bounded in m/s: in a record of another
        size these would be others.
    rate : str
        Name of r [1/s]; empty without a branch.
    """

    effect: str
    family: str
    names: tuple[str, ...]
    force: Callable[[Values, Array, Array, Array], Array]
    deep: bool = False
    usual: bool = False
    rate: str = ""


def _cubic(values: Values, x: Array, v: Array, e: Array) -> Array:
    return values["cubic_stiffness"] * x**3


def _exponential(values: Values, x: Array, v: Array, e: Array) -> Array:
    depth = x / values["exponential_length"]
    return values["exponential_force"] * (np.expm1(depth) - depth)


def _hertz(values: Values, x: Array, v: Array, e: Array) -> Array:
    power = (np.maximum(x, 0.0) / REFERENCE) ** values["contact_exponent"]
    return values["stiffness"] * (REFERENCE * power - x)


def _hunt_crossley(values: Values, x: Array, v: Array, e: Array) -> Array:
    power = (np.maximum(x, 0.0) / REFERENCE) ** values["depth_damping_exponent"]
    return values["depth_damping"] * power * v


def _branch(values: Values, x: Array, v: Array, e: Array) -> Array:
    return values["relaxing_stiffness"] * e


def _friction(values: Values, x: Array, v: Array, e: Array) -> Array:
    return values["coulomb_force"] * np.tanh(v / values["transition_velocity"])


PLAIN = Law("", "", (), lambda values, x, v, e: 0.0 * x)
CUBIC = Law("cubic_stiffening", "stiffening", ("cubic_stiffness",), _cubic)
LAWS = (
    CUBIC,
    Law(
        "exponential_stiffening", "stiffening", ("exponential_force", "exponential_length"),
        _exponential,
    ),
    Law("hertz_contact", "stiffening", ("contact_exponent",), _hertz, deep=True, usual=True),
    Law(
        "hunt_crossley", "stiffening", ("depth_damping", "depth_damping_exponent"),
        _hunt_crossley, deep=True, usual=True,
    ),
    Law(
        "standard_linear_solid", "relaxation", ("relaxing_stiffness", "relaxation_rate"), _branch,
        rate="relaxation_rate",
    ),
    Law(
        "coulomb_friction", "friction", ("coulomb_force", "transition_velocity"), _friction,
        usual=True,
    ),
)  # fmt: skip
