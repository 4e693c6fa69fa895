"""The load cell is softer or stiffer than its data sheet says."""

from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.effects.effect import Effect, Parameter
from tissue_probe.physics.extent import Extent

LOAD_CELL_STIFFNESS_SHARE = sp.Symbol("load_cell_stiffness_share", real=True)


def near(extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose softer and stiffer cells: the tip's resonance is found from near it."""
    return [{str(LOAD_CELL_STIFFNESS_SHARE): share} for share in (-0.4, -0.2, 0.2, 0.5)]


LOAD_CELL_STIFFNESS_ERROR = Effect(
    name="load_cell_stiffness_error",
    family="scale",
    physics="The load cell's spring is stiffer than believed by a share, (1 + e) k0",
    says="the load cell is stiffer by {load_cell_stiffness_share:+.1%}",
    parameters=(Parameter(LOAD_CELL_STIFFNESS_SHARE, "1", default=0.05, lower=-0.5, upper=1.0),),
    cell=1 + LOAD_CELL_STIFFNESS_SHARE,
    near=near,
    assumptions="The force that it reads stays right",
    reference="Doebelin, Measurement Systems (2004), section 5.2, on elastic force transducers",
)
