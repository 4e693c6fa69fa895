"""The force channel is filtered: a first-order lag."""

import sympy as sp

from tissue_probe.physics.effects.effect import FORCE, Effect, Parameter, State
from tissue_probe.physics.extent import Extent

LAG_TIME = sp.Symbol("lag_time", real=True)
LAGGED_FORCE = sp.Symbol("lagged_force", real=True)
# Of a shorter lag only what is of first order in it is simulated: the rest cannot be seen at any
# sample rate, and the filter's own motion would ask for very short steps.
SHORTEST_LAG = 4e-5


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose lags from a fraction of a millisecond up."""
    return [{"lag_time": lag} for lag in (2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2)]


# A low-pass of time constant tau reads F - tau F'_lagged: exactly F where tau is 0.
_RATE = (FORCE - LAGGED_FORCE) / sp.Max(LAG_TIME, SHORTEST_LAG)

FORCE_LAG = Effect(
    name="force_lag",
    family="timing",
    physics="The force passes a first-order low-pass of time constant tau",
    says="the force lags by {lag_time:s}",
    parameters=(Parameter(LAG_TIME, "s", default=1e-3, lower=0.0, upper=1.0),),
    output=FORCE - LAG_TIME * _RATE,
    states=(State(LAGGED_FORCE, _RATE, start=FORCE, spread="none"),),
    starts=starts,
    assumptions="First order; the position channel has no such filter",
    reference="Doebelin, Measurement Systems (2004), section 3.3, on first-order instruments",
)
