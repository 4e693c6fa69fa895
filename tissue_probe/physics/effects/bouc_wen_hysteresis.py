"""Rate-independent hysteresis: friction that first yields elastically."""

import sympy as sp

from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Extent, Parameter, State

HYSTERETIC = sp.Symbol("hysteretic_force", real=True)
YIELD = sp.Symbol("yield_displacement", positive=True)
ELASTIC = sp.Symbol("elastic_displacement", real=True)
_SHARE = ELASTIC / YIELD


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose yield displacements from a fiftieth of the indentation to the whole."""
    return [{"yield_displacement": extent.indentation * f} for f in (0.02, 0.06, 0.2, 0.6)]


def _form(exponent: int, forms: tuple[Effect, ...] = ()) -> Effect:
    # z' = v (1 - |z/D|^n (1 + sign(v z)) / 2): elastic at a reversal, saturated at |z| = D.
    sliding = sp.Abs(_SHARE) ** exponent * (1 + sp.sign(TIP_VELOCITY) * sp.sign(ELASTIC)) / 2
    return Effect(
        name="bouc_wen_hysteresis",
        family="friction",
        physics="A spring that yields: friction with an elastic displacement before it slides",
        says="friction of {hysteretic_force:N} that yields over {yield_displacement:m}",
        parameters=(
            Parameter(HYSTERETIC, "N", default=0.05, lower=0.0, upper=1e3),
            # What yields sooner is dry friction, and asks for very short steps.
            Parameter(YIELD, "m", default=2e-4, lower=1e-5, upper=1e-2),
        ),
        drag=HYSTERETIC * _SHARE,
        states=(State(ELASTIC, TIP_VELOCITY * (1 - sliding), spread=str(YIELD)),),
        starts=starts,
        forms=forms,
        simpler=("coulomb_friction",),
        limit=str(YIELD),
        excludes=("coulomb_friction", "stribeck_friction"),
        assumptions=f"Rate-independent; exponent n = {exponent}, gamma = beta",
        reference="Bouc (1967); Wen, J. Engineering Mechanics 102 (1976), 249, eq. 3",
    )


BOUC_WEN_HYSTERESIS = _form(1, (_form(2),))
