"""Constants of the rig that are known roughly, considered beside any of the Kalman filters.

A constant that is wrong is wrong in the same way in every sample: no noise of process or force may
stand for it. So the filter keeps its own covariance P and gain K, those of right constants; beside
them it keeps by how much the constants' errors shift its mean, and the estimate of these errors by
the innovations (B. Friedland, IEEE Trans. Automatic Control 14, 1969, "Treatment of bias in
recursive filtering"). With the errors in their standard deviations, estimated as d with covariance
L L^T (at first 0 and I), the joint covariance of mean and errors is

    [P + W W^T, W L^T; L W^T, L L^T],

that of the extended filter whose state is augmented by the constants, without process noise. W and
L are kept as one root [W; L], by J. E. Potter's update (R. H. Battin, Astronautical Guidance,
1964), so that no rounding makes it a covariance that no numbers have:

    prediction:  W <- F W + B L,                       B = df/dc sd
    force:       s = H W + D L,  S = H P H^T + R + s s^T,  D = dh/dc sd
    update:      W <- W - K s,  d <- d + L s^T nu / S,  X <- X + K nu + W s^T nu / S,
                 [W; L] <- [W; L] (I - s^T s / (S (1 + sqrt(1 - s s^T / S)))),
                 nu = y - h(X, c + sd d)

Its innovations are white, and so all tests of them hold as they are. What fades or is opened anew
is P, the tissue's: a rig does not change.

The first samples inform on all unknowns together, by tangents that are taken at a wild mean: false
information on the constants, which would never be forgotten. So the second-order terms of the tip's
motion are added to the process noise (``write_neglected_variance``), as in filters of the second
order (A. H. Jazwinski, Stochastic Processes and Filtering Theory, 1970). They vanish once the tip's
motion is known.

An error of the place of contact is a constant force: where that place is known roughly, the filter
estimates such a force, as ``robust_ekf`` does in any case.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tissue_probe.physics.rigs import RIGS, Live
from tissue_probe.physics.rigs.constants import CONTACT_POSITION

if TYPE_CHECKING:
    from collections.abc import Sequence

    import sympy as sp

    from tissue_probe.estimation.equations import Filter
    from tissue_probe.estimation.settings import EstimatorSettings

#: The variance of a product of two errors is at most twice the product of their variances, if they
#: are normal; that of a sum of three terms at most three times the sum of theirs.
LARGEST_PRODUCT = 6.0
#: A constant stays within this many standard deviations of its tolerance, as in a diagnosis.
FARTHEST = 4.0


def list_considered(settings: EstimatorSettings) -> tuple[str, ...]:
    """Return the names of the constants that a filter considers; none if all are exact.

    The place of contact is not among them: where it is known roughly, the filter has a constant
    force as a state (``may_touch_elsewhere``). Where the tip follows the position, nobody knows its
    mass roughly (``RIGID_PROBE``).
    """
    rig = RIGS[settings.rig]
    if rig.live is not Live.models:
        return ()
    names = [each.name for each in rig.constants if each.name != CONTACT_POSITION.name]
    return tuple(names) if any(getattr(settings, f"{name}_tol") for name in names) else ()


def may_touch_elsewhere(settings: EstimatorSettings) -> bool:
    """Whether the place of contact is known roughly: an error of it is a constant force."""
    return RIGS[settings.rig].live is Live.models and settings.contact_position_tol > 0.0


def begin(filter: Filter) -> None:
    """Begin with the constants as they were stated."""
    import sympy as sp  # only where a kernel has to be generated: it takes half a second

    q = len(filter.considered)
    filter.store_considered(W=0 * filter.W, d=0 * filter.d, L=sp.eye(q))


def reopen(filter: Filter, kept: Sequence[bool]) -> None:
    """Forget the constants' part in all states that are begun anew."""
    rows = [filter.W[i, :] * int(keeps) for i, keeps in enumerate(kept)]
    filter.store_considered(W=filter.W.vstack(*rows))


