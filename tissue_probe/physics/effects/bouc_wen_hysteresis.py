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
WEAKENING = sp.Symbol("weakening_by_work", real=True)
#: Work of the hysteretic force so far, over that force where it slides.
WORK = sp.Symbol("work_so_far", real=True)
_YIELDS = "friction of {hysteretic_force:N} that yields over {yield_displacement:m}"
_PARAMETERS = (
    Parameter(HYSTERETIC, "N", default=0.05, lower=0.0, upper=1e3),
    # What yields sooner is dry friction, and asks for very short steps.
    Parameter(YIELD, "m", default=2e-4, lower=1e-5, upper=1e-2),
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
    states: tuple[State, ...],
    begun: Starts,
    says: str,
    assumptions: str,
    limit: str = "",
    forms: tuple[Effect, ...] = (),
) -> Effect:
    return Effect(
        name="bouc_wen_hysteresis",
        family="friction",
        physics="A spring that yields: friction with an elastic displacement before it slides",
        says=says,
        parameters=parameters,
        drag=drag,
        states=states,
        starts=begun,
        forms=forms,
        simpler=("coulomb_friction",),
        limit=limit,
        excludes=("coulomb_friction", "stribeck_friction", "prandtl_ishlinskii"),
        assumptions=f"Rate-independent; {assumptions}",
        reference="Bouc (1967); Wen, J. Engineering Mechanics 102 (1976), 249, eq. 3; Ikhouane and "
        "Rodellar, Systems with Hysteresis (2007), chapter 2, on its shapes; Baber and Wen, J. "
        "Engineering Mechanics Division 107 (1981), 1069, on strength that falls with work",
    )


def _sliding(exponent: int, forms: tuple[Effect, ...] = ()) -> Effect:
    # z' = v (1 - |z/D|^n (1 + sign(v z)) / 2): elastic at a reversal, saturated at |z| = D.
    share = ELASTIC / YIELD
    slides = sp.Abs(share) ** exponent * (1 + sp.sign(TIP_VELOCITY) * sp.sign(ELASTIC)) / 2
    return _form(
        _PARAMETERS,
        HYSTERETIC * share,
        (State(ELASTIC, TIP_VELOCITY * (1 - slides), spread=str(YIELD)),),
        starts,
        _YIELDS,
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
    (
        State(
            ELASTIC,
            TIP_VELOCITY * (1 - GAMMA * sp.Abs(ELASTIC)) - BETA * sp.Abs(TIP_VELOCITY) * ELASTIC,
        ),
    ),
    _as_large,
    "hysteresis of {hysteretic_stiffness:N/m}, of the shape beta {loop_closing:.4g} 1/m and gamma "
    "{loop_bending:.4g} 1/m",
    "exponent n = 1, beta and gamma free",
)


def _as_weakened(extent: Extent) -> list[dict[str, float]]:
    """Propose friction of a third and of a twentieth in the end, where all of the way is work."""
    way = extent.speed * extent.duration
    return [{**each, str(WEAKENING): f / way} for each in starts(extent)[:3] for f in (2.0, 20.0)]


def _weakening() -> Effect:
    """Return the form whose friction weakens as 1 / (1 + d e) with the work e done against it."""
    share = ELASTIC / YIELD
    weaker = 1 + WEAKENING * sp.Max(WORK, 0)
    slides = weaker * sp.Abs(share) * (1 + sp.sign(TIP_VELOCITY) * sp.sign(ELASTIC)) / 2
    return _form(
        (*_PARAMETERS, Parameter(WEAKENING, "1/m", default=10.0, lower=0.0, upper=1e4)),
        HYSTERETIC * share,
        (
            State(ELASTIC, TIP_VELOCITY * (1 - slides), spread=str(YIELD)),
            State(WORK, TIP_VELOCITY * share, spread="counted"),
        ),
        _as_weakened,
        f"{_YIELDS}, and is half as strong once its work is that over {{weakening_by_work:depth}}",
        "exponent n = 1, gamma = beta; strength falls with the work done since the first sample",
        str(YIELD),
    )


BOUC_WEN_HYSTERESIS = _sliding(1, (_sliding(2), _SHAPED, _weakening()))
