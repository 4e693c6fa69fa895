"""Names that a user chooses from; apart from their meaning, which takes a second to be imported."""

from __future__ import annotations

from typing import Literal, get_args

from tissue_probe.physics.rigs import OWN, RIGS, Rig, RigName
from tissue_probe.physics.rigs import FilteredRig as FilteredRig
from tissue_probe.physics.tissue_names import TissueName as TissueName

RigChoice = RigName | Rig
"""How the instrument couples to the tissue (``physics.rigs``): a name, or a rig of one's own."""

Starts = Literal["auto", "at-rest", "moving"]
"""Whether the probe had been at rest before the first sample."""
Course = Literal["auto", "smooth", "straight", "held", "jumping"]
"""How a force that drives goes on between two samples (``physics.response.Between``)."""

RIG_NAMES: tuple[RigName, ...] = get_args(RigName)
#: The rig of this suite's own recordings, and of filters where none is named.
OWN_RIG: RigName = next(name for name in RIG_NAMES if name == OWN.name)
#: Of each rig its name, whose it is, and its drawing (SVG).
RIG_CARDS = [{"name": r.name, "whose": r.whose, "drawing": r.drawing} for r in RIGS.values()]
FILTERED_RIGS: tuple[FilteredRig, ...] = get_args(FilteredRig)
TISSUE_NAMES: tuple[TissueName, ...] = get_args(TissueName)
START_CHOICES: tuple[Starts, ...] = get_args(Starts)
COURSES: tuple[Course, ...] = get_args(Course)
