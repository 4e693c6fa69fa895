"""Rigs: how an instrument couples to tissue and to further effects.

What belongs here: one function a rig, which composes its ``Model``; what drives it, what answers.
What does not: what a tissue or an effect is (``tissues``, ``effects``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import sympy as sp

from tissue_probe import quantities
from tissue_probe.physics.effects.effect import (
    DAMPING,
    ELASTIC_DEPTH,
    FORCE,
    INDENTATION,
    NET_FORCE,
    POSITION,
    POSITION_ACCELERATION,
    POSITION_RATE,
    STIFFNESS,
    STRETCH,
    TIP_VELOCITY,
    TISSUE_FORCE,
    Effect,
    State,
    Switch,
)
from tissue_probe.physics.kinds import SIGNALS
from tissue_probe.physics.model import Model
from tissue_probe.physics.tissues import TISSUES, Tissue
from tissue_probe.quantities import Quantity

OFFSET, TIP_POSITION = sp.symbols("force_offset tip_position", real=True)
MASS, CELL_STIFFNESS, CELL_DAMPING = sp.symbols(
    "tip_mass load_cell_stiffness load_cell_damping", positive=True
)
CONTACT = sp.Symbol("contact_position", real=True)
FORCE_RATE, FORCE_CURVATURE = sp.symbols("force_rate force_curvature", real=True)
KELVIN_VOIGT = TISSUES["kelvin_voigt"]


def compliant_probe(
    effects: Sequence[Effect] = (),
    force_offset: bool = False,
    tissue: Tissue = KELVIN_VOIGT,
    contact_position: bool = False,
) -> Model:
    """Tip on a load cell that yields, driven by a coil of known displacement (paper, fig. 1).

        m x'' = k0 (u - x) + beta0 (u' - x') - k x - beta x' - effects   (paper, eq. 1)
        F = k0 (u - x) + d                                               (paper, eq. 2)

    Eq. 1 is printed without its dots; F is positive in compression, the opposite of eq. 2. The
    constant d (with ``force_offset``) is the load cell's zero error, and equally a contact point
    that lies elsewhere than at x = 0: both shift the force by a constant, and neither the motion.

    Parameters
    ----------
    effects : sequence of Effect
        Further physics, applied in this order where the order matters.
    force_offset : bool
        Whether the constant force d [N] is a parameter to be estimated; 0 otherwise.
    tissue : Tissue
        What the tip presses on.
    contact_position : bool
        Whether the position of the coil at which the tip touches [m] is a constant; 0 otherwise.
    """
    x, v = TIP_POSITION, TIP_VELOCITY
    m, k0, beta0 = MASS, CELL_STIFFNESS, CELL_DAMPING
    zero = CONTACT if contact_position else sp.Integer(0)
    u, du = reduce(_through, effects, (POSITION, POSITION_RATE))
    stretch = u - zero - x
    load = k0 * sp.prod(e.cell for e in effects) * _stretched(effects, stretch)
    grip = beta0 * (du - v) * sp.prod(e.engaged for e in effects)
    pressed = _Pressed(effects, tissue, x, v)
    net = load + grip - pressed.force - pressed.drag
    states = [
        State(x, v * pressed.moving, start=POSITION - zero - FORCE / k0, spread="free"),
        State(v, pressed.moving * net / (m + pressed.inertia), spread="speed"),
    ]
    return _compose(
        effects,
        force_offset,
        constants=(m, k0, beta0, *([CONTACT] if contact_position else [])),
        states=states,
        pressed=pressed,
        stretch=stretch,
        net=net,
        load=load,
        # The coil feels what it moves: nothing, while play is between it and the load cell.
        reaction=(load + grip) * sp.diff(du, POSITION_RATE),
    )


def rigid_probe(
    effects: Sequence[Effect] = (),
    force_offset: bool = False,
    tissue: Tissue = KELVIN_VOIGT,
    contact_position: bool = False,
) -> Model:
    """Tip that follows a known displacement exactly: a stiff load cell, an AFM, a robot's arm.

        F = m u'' + k u + beta u' + effects + d

    Parameters as for ``compliant_probe``. What an effect says of the load cell's spring has no
    meaning here, and is refused.

    Raises
    ------
    ValueError
        If an effect acts on the spring of the load cell.
    """
    _refuse("rigid_probe", effects)
    zero = CONTACT if contact_position else sp.Integer(0)
    u, du = reduce(_through, effects, (POSITION, POSITION_RATE))
    pressed = _Pressed(effects, tissue, u - zero, du)
    load = (MASS + pressed.inertia) * POSITION_ACCELERATION + pressed.force + pressed.drag
    return _compose(
        effects,
        force_offset,
        constants=(MASS, *([CONTACT] if contact_position else [])),
        states=[],
        pressed=pressed,
        stretch=sp.Integer(0),
        # The coil leads the tip whatever resists: friction never holds it, and turns as it turns.
        net=sp.Integer(0),
        load=load,
        reaction=load,
    )


def force_driven(
    effects: Sequence[Effect] = (),
    tissue: Tissue = KELVIN_VOIGT,
    contact_position: bool = False,
) -> Model:
    """Tip on which a known force acts, its position measured: a voice coil, a shaker.

        m x'' = F - k x - beta x' - effects,    position = x + contact_position

    F is what was measured of the force, positive into the tissue as a load cell's in compression;
    what effects say of its channel (a gain g, a bias b: measured = g true + b) is undone first.

    Parameters as for ``compliant_probe``, without a constant force: F is given.

    Raises
    ------
    ValueError
        If an effect acts on what this rig has not.
    """
    _refuse("force_driven", effects)
    x, v = TIP_POSITION, TIP_VELOCITY
    zero = CONTACT if contact_position else sp.Integer(0)
    pressed = _Pressed(effects, tissue, x, v)
    read = reduce(lambda force, effect: effect.output.subs(FORCE, force), effects, FORCE)
    pushed = (FORCE - read.subs(FORCE, 0)) / read.diff(FORCE)
    net = pushed - pressed.force - pressed.drag
    states = [
        State(x, v * pressed.moving, start=POSITION - zero, spread="free"),
        State(v, pressed.moving * net / (MASS + pressed.inertia), spread="speed"),
    ]
    composed = _compose(
        effects,
        force_offset=False,
        constants=(MASS, *([CONTACT] if contact_position else [])),
        states=states,
        pressed=pressed,
        stretch=sp.Integer(0),
        net=net,
        load=pushed,
        reaction=pushed,
    )
    return replace(
        composed,
        input=FORCE,
        input_rate=FORCE_RATE,
        input_curvature=FORCE_CURVATURE,
        output=x + zero,
        # A force that comes late answers nothing: the position seems early.
        delay=-composed.delay,
    )


@dataclass(frozen=True)
class Rig:
    """An instrument: its equations, the signal that drives it, and the one that is predicted."""

    compose: Callable[..., Model]
    input: Quantity
    output: Quantity


RIGS = {
    compose.__name__: Rig(compose, *SIGNALS[compose.__name__])
    for compose in (compliant_probe, rigid_probe, force_driven)
}


def admits(rig: str, effect: Effect) -> bool:
    """Whether a rig has what an effect acts on."""
    return not obstacle(rig, effect)


def obstacle(rig: str, effect: Effect) -> str:
    """Say why an effect has no meaning for a rig, as what it does; empty where it has one."""
    if rig != "compliant_probe" and (effect.cell, effect.stretch, effect.engaged) != (
        1,
        STRETCH,
        1,
    ):
        return f"acts on the load cell's spring, and {rig} has none"
    if RIGS[rig].input is quantities.POSITION:
        return ""
    coil = (effect.coil, effect.position, effect.rounded)
    if coil != ((POSITION, POSITION_RATE), POSITION, 0):
        return f"acts on a position that drives the tip, and in {rig} a force does"
    slope, own = effect.output.diff(FORCE), {state.symbol for state in effect.states}
    if slope == 0 or slope.has(FORCE) or not own.isdisjoint(effect.output.free_symbols):
        return f"distorts the force in a way that cannot be undone, and in {rig} the force drives"
    return ""


def _refuse(rig: str, effects: Sequence[Effect]) -> None:
    for effect in effects:
        if told := obstacle(rig, effect):
            raise ValueError(f"{effect.name} {told}; leave it out, or choose another rig")


class _Pressed:
    """The forces on a tip at ``x`` with velocity ``v``, and what its mass is increased by."""

    def __init__(self, effects: Sequence[Effect], tissue: Tissue, x: sp.Expr, v: sp.Expr) -> None:
        self.tissue = tissue
        self.space = {INDENTATION: x, TIP_VELOCITY: v}
        self.place = {
            INDENTATION: x - sum(effect.surface[0] for effect in effects),
            TIP_VELOCITY: v - sum(effect.surface[1] for effect in effects),
        }
        whole = tissue.force + sum(effect.force for effect in effects)
        self.bonded = self.at(sp.sympify(whole).subs(ELASTIC_DEPTH, _elastic_depth(effects)))
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

    def at(self, expression: sp.Expr) -> sp.Expr:
        """Put the tip's indentation and velocity into an expression."""
        return sp.sympify(expression).subs(self.place, simultaneous=True)

    def in_space(self, expression: sp.Expr) -> sp.Expr:
        """Put the tip's displacement and velocity into it, wherever the tissue's surface is."""
        return sp.sympify(expression).subs(self.space, simultaneous=True)

    def seen_by(self, effect: Effect) -> Callable[[sp.Expr], sp.Expr]:
        """Return what an effect means by them: what drags the tip knows nothing of a surface."""
        return self.at if effect.drag == 0 else self.in_space


