"""Which tissues there are, and their facts without equations.

Contents: names, which effects a tissue consists of, how far channels may be apart.
"""

from __future__ import annotations

#: By how much a channel may be late; a later one is no channel of one instrument [s].
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
