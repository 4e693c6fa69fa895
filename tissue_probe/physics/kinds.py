"""Which rigs and tissues there are, and of each what is known without its equations.

What belongs here: names, signals, which effects a tissue consists of. What does not: the equations
(``rigs``, ``tissues``, ``effects``), which take SymPy.
"""

from __future__ import annotations

from tissue_probe.quantities import FORCE, POSITION, Quantity

#: Of each rig the signal that drives it, and the one that is predicted.
SIGNALS: dict[str, tuple[Quantity, Quantity]] = {
    "compliant_probe": (POSITION, FORCE),
    "rigid_probe": (POSITION, FORCE),
    "force_driven": (FORCE, POSITION),
}
#: By how much a channel may be late; what is later is no channel of one instrument [s].
LONGEST_DELAY = 0.02
#: By how much the force may be early: so late a filter of some hundred hertz makes the position. A
#: force that is earlier has another clock [s].
MOST_EARLY = 5e-3
#: Family of the effects by which a tissue gives way in time.
RELAXATION = "relaxation"
#: Of each tissue the effects that belong to it: the solids of the paper's Table I with branches are
#: the Kelvin-Voigt solid with relaxation beside it.
TISSUE_EFFECTS: dict[str, tuple[str, ...]] = {
    "kelvin_voigt": (),
    "maxwell": (),
    "standard_linear_solid": ("standard_linear_solid",),
    "generalized_maxwell": ("generalized_maxwell",),
}
