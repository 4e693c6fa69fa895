"""The load cell is softer or stiffer than its data sheet says."""

import sympy as sp

from tissue_probe.physics.effects.effect import Effect, Parameter

ERROR = sp.Symbol("load_cell_stiffness_share", real=True)

LOAD_CELL_STIFFNESS_ERROR = Effect(
    name="load_cell_stiffness_error",
    family="scale",
    physics="The load cell's spring is stiffer than believed by a share, (1 + e) k0",
    parameters=(Parameter(ERROR, "1", default=0.05, lower=-0.5, upper=1.0),),
    cell=1 + ERROR,
    assumptions="The force that it reads stays right",
    reference="Doebelin, Measurement Systems (2004), section 5.2, on elastic force transducers",
)
