"""Viscosity, storage and loss of a tissue whose Young's modulus is known.

Contents: the complex stiffness of a model in pascals, with its error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

from tissue_probe.analysis.modulus_result import ComplexModulus, Modulus
from tissue_probe.errors import ParameterError
from tissue_probe.physics.complex_stiffness import TissueInSmallMotion, name_nonlinear
from tissue_probe.physics.fitted_model import FittedModel

#: Part of a standard deviation by which a value is moved for a derivative: small, and far above
#: rounding.
PART_MOVED = 1e-3
INDEPENDENT = (
    "The errors of the model's values are taken as independent: a model file does not tell how "
    "they go together."
)


def propagate_error(
    found: FittedModel, function: Callable[[Mapping[str, float]], float]
) -> tuple[float, float]:
    """Return a function of a model's values, and its standard deviation by theirs.

    NaN where the model has no deviation of its stiffness.
    """
    variance = 0.0
    for name, deviation in found.deviations.items():
        if name in found.values and deviation > 0.0:
            step = PART_MOVED * deviation
            ahead, behind = (
                function({**found.values, name: found.values[name] + way}) for way in (step, -step)
            )
            variance += ((ahead - behind) / (2.0 * PART_MOVED)) ** 2
    known = found.deviations.get("stiffness", 0.0) > 0.0
    return function(found.values), math.sqrt(variance) if known else math.nan


def add_motion(
    found: FittedModel,
    young: Modulus,
    depth: float | None,
    frequencies: tuple[float, ...],
    geometry: float = 0.0,
) -> Modulus:
    """Add viscosity, and storage and loss at frequencies [Hz], to a modulus.

    They are to damping and complex stiffness as the modulus is to the stiffness: all linear
    viscoelastic laws under one geometry are (E. Lee, Quarterly of Applied Mathematics 13 (1955),
    183).

    Parameters
    ----------
    found : FittedModel
        The model.
    young : Modulus
        Its modulus.
    depth : float, optional
        About which the motion is small [m].
    frequencies : tuple of float
        [Hz].
    geometry : float
        Relative standard deviation of the factor from stiffness to modulus.

    Raises
    ------
    ParameterError
        If frequencies are asked for of a model without storage and loss, or at no stated depth.
    """
    refused = _explain_refusal(found, depth)
    if refused and frequencies:
        raise ParameterError(refused)
    if refused:
        return young
    tissue, at = TissueInSmallMotion(found.composition), depth or 0.0
    factor = young.value / tissue.spring(found.values, at)

    def scale(part: Callable[[Mapping[str, float]], float]) -> tuple[float, float]:
        value, deviation = propagate_error(found, lambda values: factor * part(values))
        return value, math.hypot(deviation, geometry * value)

    def scale_at(frequency: float) -> ComplexModulus:
        stiffness = tissue.complex_stiffness
        storage = scale(lambda values: stiffness(values, at, frequency).real)
        loss = scale(lambda values: stiffness(values, at, frequency).imag)
        return ComplexModulus(frequency, *storage, *loss)

    viscosity, deviation = scale(lambda values: tissue.damper(values, at))
    return replace(
        young,
        viscosity=viscosity,
        viscosity_deviation=deviation,
        spectrum=tuple(map(scale_at, frequencies)),
        notes=young.notes + ((INDEPENDENT,) if frequencies else ()),
    )


def _explain_refusal(found: FittedModel, depth: float | None) -> str:
    """Say why a model has no storage and loss; empty where it has."""
    if nonlinear := name_nonlinear(found.composition):
        return (
            f"`frequency`: the model has {', '.join(nonlinear)}, by which the force depends on "
            "speed, history or time: it has no storage and loss modulus; leave `frequency` out"
        )
    tissue = TissueInSmallMotion(found.composition)
    if depth is None and tissue.differs_with_depth:
        return (
            "`depth`: storage and loss of the model differ with the depth: give that about which "
            "the tip moves"
        )
    if missing := tissue.names - found.values.keys():
        return f"`model` has no value of {min(missing)}: fit it first"
    return ""
