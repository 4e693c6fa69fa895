"""Rigs: how an instrument couples to Kelvin-Voigt tissue and to further effects of the tissue.

What belongs here: one function a rig, which returns its ``Model``.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from tissue_probe.physics.effects.effect import TIP_POSITION, TIP_VELOCITY, Effect
from tissue_probe.physics.model import Model

STIFFNESS, DAMPING, OFFSET = sp.symbols("stiffness damping force_offset", real=True)


def compliant_probe(effects: Sequence[Effect] = (), force_offset: bool = False) -> Model:
    """Tip on a load cell that yields, driven by a coil of known displacement (paper, fig. 1).

        m x'' = k0 (u - x) + beta0 (u' - x') - k x - beta x' - effects   (paper, eq. 1)
        F = k0 (u - x) + d                                               (paper, eq. 2)

    Eq. 1 is printed without its dots; F is positive in compression, the opposite of eq. 2. The
    constant d (with ``force_offset``) is the load cell's zero error, and equally a contact point
    that lies elsewhere than at x = 0: both shift the force by a constant, and neither the motion.

    Parameters
    ----------
    effects : sequence of Effect
        Further forces of the tissue.
    force_offset : bool
        Whether the constant force d [N] is a parameter to be estimated; 0 otherwise.
    """
    x, v = TIP_POSITION, TIP_VELOCITY
    u, du = sp.symbols("position position_rate", real=True)
    m, k0, beta0 = sp.symbols("tip_mass load_cell_stiffness load_cell_damping", positive=True)
    tissue = STIFFNESS * x + DAMPING * v + sum(effect.force for effect in effects)
    acceleration = (k0 * (u - x) + beta0 * (du - v) - tissue) / m
    offset = [OFFSET] if force_offset else []
    return Model(
        states=sp.Matrix([x, v, *(state for effect in effects for state in effect.states)]),
        parameters=sp.Matrix(
            [
                STIFFNESS,
                DAMPING,
                *offset,
                *(entry.symbol for effect in effects for entry in effect.parameters),
            ]
        ),
        constants=(m, k0, beta0),
        input=u,
        input_rate=du,
        motion=sp.Matrix([v, acceleration, *(rate for e in effects for rate in e.motion)]),
        output=k0 * (u - x) + sum(offset),
    )