def _compose(
    effects: Sequence[Effect],
    force_offset: bool,
    constants: tuple[sp.Symbol, ...],
    states: list[State],
    pressed: _Pressed,
    stretch: sp.Expr,
    net: sp.Expr,
    load: sp.Expr,
    reaction: sp.Expr,
) -> Model:
    """Pass the load through the effects' outputs, gather their states, switches, parameters."""
    begin = [*states, *(_placed(state, pressed, pressed.at) for state in pressed.tissue.states)]
    output = load
    for effect in effects:
        for state in effect.states:
            placed = _placed(state, pressed, pressed.seen_by(effect))
            begin.append(State(placed.symbol, placed.motion.subs(FORCE, output), *_rest(state)))
        output = effect.output.subs(FORCE, output)
    switches: dict[sp.Symbol, Switch] = {}
    at = {TISSUE_FORCE: pressed.bonded, STRETCH: stretch, NET_FORCE: net}
    for effect in effects:
        for switch in effect.switches:
            place = pressed.seen_by(effect)
            switches[switch.symbol] = replace(
                switch,
                on=place(switch.on).subs(at),
                off=place(switch.off).subs(at),
                alone=None if switch.alone is None else place(switch.alone),
            )
    offset = [OFFSET] if force_offset else []
    own = [entry.symbol for effect in effects for entry in effect.parameters]
    return Model(
        # With its shape, which an empty list (a rigid probe moves by itself nothing) does not tell.
        states=sp.Matrix(len(begin), 1, [state.symbol for state in begin]),
        parameters=sp.Matrix([STIFFNESS, DAMPING, *offset, *own]),
        constants=constants,
        input=POSITION,
        input_rate=POSITION_RATE,
        motion=sp.Matrix(len(begin), 1, [state.motion for state in begin]),
        output=output + sum(offset),
        begin=tuple(begin),
        switches=tuple(switches.values()),
        position=reduce(lambda p, e: e.position.subs(POSITION, p), effects, POSITION),
        delay=sum((effect.delay for effect in effects), sp.Integer(0)),
        rounded=sum((effect.rounded for effect in effects), sp.Integer(0)),
        reaction=reaction,
    )


