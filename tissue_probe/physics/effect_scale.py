"""An effect's law in other units: as it is for a record that is not of the usual size.

Contents: turning all that an effect declares.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import sympy as sp

from tissue_probe.physics.composition import TISSUE, state_unit
from tissue_probe.physics.effects.effect import (
    DAMPING,
    ELASTIC_DEPTH,
    ELASTIC_RATE,
    FORCE,
    INDENTATION,
    INPUT2,
    NET_FORCE,
    POSITION,
    POSITION_ACCELERATION,
    POSITION_BEFORE,
    POSITION_RATE,
    STIFFNESS,
    STRETCH,
    TIME,
    TIP_VELOCITY,
    TISSUE_FORCE,
    Effect,
    State,
    Switch,
)
from tissue_probe.physics.extent import Extent
from tissue_probe.physics.rigs import CONSTANTS
from tissue_probe.physics.scale import Scale

#: Units of the signals that stand in effects and in their starts and conditions.
_SIGNALS = {
    TIME: "s",
    INPUT2: "input2",
    **dict.fromkeys((POSITION, POSITION_BEFORE, INDENTATION, STRETCH, ELASTIC_DEPTH), "m"),
    **dict.fromkeys((POSITION_RATE, TIP_VELOCITY, ELASTIC_RATE), "m/s"),
    POSITION_ACCELERATION: "m/s^2",
    STIFFNESS: "N/m",
    DAMPING: "N s/m",
    **dict.fromkeys((TISSUE_FORCE, FORCE, NET_FORCE), "N"),
}
_ACTS = {
    **dict.fromkeys(("force", "contact", "drag", "output"), "N"),
    **dict.fromkeys(("stretch", "position", "rounded"), "m"),
    **dict.fromkeys(("moving", "engaged", "cell"), "1"),
    "inertia": "kg",
    "delay": "s",
}
_WAYS = ("surface", "coil")
_TOLD = {entry.name: entry.unit for entry in (*CONSTANTS.values(), *TISSUE)}


@lru_cache(maxsize=1024)
def resize_effect(effect: Effect, scale: Scale) -> Effect:
    """Return an effect of the library for a record of a size: bounds, starts, constants alike.

    A depth of 1 mm that its law refers to is one of 1 um where lengths are in micrometres.

    Raises
    ------
    UnitError
        If a parameter's unit is not made of those known.
    """
    if scale.is_usual:
        return effect
    forms = tuple(resize_effect(form, scale) for form in effect.forms)
    return replace(over(effect, scale.inverse), forms=forms, origin=effect, scale=scale)


@lru_cache(maxsize=1024)
def over(effect: Effect, scale: Scale) -> Effect:
    """Return the same law, without its other forms, for numbers in the units of a scale."""
    units = {**_TOLD, **{each.name: each.unit for each in effect.parameters}}
    turn = _Turned(effect, scale)
    known = {name: scale.of(unit) for name, unit in units.items()}
    starts, near = effect.starts, effect.near
    strength = effect.parameters[0].unit if effect.parameters else "1"

    def reach(extent: Extent) -> Extent:
        return extent.over(scale.inverse)

    def told(proposals: Iterable[Mapping[str, float]]) -> list[dict[str, float]]:
        return [{name: each / known[name] for name, each in one.items()} for one in proposals]

    def found(values: Mapping[str, float]) -> dict[str, float]:
        return {name: each * known.get(name, 1.0) for name, each in values.items()}

    acts = {name: turn(getattr(effect, name), unit) for name, unit in _ACTS.items()}
    ways = {name: _way(turn, getattr(effect, name)) for name in _WAYS}
    changed: dict[str, Any] = acts | ways
    return replace(
        effect,
        **changed,
        parameters=tuple(
            replace(
                each,
                default=each.default / known[each.name],
                lower=each.lower / known[each.name],
                upper=each.upper / known[each.name],
            )
            for each in effect.parameters
        ),
        sampled=None if effect.sampled is None else turn(effect.sampled, "m"),
        states=tuple(turn.state(each) for each in effect.states),
        switches=tuple(turn.switch(each) for each in effect.switches),
        neutral=effect.neutral / scale.of(strength),
        starts=lambda extent: told(starts(reach(extent))),
        near=near and (lambda extent, values: told(near(reach(extent), found(values)))),
        forms=(),
    )


class _Turned:
    """Expressions of an effect in the units of a scale."""

    def __init__(self, effect: Effect, scale: Scale) -> None:
        own = {each.symbol: each.unit for each in effect.parameters}
        named = {str(symbol): unit for symbol, unit in own.items()}
        self._states = {each.symbol: state_unit(each.spread, named) for each in effect.states}
        self._scale = scale
        units = {**_SIGNALS, **own, **self._states}
        self._at = {symbol: self._factor(unit) * symbol for symbol, unit in units.items()}

    def __call__(self, expression: sp.Expr, unit: str) -> sp.Expr:
        """Convert an expression of a unit."""
        turned = sp.sympify(expression).xreplace(self._at)
        return turned / self._factor(unit)

    def state(self, state: State) -> State:
        """Turn where a state starts, and how it moves on."""
        unit = self._states[state.symbol]
        start, motion = self(state.start, unit), self(state.motion, f"{unit} /s")
        return replace(state, start=start, motion=motion)

    def switch(self, switch: Switch) -> Switch:
        """Turn a switch, of whose conditions only the sign counts."""
        alone = None if switch.alone is None else self(switch.alone, "1")
        return replace(switch, on=self(switch.on, "1"), off=self(switch.off, "1"), alone=alone)

    def _factor(self, unit: str) -> sp.Expr:
        """Return a factor without error: scales are powers of ten."""
        factor = self._scale.of(unit)
        power = round(math.log10(factor))
        return sp.Integer(10) ** power if math.isclose(factor, 10.0**power) else sp.Float(factor)


def _way(turn: _Turned, way: tuple[sp.Expr, sp.Expr]) -> tuple[sp.Expr, sp.Expr]:
    return turn(way[0], "m"), turn(way[1], "m/s")
