"""Names that a user chooses from; apart from their meaning, which takes a second to be imported."""

from __future__ import annotations

from typing import Literal, get_args

RigName = Literal["compliant_probe", "rigid_probe", "force_driven"]
"""How the instrument couples to the tissue (``physics.rigs``)."""
FilteredRig = Literal["compliant_probe", "rigid_probe"]
"""Those of them that filters run on."""
TissueName = Literal["kelvin_voigt", "maxwell", "standard_linear_solid", "generalized_maxwell"]
"""Table I of the paper (``physics.tissues``)."""
Starts = Literal["auto", "at-rest", "moving"]
"""Whether the probe had been at rest before the first sample."""
Course = Literal["auto", "smooth", "straight", "held", "jumping"]
"""How a force that drives goes on between two samples (``physics.response.Between``)."""

RIG_NAMES: tuple[RigName, ...] = get_args(RigName)
FILTERED_RIGS: tuple[FilteredRig, ...] = get_args(FilteredRig)
TISSUE_NAMES: tuple[TissueName, ...] = get_args(TissueName)
STARTS: tuple[Starts, ...] = get_args(Starts)
COURSES: tuple[Course, ...] = get_args(Course)
