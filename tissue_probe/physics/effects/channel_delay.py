"""The force channel is late."""

import sympy as sp

from tissue_probe.physics.effects.effect import Effect, Parameter
from tissue_probe.physics.extent import Extent
from tissue_probe.physics.kinds import LONGEST_DELAY, MOST_EARLY

CHANNEL_LATENESS = sp.Symbol("channel_delay", real=True)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose delays of either sign, and again with a damping that is one.

    Under a steady sine a late force looks like less damping, or less than none, from where a search
    for the delay does not come back.
    """
    delays = (0.0, 2e-3, 5e-3, 1e-2, -2e-3)
    return [
        *({"channel_delay": delay} for delay in delays),
        *({"channel_delay": delay, "damping": 5.0} for delay in delays[1:4]),
    ]


CHANNEL_DELAY = Effect(
    name="channel_delay",
    family="timing",
    physics="The force comes later than the position by a constant time",
    says="the force comes {channel_delay:s} after the position",
    parameters=(
        Parameter(CHANNEL_LATENESS, "s", default=5e-4, lower=-MOST_EARLY, upper=LONGEST_DELAY),
    ),
    delay=CHANNEL_LATENESS,
    starts=starts,
    assumptions="Constant; what the delay moves is time-invariant",
    reference="Oppenheim and Willsky, Signals and Systems (1997), section 4.3.2",
)
