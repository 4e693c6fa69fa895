"""The force channel is late."""

import sympy as sp

from tissue_probe.physics.effects.effect import Effect, Parameter

DELAY = sp.Symbol("channel_delay", real=True)

CHANNEL_DELAY = Effect(
    name="channel_delay",
    family="timing",
    physics="The force comes later than the position by a constant time",
    parameters=(Parameter(DELAY, "s", default=5e-4, lower=-5e-3, upper=5e-3),),
    delay=DELAY,
    assumptions="Constant; what the delay moves is time-invariant",
    reference="Oppenheim and Willsky, Signals and Systems (1997), section 4.3.2",
)
