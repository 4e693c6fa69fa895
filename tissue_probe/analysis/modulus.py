"""The modulus of tissue in pascals: a fitted stiffness, and the shape of the tip or of the bar.

Contents: the question, and the modulus under a tip.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tissue_probe import arguments as take
from tissue_probe.analysis.bar_modulus import NO_DEVIATION, find_bar_modulus
from tissue_probe.analysis.modulus_in_motion import add_motion
from tissue_probe.analysis.modulus_result import Modulus
from tissue_probe.analysis.question import constant, either_model
from tissue_probe.errors import ParameterError
from tissue_probe.physics.bars import UniformBar
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects.hertz_contact import REFERENCE_DEPTH
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.indenters import DEPTH_POWERS, THINNEST, Indenter, Shape
from tissue_probe.physics.model_file import load

#: The law whose force grows as a power of the depth, and that power by name.
HERTZ, EXPONENT_NAME = "hertz_contact", "contact_exponent"
#: A fitted power and that of a shape are one if they differ by no more: down to half the depth and
#: up to twice it the forces then differ by 7 %, 2^0.1.
POWER_TOLERANCE = 0.1
#: Poisson's ratio of a tissue that keeps its volume: the largest.
INCOMPRESSIBLE = 0.5


def _frequencies(name: str, given: Any) -> tuple[float, ...]:
    """Take a frequency [Hz], or several."""
    kind = take.number(above=0.0, unit="Hz")
    several = given if isinstance(given, (list, tuple)) else (given,)
    return tuple(kind(name, each) for each in several)


def _size_of_bar(name: str, given: Any) -> tuple[float, float]:
    """Take a size above 0, or one with its standard deviation."""
    stated = constant(name, given)
    value, deviation = stated if isinstance(stated, tuple) else (stated, 0.0)
    return take.number(above=0.0)(name, value), take.number(least=0.0)(name, deviation)


@take.checks(
    model=either_model,
    indenter=take.optional(take.choice(*DEPTH_POWERS)),
    radius=take.optional(take.number(above=0.0, unit="m")),
    half_angle=take.optional(take.number(above=0.0, below=90.0, unit="degrees")),
    poisson=take.number(least=0.0),
    layer=take.optional(take.number(above=0.0, unit="m")),
    depth=take.optional(take.number(above=0.0, unit="m")),
    gauge_length=take.optional(_size_of_bar),
    area=take.optional(_size_of_bar),
    frequency=_frequencies,
)
def modulus(
    model: str | Path | FittedModel,
    indenter: Shape | None = None,
    *,
    radius: float | None = None,
    half_angle: float | None = None,
    poisson: float = 0.5,
    layer: float | None = None,
    depth: float | None = None,
    gauge_length: float | tuple[float, float] | None = None,
    area: float | tuple[float, float] | None = None,
    frequency: float | Sequence[float] = (),
) -> Modulus:
    """Return the modulus that a model's stiffness means under a tip, or of a bar, of known size.

    Under a tip a model with ``hertz_contact`` gives it by the force at the depth; a straight one by
    its stiffness, which is the slope of the force there. Of a bar it is the slope of stress over
    strain. The stiffness is that after all relaxation.

    Parameters
    ----------
    model : path or FittedModel
        A model with values, such as ``diagnose(...).model``.
    indenter : {"flat", "sphere", "cone"}, optional
        Shape of the tip: a flat punch, a sphere or a cone. A bar has none.
    radius : float, optional
        Of punch or sphere [m].
    half_angle : float, optional
        Of a cone, from its axis [degrees].
    poisson : float
        Poisson's ratio of the tissue, 0 to 0.5 (incompressible).
    layer : float, optional
        Height of a layer that is bonded to a hard base, under a sphere, for ``poisson`` 0.5 [m].
    depth : float, optional
        Depth from the touch [m]: of a straight model that at which the tip moved. Of a bar the
        extension or shortening, where the model is curved.
    gauge_length, area : float or (float, float), optional
        Of a bar that is pulled or pressed between grips or plates: its length [m] and the area of
        its cross-section [m^2] without load, or each with its standard deviation.
    frequency : float or sequence of float
        At which storage and loss modulus are told [Hz].

    Raises
    ------
    ParameterError
        If a number is out of its range, one that the shape needs is missing, one is given that it
        has not, or the model has no stiffness that is a modulus.
    """
    found = model if isinstance(model, FittedModel) else load(model)
    _check_stiffness(found)
    frequencies = _frequencies("frequency", frequency)
    sizes = {"radius": radius, "half_angle": half_angle, "layer": layer}
    if bar := _take_bar({"indenter": indenter, **sizes}, gauge_length, area):
        return find_bar_modulus(found, bar, depth, frequencies)
    if indenter is None:
        raise ParameterError(
            "`indenter`: give the shape of the tip; or of a bar `gauge_length` and `area`"
        )
    _check_law(found.composition)
    tip = _take_tip(indenter, _size(indenter, radius, half_angle), poisson, layer)
    told = _apply_power_law if HERTZ in found.composition.names else _straight
    return add_motion(found, told(found, tip, depth), depth, frequencies)


def _take_bar(tip: Mapping[str, Any], gauge_length: Any, area: Any) -> UniformBar | None:
    """Return the bar that is stated, if one is.

    Raises
    ------
    ParameterError
        If a tip is stated as well, or one of its sizes is not.
    """
    if gauge_length is None and area is None:
        return None
    if gauge_length is None or area is None:
        missing = "gauge_length" if gauge_length is None else "area"
        raise ParameterError(f"`{missing}`: a bar has a `gauge_length` and an `area`; give both")
    if given := [name for name, size in tip.items() if size is not None]:
        raise ParameterError(
            f"`{given[0]}` is of a tip, `gauge_length` and `area` are of a bar: leave one out"
        )
    return UniformBar(gauge_length[0], area[0], gauge_length[1], area[1])


def _take_tip(indenter: Shape, size: float, poisson: float, layer: float | None) -> Indenter:
    """Return the tip that is stated.

    Raises
    ------
    ParameterError
        If Poisson's ratio is none, or a layer is stated for which no law is known.
    """
    if poisson > INCOMPRESSIBLE:
        raise ParameterError(f"`poisson` is {poisson:g}; give Poisson's ratio, from 0 to 0.5")
    if layer and indenter != "sphere":
        raise ParameterError("`layer`: its law is known under a sphere only; leave `layer` out")
    if layer and poisson != INCOMPRESSIBLE:
        raise ParameterError("`layer`: its law is known for a `poisson` of 0.5; leave `layer` out")
    return Indenter(indenter, size, poisson, layer or math.inf)


def _check_stiffness(found: FittedModel) -> None:
    """Refuse a model that has no stiffness after a long hold."""
    if found.composition.tissue == "maxwell":
        raise ParameterError(
            "`model` is maxwell tissue, which flows: after a long hold it has no stiffness, and so "
            "no modulus; fit another `tissue`"
        )
    if not found.values.get("stiffness", 0.0) > 0.0:
        raise ParameterError("`model` has no stiffness above 0: fit it first")


def _check_law(composition: Composition) -> None:
    """Refuse a model whose stiffness is not that of a straight spring, or of Hertz's law alone."""
    if composition.without(HERTZ).has_curved_spring:
        raise ParameterError(
            "`model` has an effect by which its spring is curved in a way that is no law of a tip: "
            f"{', '.join(_name_curved(composition))}; fit a model with {HERTZ} in its place"
        )


