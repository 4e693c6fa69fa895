"""Lost motion between the coil and the load cell."""

from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.effects.effect import (
    POSITION,
    POSITION_BEFORE,
    POSITION_RATE,
    STRETCH,
    Effect,
    Parameter,
    State,
    Switch,
)
from tissue_probe.physics.extent import Extent

WIDTH = sp.Symbol("backlash_width", real=True)
PUSHES, PULLS = sp.symbols("pushes pulls", nonnegative=True)
FOLLOWER = sp.Symbol("follower_position", real=True)
#: A play that stays taken up on one side shifts the force.
SIMPLER = ("force_bias",)
_PARAMETERS = (Parameter(WIDTH, "m", default=3e-5, lower=0.0, upper=2e-3),)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose widths up to a third of the indentation."""
    return [{"backlash_width": extent.indentation * f} for f in (0.003, 0.01, 0.03, 0.1, 0.3)]


def near(extent: Extent, values: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose widths around the one found: a flank that is taken up in another cycle is a jump."""
    return [{"backlash_width": values["backlash_width"] * f} for f in (0.5, 0.7, 1.4, 2.0)]


_SAYS = "a play of {backlash_width:m}"

_COUPLING = Effect(
    name="backlash",
    family="lost motion",
    physics="A gap in the coupling: no force while coil and tip are within its width",
    says=_SAYS,
    parameters=_PARAMETERS,
    stretch=(STRETCH - WIDTH / 2) * PUSHES + (STRETCH + WIDTH / 2) * PULLS,
    engaged=PUSHES + PULLS,
    switches=(
        Switch(PUSHES, STRETCH - WIDTH / 2, WIDTH / 2 - STRETCH, first=False),
        Switch(PULLS, -STRETCH - WIDTH / 2, STRETCH + WIDTH / 2, first=False),
    ),
    starts=starts,
    near=near,
    simpler=SIMPLER,
)
BACKLASH = Effect(
    name="backlash",
    family="lost motion",
    physics="Play in the drive: the load cell's end stands still until the play is taken up",
    says=_SAYS,
    parameters=_PARAMETERS,
    # The follower moves with the coil while one flank or the other is in touch.
    coil=(FOLLOWER, POSITION_RATE * (PUSHES + PULLS)),
    sampled=sp.Max(sp.Min(POSITION_BEFORE, POSITION + WIDTH / 2), POSITION - WIDTH / 2),
    states=(State(FOLLOWER, POSITION_RATE * (PUSHES + PULLS), start=POSITION),),
    # A flank touches only while the coil moves towards it, so that no play is no effect.
    switches=(
        Switch(
            PUSHES,
            POSITION_RATE,
            sp.Max(FOLLOWER + WIDTH / 2 - POSITION, -POSITION_RATE),
            first=False,
        ),
        Switch(
            PULLS,
            -POSITION_RATE,
            sp.Max(POSITION - FOLLOWER + WIDTH / 2, POSITION_RATE),
            first=False,
        ),
    ),
    starts=starts,
    near=near,
    forms=(_COUPLING,),
    simpler=SIMPLER,
    assumptions="Friction holds the load cell's end while the play is taken up",
    reference="Nordin and Gutman, Automatica 38 (2002), 1633, sections 2 and 3",
)
