"""Preconditioning: tissue softens as it is worked, toward a limit.

The spring's force is that of the tissue as it is in the end, times 1 + g exp(-s / L). Here s is the
way that the tip has gone in and out since the recording began, L the way within which the tissue
settles, and g by how much stiffer it is at the beginning of the recording than in the end. Fresh
tissue of stiffness k0 that loses a share a has g = a / (1 - a) and k0 = k (1 + g): its stiffness is
k0 (1 - a (1 - exp(-s / L))).

What a recording finds has been worked before: g is that of the recording. In one that follows it is
smaller, by what the first has worked; after a rest it may have come back.
"""

import math

import sympy as sp

from tissue_probe.physics.effects.effect import (
    ELASTIC_DEPTH,
    STIFFNESS,
    TIP_VELOCITY,
    Effect,
    Parameter,
    State,
)
from tissue_probe.physics.extent import Extent

EXCESS = sp.Symbol("stiffer_at_the_start", real=True)
SETTLING_PATH = sp.Symbol("settling_path", positive=True)
PATH = sp.Symbol("path_so_far", real=True)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose ways from half a period's to the whole recording's, of a sine as fast and as wide."""
    whole = 2.0 / math.pi * extent.speed * extent.duration
    shortest = 2.0 * extent.indentation
    return [{str(SETTLING_PATH): max(whole * f, shortest)} for f in (0.01, 0.03, 0.1, 0.3, 1.0)]


PRECONDITIONING = Effect(
    name="preconditioning",
    family="damage",
    physics="The tissue softens as it is worked, toward a limit",
    says="the tissue is {stiffer_at_the_start:.2f} times its final stiffness stiffer at the start, "
    "and settles within a way of {settling_path:m}",
    parameters=(
        Parameter(EXCESS, "1", default=0.3, lower=0.0, upper=20.0),
        Parameter(SETTLING_PATH, "m", default=3e-2, lower=1e-4, upper=10.0),
    ),
    force=STIFFNESS * ELASTIC_DEPTH * EXCESS * sp.exp(-PATH / SETTLING_PATH),
    states=(State(PATH, sp.Abs(TIP_VELOCITY), spread="counted"),),
    starts=starts,
    of_run=(str(EXCESS),),
    assumptions="All ways count alike, whatever their depth; nothing recovers during the "
    "recording; the damping stays",
    reference="Fung, Biomechanics: Mechanical Properties of Living Tissues (1993), chapter 7, on "
    "preconditioning; Chaboche, Int. J. Plasticity 5 (1989), 247, on a limit that is neared by the "
    "way gone",
)
