"""The common part of rigs' equations: the forces on a tip, and how effects act around it.

Contents: symbols of rigs, tissue and effects under a tip, and a ``Model`` made of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import reduce

import sympy as sp

from tissue_probe.physics.effects.effect import (
    DAMPING,
    ELASTIC_DEPTH,
    ELASTIC_RATE,
    FORCE,
    INDENTATION,
    NET_FORCE,
    POSITION,
    POSITION_RATE,
    STIFFNESS,
    STRETCH,
    TIP_VELOCITY,
    TISSUE_FORCE,
    Effect,
    State,
    Switch,
)
from tissue_probe.physics.model import Model
from tissue_probe.physics.tissues import Tissue

OFFSET, TIP_POSITION = sp.symbols("force_offset tip_position", real=True)
MASS, CELL_STIFFNESS, CELL_DAMPING = sp.symbols(
    "tip_mass load_cell_stiffness load_cell_damping", positive=True
)
CONTACT = sp.Symbol("contact_position", real=True)
FORCE_RATE, FORCE_CURVATURE = sp.symbols("force_rate force_curvature", real=True)
#: The position at which the tip touches, where that is no constant.
NOWHERE = sp.Integer(0)


class Pressed:
    """The forces on a tip, and the increase of its mass.

    Parameters
    ----------
    effects : sequence of Effect
        Further physics, in the order in which it is applied.
    tissue : Tissue
        The tissue that the tip presses on.
    x, v : Expr
        Displacement [m] of the tip from where it touches, and its velocity [m/s].
    """

    def __init__(self, effects: Sequence[Effect], tissue: Tissue, x: sp.Expr, v: sp.Expr) -> None:
        self.effects, self.tissue = effects, tissue
        self.space = {INDENTATION: x, TIP_VELOCITY: v}
        self.place = {
            INDENTATION: x - sum(effect.surface[0] for effect in effects),
            TIP_VELOCITY: v - sum(effect.surface[1] for effect in effects),
        }
        whole = tissue.force + sum(effect.force for effect in effects)
        depth = elastic_depth(effects)
        self.bonded = self.at(sp.sympify(whole).subs(ELASTIC_DEPTH, depth))
        #: How fast the spring's force over its stiffness changes [m/s], of the tip's motion.
        self.elastic_rate = depth.diff(INDENTATION) * TIP_VELOCITY
        self.force = self.bonded
        for effect in effects:
            self.force = self.at(effect.contact).subs(TISSUE_FORCE, self.force)
        #: Whether (1, 0) the tip touches the tissue, of switches; 1 where none of them says so.
        held = sp.sympify(sp.prod(effect.contact.diff(TISSUE_FORCE) for effect in effects))
        known = {switch.symbol for effect in effects for switch in effect.switches}
        self.touching = held if held.free_symbols <= known else sp.Integer(1)
        self.drag = self.in_space(sum(effect.drag for effect in effects))
        self.inertia = sum(effect.inertia for effect in effects)
        self.moving = sp.prod(effect.moving for effect in effects)

    def tip(self, net: sp.Expr, mass: sp.Expr, start: sp.Expr) -> list[State]:
        """Return position and velocity of a tip that moves by itself.

        Parameters
        ----------
        net : Expr
            Sum of all forces on it [N], positive into the tissue.
        mass : Expr
            Its own [kg].
        start : Expr
            Where it is at rest [m], of ``POSITION`` and ``FORCE`` as measured.
        """
        x, v = TIP_POSITION, TIP_VELOCITY
        return [
            State(x, v * self.moving, start=start, spread="free"),
            State(v, self.moving * net / (mass + self.inertia), spread="speed"),
        ]

    def at(self, expression: sp.Expr) -> sp.Expr:
        """Put the tip's indentation and velocity into an expression."""
        return sp.sympify(expression).subs(self.place, simultaneous=True)

    def in_space(self, expression: sp.Expr) -> sp.Expr:
        """Put the tip's displacement and velocity into it, wherever the tissue's surface is."""
        return sp.sympify(expression).subs(self.space, simultaneous=True)

    def view_for(self, effect: Effect) -> Callable[[sp.Expr], sp.Expr]:
        """Return an effect's meaning of them: a drag on the tip knows nothing of a surface."""
        return self.at if effect.drag == 0 else self.in_space


