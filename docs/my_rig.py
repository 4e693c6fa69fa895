"""A rig of one's own: a known force moves a platform, and a leaf spring carries the tip on it.

    M p'' = F - ks (p - z - x) - bs (p' - x')                            (platform)
    m x'' = ks (p - z - x) + bs (p' - x') - k x - beta x' - effects      (tip)

F drives, the platform's position p is measured, and z is where the tip touches. Use it with
``tp.diagnose(measured, rig=PLATFORM)``; copy and change it for another.
"""

import sympy as sp

from tissue_probe import quantities
from tissue_probe.physics.effects.effect import FORCE, POSITION, TIP_VELOCITY, State
from tissue_probe.physics.entry import Entry
from tissue_probe.physics.rigs import Constant, Rig
from tissue_probe.physics.rigs.composing import (
    MASS,
    TIP_POSITION,
    Pressed,
    composed,
    driven_by_force,
    pushed,
)
from tissue_probe.physics.rigs.constants import DRIVEN_MASS, TOUCH

PLACE, SPEED = sp.symbols("platform_position platform_speed", real=True)
HEAVY, SPRING, DAMPER = sp.symbols("platform_mass spring_stiffness spring_damping", positive=True)


def equations(effects, tissue, zero):
    """Return the model: its states, its input, its output."""
    x, v = TIP_POSITION, TIP_VELOCITY
    pressed = Pressed(effects, tissue, x, v)
    force, spring = pushed(effects), SPRING * (PLACE - zero - x) + DAMPER * (SPEED - v)
    net = spring - pressed.force - pressed.drag
    states = [
        *pressed.tip(net, MASS, start=POSITION - zero - FORCE / SPRING),
        State(PLACE, SPEED, start=POSITION, spread="free"),
        State(SPEED, (force - spring) / HEAVY, spread="speed"),
    ]
    constants = (MASS, HEAVY, SPRING, DAMPER)
    return driven_by_force(composed(pressed, constants, states, load=force, net=net), PLACE)


PLATFORM = Rig(
    name="platform",
    summary="A known force moves a platform, whose position is measured; a spring carries the tip",
    whose="for a platform with a tip on a leaf spring",
    equations=equations,
    input=quantities.FORCE,
    constants=(
        Constant(DRIVEN_MASS, 0.02, 0.0002),
        Constant(Entry("platform_mass", "kg", 0.05, lower=1e-6, upper=1e4), 0.05, 0.0005),
        Constant(Entry("spring_stiffness", "N/m", 3000.0, lower=1.0, upper=1e8), 3000.0, 45.0),
        Constant(Entry("spring_damping", "N s/m", 0.3, lower=0.0, upper=1e4), 0.3, 0.06),
        TOUCH,
    ),
)