def _rest(state: State) -> tuple[sp.Expr, str]:
    return state.start, state.spread


def _placed(state: State, pressed: _Pressed, at: Callable[[sp.Expr], sp.Expr]) -> State:
    """Give a state its motion under this tip: out of contact no surface follows it."""
    motion = sp.sympify(state.motion)
    if state.spread == "branch":
        motion = motion.subs(TIP_VELOCITY, TIP_VELOCITY * pressed.touching)
    return State(state.symbol, at(motion), *_rest(state))


def _through(coil: tuple[sp.Expr, sp.Expr], effect: Effect) -> tuple[sp.Expr, sp.Expr]:
    at = {POSITION: coil[0], POSITION_RATE: coil[1]}
    return tuple(side.subs(at, simultaneous=True) for side in effect.coil)


def _elastic_depth(effects: Sequence[Effect]) -> sp.Expr:
    """Return the force that indentation alone gives, over the stiffness [m]."""
    forces = [sp.sympify(effect.force) for effect in effects]
    values = {entry.symbol for effect in effects for entry in effect.parameters}
    known = {INDENTATION, STIFFNESS, *values}
    return INDENTATION + sum(f / STIFFNESS for f in forces if f.free_symbols <= known)


def _stretched(effects: Sequence[Effect], stretch: sp.Expr) -> sp.Expr:
    for effect in effects:
        stretch = effect.stretch.subs(STRETCH, stretch)
    return stretch
