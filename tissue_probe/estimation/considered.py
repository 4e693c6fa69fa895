"""Constants of the rig that are known roughly, considered beside any of the Kalman filters.

A constant that is wrong is wrong in the same way in every sample: no noise of process or force may
stand for it. So the filter keeps its own covariance P and gain K, those of right constants; beside
them it keeps by how much the constants' errors shift its mean, and what the innovations tell of
these errors (B. Friedland, IEEE Trans. Automatic Control 14, 1969, "Treatment of bias in recursive
filtering"). With the errors in their standard deviations, d known of them with covariance M (at
first 0 and I),

    prediction:  V <- F V + B,                         B = df/dc sd
    force:       s = H V + D,  S = H P H^T + R + s M s^T,  D = dh/dc sd
    update:      V <- V - K s,  g = M s^T / S,  d <- d + g nu,  M <- M - g s M,
                 X <- X + K nu + V g nu,  nu = y - h(X, c + sd d)

This is the extended filter whose state is augmented by the constants, without process noise, its
covariance [P + V M V^T, V M; M V^T, M] kept in factors. Of M a root is kept, M = L L^T, by J. E.
Potter's update (R. H. Battin, Astronautical Guidance, 1964), so that no rounding makes it one that
no numbers have:

    f = L^T s^T,  L <- L - L f f^T / (S (1 + sqrt(1 - f^T f / S)))

Its innovations are white, and so all tests
of them hold as they are. What fades or is opened anew is P, the tissue's: a rig does not change.

The first samples tell much of all unknowns together, by tangents that are taken at a wild mean:
false news of the constants, which would never be forgotten. So nothing is learnt of them at first
(S. F. Schmidt, Advances in Control Systems 3, 1966: they are considered, M held), and where the
tangents have become good, the tissue is opened anew.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tissue_probe.estimation.few_points import spread, tangent_is_poor
from tissue_probe.physics.rigs import RIGS, Live
from tissue_probe.physics.rigs.constants import CONTACT_POSITION

if TYPE_CHECKING:
    from collections.abc import Sequence

    import sympy as sp

    from tissue_probe.estimation.equations import Filter
    from tissue_probe.estimation.settings import EstimatorSettings

#: How often the tissue is opened anew before constants are learnt: the first time the tangents were
#: taken at a wild mean, the second time at the mean of a few samples only.
PASSES = 2.0
#: A constant stays within this many standard deviations of its tolerance, as in a diagnosis.
FARTHEST = 4.0


def considered(settings: EstimatorSettings, force_offset: bool) -> tuple[str, ...]:
    """Return the names of the constants that a filter considers; none if all are exact.

    A filter that estimates a constant force has the place of contact in it: both shift the force.
    Where the tip follows the position, nobody knows its mass roughly (``RIGID_PROBE``).
    """
    rig = RIGS[settings.rig]
    if rig.live is not Live.models:
        return ()
    names = [constant.name for constant in rig.constants]
    if not any(getattr(settings, f"{name}_tol") for name in names):
        return ()
    return tuple(n for n in names if not (force_offset and n == CONTACT_POSITION.name))


def begin(filter: Filter) -> None:
    """Know of the constants what was stated, and hold it at first."""
    import sympy as sp  # only where a kernel has to be generated: it takes half a second

    q = len(filter.considered)
    filter.store_considered(V=0 * filter.V, d=0 * filter.d, L=sp.eye(q))
    filter.program.store("memory", filter.layout.passes, [0.0])


def reopen(filter: Filter, kept: Sequence[bool]) -> None:
    """Forget the constants' part in all states that are begun anew."""
    rows = [filter.V[i, :] * int(keeps) for i, keeps in enumerate(kept)]
    filter.store_considered(V=filter.V.vstack(*rows))


def reopen_tissue(filter: Filter) -> None:
    """Keep the motion and all means; know of the tissue as little as at first, from here."""
    moving = [i < len(filter.model.states) for i in range(len(filter.X))]
    prior = filter.per_state("prior_variance")
    P = filter.P.copy()
    for i, moves in enumerate(moving):
        for j in range(len(moving)):
            if not (moves and moving[j]):
                P[i, j] = prior[i] if i == j else 0
    filter.assign(filter.X, P)
    reopen(filter, moving)


def predict(filter: Filter) -> None:
    """Advance the sensitivity, before the mean, whose derivatives it shares.

    Sigma points stand for the tangent where that is poor: what it leaves out of the tissue's force
    would else be taken for news of the constants.
    """
    _, F = filter.step()
    filter.store_considered(V=F * filter.V + filter.B)
    filter.program.begin(f"if {tangent_is_poor(filter, filter.P)}:")
    spread(filter, tangent=len(filter.model.states))
    filter.program.line("return")
    filter.program.end()


def update(filter: Filter) -> None:
    """Take in an innovation, given with its whole variance; leave to the filter its own part."""
    import sympy as sp

    s, P, H = filter.seen, filter.P, filter.H
    innovation, S, program = filter.innovation, filter.S, filter.program
    own = program.let("S_own", (H * P * H.T)[0] + filter.R)
    K = filter.let("K_own", P * H.T / own)
    f = filter.let("f", (s * filter.L).T)
    Lf = filter.let("Lf", filter.L * f)
    (passes,) = program.load("memory", filter.layout.passes, ["passes"])
    (share,) = program.variables("share", [1 / S])
    program.line(f"if {passes} < {PASSES}: {share} = 0.0")
    gain = filter.let("gain", share * Lf)
    part = sp.sqrt(sp.Max(0, 1 - share * (f.T * f)[0]))
    L = filter.L - Lf * f.T * share / (1 + part)
    V = filter.let("V", filter.V - K * s)
    d = filter.d + gain * innovation
    d = filter.let("d", d.applyfunc(lambda each: sp.Max(-FARTHEST, sp.Min(FARTHEST, each))))
    correction = filter.let("correction", d - filter.d)
    filter.store_considered(V=V, d=d, L=L)
    filter.X = filter.let("shifted", filter.X + V * correction)
    filter.S = own


def begin_to_learn(filter: Filter) -> None:
    """After an update: open the tissue anew where it is known so well that the tangent will do."""
    program = filter.program
    program.begin(f"if passes < {PASSES}:")
    program.begin(f"if not {tangent_is_poor(filter, filter.P + filter.V * filter.V.T)}:")
    program.line(f"memory[{filter.layout.passes}] = passes + 1.0")
    program.line("reopen_tissue(constants, memory)")
    program.end()
    program.end()


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
    """Scale the rows of V that are beyond; where numbers overflowed, start again."""
    import sympy as sp

    program = filter.program
    if not filter.considered:
        program.line("pass")
        return
    everything = sum([*filter.V, *filter.d, *filter.L], sp.Integer(0))
    whole = program.let("whole", everything)
    program.begin(f"if not abs({whole}) < math.inf:")
    program.line("start(constants, memory)")
    program.line("return")
    program.end()
    variances, ceilings = _shifts(filter), filter.per_state("largest_variance")
    shares = [c / v for c, v in zip(ceilings, variances, strict=True)]
    scale = filter.let("scale", sp.Matrix([sp.sqrt(sp.Min(1, share)) for share in shares]))
    filter.store_considered(V=sp.diag(*scale) * filter.V)


def _shifts(filter: Filter) -> list[sp.Symbol]:
    """Return the variances by which the constants' errors shift the states."""
    VL = filter.let("VL", filter.V * filter.L)
    rows = [VL[i, :] for i in range(VL.rows)]
    return [filter.program.let("shift", (row * row.T)[0]) for row in rows]
