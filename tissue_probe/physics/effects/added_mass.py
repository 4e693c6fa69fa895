"""Mass that moves with the tip besides its own."""

import sympy as sp

from tissue_probe.physics.effects.effect import Effect, Parameter
from tissue_probe.physics.extent import Extent

EXTRA_MASS = sp.Symbol("added_mass", real=True)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose nothing, and as much as a tip or several: a resonance is found from near it."""
    return [{}, *({"added_mass": mass} for mass in (0.03, 0.06, 0.1, 0.16))]


ADDED_MASS = Effect(
    name="added_mass",
    family="inertia",
    physics="Tissue, or a forgotten part of the tool, moves along with the tip",
    says="a mass of {added_mass:kg} moves along",
    parameters=(Parameter(EXTRA_MASS, "kg", default=0.005, lower=0.0, upper=1.0),),
    inertia=EXTRA_MASS,
    starts=starts,
    assumptions="Rigidly joined to the tip",
    reference="Newton (1687), second law; Oestreicher, J. Acoustical Society of America 23 "
    "(1951), 707, for the mass of tissue that a vibrating sphere moves",
)
