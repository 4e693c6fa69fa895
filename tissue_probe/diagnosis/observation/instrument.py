"""The instrument that took samples: the rig, and its constants with their tolerances.

Contents: the constants of the probe and their tolerances.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tissue_probe.physics.rigs import OWN, Rig, rig_of
from tissue_probe.physics.rigs.constants import CONTACT_POSITION
from tissue_probe.physics.scale import Scale

#: The rms of a load cell's 1/f noise, by name.
FLICKER_NAME = "flicker_noise"


@dataclass(frozen=True)
class Instrument:
    """The rig, and its constants as (value, standard deviation), SI units.

    A deviation of 0 says that the constant is known; every other is fitted within its tolerance.
    ``flicker_noise`` is the rms of the load cell's 1/f noise over a recording [N]. Where they are
    not given, both are the rig's own. ``supposed`` names constants that nobody gave. The rig may be
    given by its name in ``RIGS``. With ``any_zero`` the zero of the position may be anywhere; with
    ``free_touch`` each run says where its tip touches.
    """

    rig: Rig = OWN
    # Those of the rig, where none are given.
    constants: Mapping[str, tuple[float, float]] = None  # type: ignore[assignment]
    flicker_noise: float | None = None
    supposed: frozenset[str] = frozenset()
    any_zero: bool = False
    free_touch: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "rig", rig_of(self.rig))
        if self.constants is None:
            object.__setattr__(self, "constants", self.rig.known)
        if self.flicker_noise is None:
            object.__setattr__(self, "flicker_noise", self.rig.flicker_noise)
            object.__setattr__(self, "supposed", self.supposed | {FLICKER_NAME})

    @property
    def of_run(self) -> tuple[str, ...]:
        """Constants that belong to a run."""
        return (CONTACT_POSITION.name,) if self.free_touch else ()

    def of_size(self, scale: Scale) -> Instrument:
        """Return the instrument of a record of a size: constants not given are scaled by it."""
        units = {each.name: each.entry.unit for each in self.rig.constants} | {FLICKER_NAME: "N"}
        factors = {
            name: scale.of(unit) if name in self.supposed else 1.0 for name, unit in units.items()
        }
        constants = {
            name: (factors.get(name, 1.0) * value, factors.get(name, 1.0) * deviation)
            for name, (value, deviation) in self.constants.items()
        }
        flicker = factors[FLICKER_NAME] * (self.flicker_noise or 0.0)
        return replace(self, constants=constants, flicker_noise=flicker)

    def exact(self) -> Instrument:
        """Return the same instrument, its constants taken as known but those that nobody gave.

        Its noise is white.
        """
        held = {n: (v, d if np.isinf(d) else 0.0) for n, (v, d) in self.constants.items()}
        return replace(self, constants=held, flicker_noise=0.0)
