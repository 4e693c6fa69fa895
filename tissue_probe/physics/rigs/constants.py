"""Constants of rigs: the declaration of one, and its tolerance where nobody states one.

Contents: that, and the constants that several rigs have.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from tissue_probe.physics.entry import Entry


@dataclass(frozen=True)
class Constant:
    """A constant of a rig.

    Attributes
    ----------
    entry : Entry
        Its name, that of its symbol in the equations; unit, scale and bounds.
    value, deviation : float
        Its value where nobody states one, and the standard deviation of that: 0 says
        that it is known, infinity that it is not known at all, and fitted.
    """

    entry: Entry
    value: float
    deviation: float

    @property
    def name(self) -> str:
        """The entry's name."""
        return self.entry.name


TIP_MASS = Entry("tip_mass", "kg", default=0.04, lower=0.0, upper=1e4)
#: Where a force drives, it divides by the mass [kg].
DRIVEN_MASS = replace(TIP_MASS, lower=1e-6)
CONTACT_POSITION = Entry("contact_position", "m", default=0.0, lower=-1.0, upper=1.0)
#: Where the tip touches first is known to 30 um.
TOUCH = Constant(CONTACT_POSITION, 0.0, 3e-5)