def predict(filter: Filter) -> None:
    """Advance the shifts, before the mean, whose derivatives they share; add noise to come."""
    import sympy as sp

    _, F = filter.step()
    noise = write_neglected_variance(filter)
    filter.store_considered(W=F * filter.W + filter.B * filter.L)
    names = filter.layout.states
    filter.Q += sp.diag(*[noise if name == "tip_velocity" else 0 for name in names])


def write_neglected_variance(filter: Filter) -> sp.Symbol:
    """Return the variance of the second-order terms of the tip's speed after a step [m^2/s^2].

    In m x'' = k0 (u - x) + beta0 (u' - x') - k x - beta x' errors of k0 + k, beta0 + beta and m are
    multiplied by errors of x, x' and x''. The constants' errors are counted as at first.
    """
    total = filter.diagonal(filter.P + filter.W * filter.W.T)
    m, k0, beta0 = filter.considered
    mass, spring, damper = filter.deviations
    at = dict(zip(filter.layout.states, filter.X, strict=True))
    k, beta = at["stiffness"], at["damping"]
    x, v = total["tip_position"], total["tip_velocity"]
    by_spring = total["stiffness"] + spring**2 + (mass / m * (k0 + k)) ** 2
    by_damper = total["damping"] + damper**2 + (mass / m * (beta0 + beta)) ** 2
    rate = filter.constant("sample_period") / m
    products = by_spring * x + by_damper * v
    return filter.program.let("left_out", LARGEST_PRODUCT * rate**2 * products)


def update(filter: Filter) -> None:
    """Take in an innovation, given with its whole variance; leave to the filter its own part."""
    import sympy as sp

    s, P, H = filter.seen, filter.P, filter.H
    innovation, S, program = filter.innovation, filter.S, filter.program
    own = program.let("S_own", (H * P * H.T)[0] + filter.R)
    K = filter.let("K_own", P * H.T / own)
    share = program.let("share", 1 / S)
    news = program.let("news", innovation * share)
    part = sp.sqrt(sp.Max(0, 1 - (s * s.T)[0] * share))
    potter = program.let("potter", share / (1 + part))
    W = filter.let("W", filter.W - K * s)
    Ws, Ls = filter.let("Ws", W * s.T), filter.let("Ls", filter.L * s.T)
    d = (filter.d + Ls * news).applyfunc(lambda each: sp.Max(-FARTHEST, sp.Min(FARTHEST, each)))
    filter.store_considered(W=W - potter * Ws * s, d=d, L=filter.L - potter * Ls * s)
    filter.X = filter.let("shifted", filter.X + Ws * news)
    filter.S = own


def is_bounded(filter: Filter) -> list[sp.Symbol]:
    """Return whether the constants' errors shift no state beyond its ceiling; of NaN they do."""
    import sympy as sp

    bounded = sp.Symbol("bounded")
    filter.program.line(f"{bounded} = True")
    if filter.considered:
        variances, ceilings = _shifts(filter), filter.per_state("largest_variance")
        for variance, ceiling in zip(variances, ceilings, strict=True):
            filter.program.line(f"{bounded} &= {variance} <= {ceiling}")
    return [bounded]


def bound(filter: Filter) -> None:
    """Scale the rows of W that are beyond; where numbers overflowed, start again."""
    import sympy as sp

    program = filter.program
    if not filter.considered:
        program.line("pass")
        return
    everything = sum([*filter.W, *filter.d, *filter.L], sp.Integer(0))
    whole = program.let("whole", everything)
    program.begin(f"if not abs({whole}) < math.inf:")
    program.line("start(constants, memory)")
    program.line("return")
    program.end()
    variances, ceilings = _shifts(filter), filter.per_state("largest_variance")
    shares = [c / v for c, v in zip(ceilings, variances, strict=True)]
    scale = filter.let("scale", sp.Matrix([sp.sqrt(sp.Min(1, share)) for share in shares]))
    filter.store_considered(W=sp.diag(*scale) * filter.W)


def _shifts(filter: Filter) -> list[sp.Symbol]:
    """Return the variances by which the constants' errors shift the states."""
    rows = [filter.W[i, :] for i in range(filter.W.rows)]
    return [filter.program.let("shift", (row * row.T)[0]) for row in rows]