def composed(
    pressed: Pressed,
    constants: Sequence[sp.Symbol],
    states: Sequence[State],
    load: sp.Expr,
    net: sp.Expr = sp.S.Zero,
    stretch: sp.Expr = sp.S.Zero,
    reaction: sp.Expr | None = None,
) -> Model:
    """Pass the load through the effects' outputs, gather their states, switches, parameters.

    Parameters
    ----------
    pressed : Pressed
        The tip, with tissue and effects.
    constants : sequence of Symbol
        Of the rig, but where it touches.
    states : sequence of State
        Its states: position and velocity of the tip first.
    load : Expr
        Force of the load cell, or the force that drives [N], positive in compression.
    net : Expr
        Sum of all forces on the tip [N]; 0 where it is led.
    stretch : Expr
        Compression of the load cell's spring [m].
    reaction : Expr, optional
        Force on the coil [N]; the load by default.
    """
    effects = pressed.effects
    begin = [*states, *(_placed(state, pressed, pressed.at) for state in pressed.tissue.states)]
    output = load
    for effect in effects:
        for state in effect.states:
            placed = _placed(state, pressed, pressed.view_for(effect))
            begin.append(State(placed.symbol, placed.motion.subs(FORCE, output), *_rest(state)))
        output = effect.output.subs(FORCE, output)
    switches: dict[sp.Symbol, Switch] = {}
    at = {TISSUE_FORCE: pressed.bonded, STRETCH: stretch, NET_FORCE: net}
    for effect in effects:
        for switch in effect.switches:
            place = pressed.view_for(effect)
            switches[switch.symbol] = replace(
                switch,
                on=place(switch.on).subs(at),
                off=place(switch.off).subs(at),
                alone=None if switch.alone is None else place(switch.alone),
            )
    own = [entry.symbol for effect in effects for entry in effect.parameters]
    return Model(
        # With its shape, which an empty list (a rigid probe moves by itself nothing) does not tell.
        states=sp.Matrix(len(begin), 1, [state.symbol for state in begin]),
        parameters=sp.Matrix([STIFFNESS, DAMPING, *own]),
        constants=tuple(constants),
        input=POSITION,
        input_rate=POSITION_RATE,
        motion=sp.Matrix(len(begin), 1, [state.motion for state in begin]),
        output=output,
        begin=tuple(begin),
        switches=tuple(switches.values()),
        position=reduce(lambda p, e: e.position.subs(POSITION, p), effects, POSITION),
        delay=sum((effect.delay for effect in effects), sp.Integer(0)),
        rounded=sum((effect.rounded for effect in effects), sp.Integer(0)),
        reaction=load if reaction is None else reaction,
    )


def with_offset(model: Model) -> Model:
    """Return a model that predicts a force with a constant error of it, which is estimated [N]."""
    stiffness, damping, *own = model.parameters
    return replace(
        model,
        parameters=sp.Matrix([stiffness, damping, OFFSET, *own]),
        output=model.output + OFFSET,
    )


def through(coil: tuple[sp.Expr, sp.Expr], effect: Effect) -> tuple[sp.Expr, sp.Expr]:
    """Return position and speed at the load cell's end, of those before an effect [m, m/s]."""
    at = {POSITION: coil[0], POSITION_RATE: coil[1]}
    return tuple(side.subs(at, simultaneous=True) for side in effect.coil)


def stretched(effects: Sequence[Effect], stretch: sp.Expr) -> sp.Expr:
    """Return a compression of the load cell's spring after its effects [m]."""
    for effect in effects:
        stretch = effect.stretch.subs(STRETCH, stretch)
    return stretch


def pushed(effects: Sequence[Effect]) -> sp.Expr:
    """Return the force that drives [N], of ``FORCE``, the measured one.

    Effects on its channel (a gain g, a bias b: measured = g true + b) are undone.
    """
    read = reduce(lambda force, effect: effect.output.subs(FORCE, force), effects, FORCE)
    return (FORCE - read.subs(FORCE, 0)) / read.diff(FORCE)


def driven_by_force(model: Model, position: sp.Expr) -> Model:
    """Return a composed model in which ``pushed`` drives, and a position [m] is measured."""
    return replace(
        model,
        input=FORCE,
        input_rate=FORCE_RATE,
        input_curvature=FORCE_CURVATURE,
        output=position,
        # A force that comes late answers nothing: the position seems early.
        delay=-model.delay,
    )


def _rest(state: State) -> tuple[sp.Expr, str]:
    return state.start, state.spread


def _placed(state: State, pressed: Pressed, at: Callable[[sp.Expr], sp.Expr]) -> State:
    """Give a state its motion under this tip: out of contact no surface follows it."""
    motion = sp.sympify(state.motion).subs(ELASTIC_RATE, pressed.elastic_rate)
    if state.spread == "branch":
        motion = motion.subs(TIP_VELOCITY, TIP_VELOCITY * pressed.touching)
    return State(state.symbol, at(motion), *_rest(state))


def elastic_depth(effects: Sequence[Effect]) -> sp.Expr:
    """Return the force that indentation alone gives, over the stiffness [m]."""
    forces = [sp.sympify(effect.force) for effect in effects]
    values = {entry.symbol for effect in effects for entry in effect.parameters}
    known = {INDENTATION, STIFFNESS, *values}
    return INDENTATION + sum(f / STIFFNESS for f in forces if f.free_symbols <= known)
