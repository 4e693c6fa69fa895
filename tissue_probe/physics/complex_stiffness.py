"""Complex stiffness of a composed tissue in small motion about a depth.

For a small x about a depth the force is f = f_x x + f_v x' + f_e e, and e, which the tissue
remembers, follows e' = b_x x + b_v x' + A e. At the angular frequency w, with s = i w, the complex
stiffness is K = f_x + s f_v + f_e (s - A)^-1 (b_x + s b_v). Its real part is the storage, its
imaginary part the loss. Contact, friction, inertia and the surface's motion are not of the tissue,
and left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property

import numpy as np
import sympy as sp

from tissue_probe.errors import ParameterError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects.effect import (
    DAMPING,
    ELASTIC_DEPTH,
    ELASTIC_RATE,
    INDENTATION,
    STIFFNESS,
    TIP_VELOCITY,
)
from tissue_probe.physics.rigs.composing import elastic_depth
from tissue_probe.physics.tissues import TISSUES
from tissue_probe.signals import FloatArray


class TissueInSmallMotion:
    """The tissue of a model, linear about a depth.

    Parameters
    ----------
    composition : Composition
        Of it rig, contact and friction are left out.

    Raises
    ------
    ParameterError
        By its methods, if a value of the tissue or of an effect is missing.
    """

    def __init__(self, composition: Composition) -> None:
        effects, tissue = composition.all_effects, TISSUES[composition.tissue]
        depth = elastic_depth(effects)
        at = {ELASTIC_DEPTH: depth, ELASTIC_RATE: depth.diff(INDENTATION) * TIP_VELOCITY}
        force = sp.sympify(tissue.force + sum(effect.force for effect in effects)).subs(at)
        states = [*tissue.states, *(state for effect in effects for state in effect.states)]
        felt = [state for state in states if state.symbol in force.free_symbols]
        own = [entry.symbol for effect in effects for entry in effect.parameters]
        self._values = [STIFFNESS, DAMPING, *own]
        self._elastic = STIFFNESS * depth
        self._moving = [TIP_VELOCITY, *(state.symbol for state in felt)]
        self._laws = sp.Matrix([force, *(sp.sympify(state.motion).subs(at) for state in felt)])
        self._slopes = self._laws.jacobian([INDENTATION, *self._moving])

    @property
    def names(self) -> set[str]:
        """Names of the values that its force follows."""
        return {str(symbol) for symbol in self._values}

    @property
    def is_linear(self) -> bool:
        """Whether force and memory are in proportion to speed and memory, at all times alike."""
        known = {INDENTATION, *self._moving, *self._values}
        slopes = self._slopes[:, 1:]
        return self._laws.free_symbols <= known and not slopes.free_symbols & {*self._moving}

    @property
    def differs_with_depth(self) -> bool:
        """Whether the complex stiffness is another one at another depth."""
        return INDENTATION in self._slopes.free_symbols

    def force(self, values: Mapping[str, float], depth: float) -> float:
        """Return the elastic force [N] at a depth [m], after all relaxation."""
        return float(self._compile(self._elastic)(depth, *self._order(values)))

    def spring(self, values: Mapping[str, float], depth: float) -> float:
        """Return the slope of the elastic force [N/m] at a depth [m], after all relaxation."""
        slope = self._elastic.diff(INDENTATION)
        return float(self._compile(slope)(depth, *self._order(values)))

    def damper(self, values: Mapping[str, float], depth: float) -> float:
        """Return the damping beside spring and memory [N s/m] at a depth [m]."""
        return float(self._slopes_at(values, depth)[0, 1])

    def complex_stiffness(
        self, values: Mapping[str, float], depth: float, frequency: float
    ) -> complex:
        """Return storage + i loss [N/m] at a depth [m] and a frequency [Hz]."""
        s = 2j * np.pi * frequency
        slopes = self._slopes_at(values, depth)
        driven = slopes[:, 0] + s * slopes[:, 1]
        remembered = np.linalg.solve(s * np.eye(len(driven) - 1) - slopes[1:, 2:], driven[1:])
        return complex(driven[0] + slopes[0, 2:] @ remembered)

    def _slopes_at(self, values: Mapping[str, float], depth: float) -> FloatArray:
        return np.asarray(self._slopes_compiled(depth, *self._order(values)), dtype=np.float64)

    @cached_property
    def _slopes_compiled(self) -> Callable[..., FloatArray]:
        return self._compile(self._slopes.subs(dict.fromkeys(self._moving, 0.0)))

    def _compile(self, law: sp.Expr) -> Callable[..., FloatArray]:
        compiled: Callable[..., FloatArray] = sp.lambdify([INDENTATION, *self._values], law)
        return compiled

    def _order(self, values: Mapping[str, float]) -> list[float]:
        if missing := self.names - values.keys():
            raise ParameterError(f"`model` has no value of {min(missing)}: fit it first")
        return [values[str(symbol)] for symbol in self._values]


def name_nonlinear(composition: Composition) -> list[str]:
    """Return the effects by which a tissue has no complex stiffness: of speed, history or time."""
    alone = {each.name: Composition(effects=(each,)) for each in composition.all_effects}
    return [name for name, model in alone.items() if not TissueInSmallMotion(model).is_linear]