def _name_curved(composition: Composition) -> list[str]:
    others = (each for each in composition.all_effects if each.name != HERTZ)
    return [each.name for each in others if Composition(effects=(each,)).has_curved_spring]


def _size(shape: Shape, radius: float | None, half_angle: float | None) -> float:
    """Return the number that tells the size of a tip [m, rad]."""
    sizes = {"radius": radius, "half_angle": half_angle}
    name, other = ("half_angle", "radius") if shape == "cone" else ("radius", "half_angle")
    given = sizes[name]
    if given is None:
        raise ParameterError(f"`indenter` {shape} needs `{name}`: give it")
    if sizes[other] is not None:
        raise ParameterError(f"`indenter` {shape} has no `{other}`: leave it out")
    return math.radians(given) if shape == "cone" else given


def _apply_power_law(found: FittedModel, tip: Indenter, depth: float | None) -> Modulus:
    """Return the modulus by the force of a power law at a depth, from the touch on."""
    n, k = found.values[EXPONENT_NAME], found.values["stiffness"]
    reference = REFERENCE_DEPTH * found.composition.scale.length
    own = DEPTH_POWERS[tip.shape]
    same = abs(n - own) <= POWER_TOLERANCE and math.isinf(tip.layer)
    if depth is None and not same:
        raise ParameterError(
            f"`depth`: the force grows as depth^{n:.2f}, and not as under this tip, so that the "
            "modulus differs with the depth: give one"
        )
    at = reference if depth is None else depth
    force = k * reference * (at / reference) ** n
    by_exponent = found.deviations.get(EXPONENT_NAME, 0.0) * math.log(at / reference)
    relative = math.hypot(_deviation(found) / k, by_exponent)
    notes = (*_report_unknown(relative), *_notes(tip, at))
    if by_exponent and not math.isnan(relative):
        notes += (
            f"The errors of stiffness and {EXPONENT_NAME} are taken as independent: a model file "
            "does not tell how they go together.",
        )
    if abs(n - own) > POWER_TOLERANCE:
        notes += (
            f"The force grows as depth^{n:.2f}, under a {tip.shape} on a half space as "
            f"depth^{own:g}: the modulus holds at this depth only.",
        )
    value = force / tip.force(at)
    told = math.nan if depth is None else at
    return Modulus(value, value * relative, told, notes)


def _straight(found: FittedModel, tip: Indenter, depth: float | None) -> Modulus:
    """Return the modulus by the slope of the force, which is the stiffness."""
    if depth is None and tip.shape != "flat":
        raise ParameterError(
            f"`depth`: the stiffness under a {tip.shape} grows with the depth, and the model is "
            "straight: give the depth from the touch at which the tip moved"
        )
    at = REFERENCE_DEPTH if depth is None else depth
    slope = tip.slope(at)
    told = math.nan if tip.shape == "flat" else at
    k, deviation = found.values["stiffness"], _deviation(found)
    notes = (*_report_unknown(deviation), *_notes(tip, at))
    return Modulus(k / slope, deviation / slope, told, notes)


def _deviation(found: FittedModel) -> float:
    """Return the standard deviation of the stiffness [N/m]; NaN where it was given, not fitted."""
    return found.deviations.get("stiffness", 0.0) or math.nan


def _report_unknown(deviation: float) -> tuple[str, ...]:
    """Say where a model does not tell how well its stiffness is known."""
    if math.isnan(deviation):
        return (NO_DEVIATION,)
    return ()


def _notes(tip: Indenter, depth: float) -> tuple[str, ...]:
    """Say where the laws of a half space or a layer are stretched."""
    if tip.chi(depth) > THINNEST:
        return (
            f"The contact is {tip.chi(depth):.2g} times as wide as the layer is high: the law of a "
            "thin layer is known up to 1.",
        )
    if tip.shape == "sphere" and depth > 0.4 * tip.size:
        return ("The tip is deeper than 0.4 of its radius: Hertz's law is for less.",)
    return ()
