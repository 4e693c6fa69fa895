"""Rigs: how an instrument couples to tissue and to further effects, a file each.

Contents: the table of rigs, and choosing from it.

Nothing else in the package knows a rig by its name: it asks a rig for a property. Of all this
nothing imports SymPy, or NumPy, before a model is composed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from tissue_probe.physics.rigs.compliant_probe import COMPLIANT_PROBE
from tissue_probe.physics.rigs.constants import Constant
from tissue_probe.physics.rigs.force_driven import FORCE_DRIVEN
from tissue_probe.physics.rigs.rig import Live, Rig
from tissue_probe.physics.rigs.rigid_probe import RIGID_PROBE

RIGS: dict[str, Rig] = {rig.name: rig for rig in (COMPLIANT_PROBE, RIGID_PROBE, FORCE_DRIVEN)}
#: This suite's own probe, which is meant where no rig is named.
OWN = COMPLIANT_PROBE
RigName = Literal["compliant_probe", "rigid_probe", "force_driven"]
"""Names in ``RIGS``, for checkers of types."""
FilteredRig = Literal["compliant_probe", "rigid_probe"]
"""Those of them whose samples filters take (``Live``)."""
#: The declarations of the constants in ``RIGS``, by name.
CONSTANTS = {each.name: each.entry for rig in RIGS.values() for each in rig.constants}


def rig_of(rig: Rig | str) -> Rig:
    """Return a rig, which may be a user's own, or that of a name in ``RIGS``.

    Raises
    ------
    KeyError
        If there is no such name.
    """
    return RIGS[rig] if isinstance(rig, str) else rig


def name_rigs(which: Callable[[Rig], bool]) -> str:
    """Return the names of the rigs in ``RIGS`` of which something holds, as a sentence has them."""
    return " or ".join(rig.name for rig in RIGS.values() if which(rig))


__all__ = [
    "COMPLIANT_PROBE",
    "CONSTANTS",
    "FORCE_DRIVEN",
    "OWN",
    "RIGID_PROBE",
    "RIGS",
    "Constant",
    "FilteredRig",
    "Live",
    "Rig",
    "RigName",
    "name_rigs",
    "rig_of",
]
