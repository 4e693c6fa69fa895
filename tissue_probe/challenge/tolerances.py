"""How far a rig may be off from its nominal constants.

Contents: the tolerances, and a rig moved within them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tissue_probe.challenge.specimen import Specimen
from tissue_probe.signals import FloatArray


class Tolerances(NamedTuple):
    """Standard deviations: of m and k0, and of the logarithm of beta0 [-]; contact zero [m]."""

    mass: float = 0.01
    stiffness: float = 0.015
    damping: float = 0.20
    zero: float = 30e-6

    def draw_rig(self, rig: Specimen, deviations: FloatArray) -> tuple[Specimen, float]:
        """Return a rig that is off, and its contact zero [m].

        Parameters
        ----------
        rig : Specimen
            As it should be.
        deviations : array, shape (4,)
            In standard deviations, in the order of the fields.
        """
        mass, stiffness, damping, zero = deviations
        off = rig._replace(
            tip_mass=rig.tip_mass * (1.0 + self.mass * mass),
            load_cell_stiffness=rig.load_cell_stiffness * (1.0 + self.stiffness * stiffness),
            # Lognormal, so that no draw makes a damper that drives.
            load_cell_damping=float(rig.load_cell_damping * np.exp(self.damping * damping)),
        )
        return off, float(self.zero * zero)
