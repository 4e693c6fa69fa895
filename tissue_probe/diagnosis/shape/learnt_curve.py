"""A learnt function as numbers on a grid, with its band.

Contents: those numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

from tissue_probe.signals import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Curve:
    """A learnt function, and how sure it is.

    Attributes
    ----------
    variables : tuple of str
        One for a curve, two for a surface. Of ``past`` it is the time since a step of the
        indentation, of ``path`` the way since the last reversal.
    grid : tuple of array
        Of each variable [SI units], over the range that the record visited.
    value, sd : array, shape (n,) or (n, m)
        Force [N] beyond a straight line of each variable, and its standard deviation; of ``past``
        the stiffness [N/m] that is left.
    visited : array of bool, as ``value``
        Where the record has samples; elsewhere the function is extrapolated.
    unit : str
        Of the values.
    """

    variables: tuple[str, ...]
    grid: tuple[FloatArray, ...]
    value: FloatArray
    sd: FloatArray
    visited: BoolArray
    unit: str = "N"
