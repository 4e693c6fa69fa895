"""Rate-independent hysteresis: friction that first yields elastically."""

import sympy as sp

from tissue_probe.physics.effects.effect import (
    TIP_VELOCITY,
    Effect,
    Parameter,
    Starts,
    State,
)
from tissue_probe.physics.extent import Extent

HYSTERETIC = sp.Symbol("hysteretic_force", real=True)
YIELD = sp.Symbol("yield_displacement", positive=True)
ELASTIC = sp.Symbol("elastic_displacement", real=True)
INITIAL, GAMMA = sp.symbols("hysteretic_stiffness loop_bending", real=True)
BETA = sp.Symbol("loop_closing", positive=True)
#: Of what is told by how it bends, and of what is told by where it yields.
_SAYS = (
    "hysteresis of {hysteretic_stiffness:N/m}, of the shape beta {loop_closing:.4g} 1/m and gamma "
    "{loop_bending:.4g} 1/m",
    "friction of {hysteretic_force:N} that yields over {yield_displacement:m}",
)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose yield displacements from a fiftieth of the indentation to the whole."""
    return [{"yield_displacement": extent.indentation * f} for f in (0.02, 0.06, 0.2, 0.6)]


def _as_large(extent: Extent) -> list[dict[str, float]]:
    """Propose loops that turn within the motion, full ones and thin ones.

    Where gamma < -beta the force grows with the way as an exponential: none begins beyond.
    """
    return [
        {"loop_closing": f / extent.indentation, "loop_bending": share * f / extent.indentation}
        for f in (0.5, 2.5, 12.0)
        for share in (-1.0, -0.5, 0.5)
    ]


def _form(
    parameters: tuple[Parameter, ...],
    drag: sp.Expr,
    state: State,
    begun: Starts,
    assumptions: str,
    limit: str = "",
    forms: tuple[Effect, ...] = (),
) -> Effect:
    return Effect(
        name="bouc_wen_hysteresis",
        family="friction",
        physics="A spring that yields: friction with an elastic displacement before it slides",
        says=_SAYS[bool(limit)],
        parameters=parameters,
        drag=drag,
        states=(state,),
        starts=begun,
        forms=forms,
        simpler=("coulomb_friction",),
        limit=limit,
        excludes=("coulomb_friction", "stribeck_friction", "prandtl_ishlinskii"),
        assumptions=f"Rate-independent; {assumptions}",
        reference="Bouc (1967); Wen, J. Engineering Mechanics 102 (1976), 249, eq. 3; Ikhouane and "
        "Rodellar, Systems with Hysteresis (2007), chapter 2, on its shapes",
    )


def _sliding(exponent: int, forms: tuple[Effect, ...] = ()) -> Effect:
    # z' = v (1 - |z/D|^n (1 + sign(v z)) / 2): elastic at a reversal, saturated at |z| = D.
    share = ELASTIC / YIELD
    slides = sp.Abs(share) ** exponent * (1 + sp.sign(TIP_VELOCITY) * sp.sign(ELASTIC)) / 2
    return _form(
        (
            Parameter(HYSTERETIC, "N", default=0.05, lower=0.0, upper=1e3),
            # What yields sooner is dry friction, and asks for very short steps.
            Parameter(YIELD, "m", default=2e-4, lower=1e-5, upper=1e-2),
        ),
        HYSTERETIC * share,
        State(ELASTIC, TIP_VELOCITY * (1 - slides), spread=str(YIELD)),
        starts,
        f"exponent n = {exponent}, gamma = beta",
        str(YIELD),
        forms,
    )


# z' = v - beta |v| z - gamma v |z|: of beta the loop's area, of gamma its bend; it slides where
# gamma > -beta, and hardens where gamma < -beta.
_SHAPED = _form(
    (
        Parameter(INITIAL, "N/m", default=300.0, lower=0.0, upper=1e6),
        # A loop closes within 10 mm, as the other forms yield: of one that hardly does the force is
        # a spring's, and forgets where it began along the way, as a branch does in time.
        Parameter(BETA, "1/m", default=1e3, lower=100.0, upper=1e5),
        Parameter(GAMMA, "1/m", default=0.0, lower=-1e5, upper=1e5),
    ),
    INITIAL * ELASTIC,
    State(
        ELASTIC,
        TIP_VELOCITY * (1 - GAMMA * sp.Abs(ELASTIC)) - BETA * sp.Abs(TIP_VELOCITY) * ELASTIC,
    ),
    _as_large,
    "exponent n = 1, beta and gamma free",
)
BOUC_WEN_HYSTERESIS = _sliding(1, (_sliding(2), _SHAPED))
