"""Tissues: springs and dampers under the tip (the paper's Table I).

Contents: linear viscoelastic solids and fluids of stiffness k and damping beta.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from tissue_probe.physics.effects.effect import (
    DAMPING,
    INDENTATION,
    STIFFNESS,
    TIP_VELOCITY,
    State,
)
from tissue_probe.physics.tissue_names import TissueName

EXTENSION = sp.Symbol("spring_extension", real=True)


@dataclass(frozen=True)
class Tissue:
    """Force on the tip [N], positive against indentation, and the tissue's own states.

    Further effects that belong to it stand in ``kinds``.
    """

    name: TissueName
    force: sp.Expr
    states: tuple[State, ...] = ()


_SOLID = STIFFNESS * INDENTATION + DAMPING * TIP_VELOCITY
TISSUES: dict[str, Tissue] = {
    tissue.name: tissue
    for tissue in (
        Tissue("kelvin_voigt", _SOLID),
        # One force f passes both: x' = f' / k + f / beta. The spring's extension is f / k.
        Tissue(
            "maxwell",
            STIFFNESS * EXTENSION,
            (State(EXTENSION, TIP_VELOCITY - STIFFNESS / DAMPING * EXTENSION, spread="branch"),),
        ),
        Tissue("standard_linear_solid", _SOLID),
        Tissue("generalized_maxwell", _SOLID),
    )
}
