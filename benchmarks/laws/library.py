"""The library before the newer laws: what it had, and what is newer than it.

Contents: the effects that it had with their forms, and the names of the newer ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from tissue_probe.challenge.simulator import LIBRARY
from tissue_probe.physics.effects import EFFECTS, Effect

#: The effects of the library before, each with the number of its further forms. All others of the
#: library are newer.
BEFORE: Mapping[str, int] = {
    "standard_linear_solid": 0,
    "generalized_maxwell": 0,
    "springpot": 0,
    "cubic_stiffening": 0,
    "exponential_stiffening": 1,
    "hertz_contact": 1,
    "hunt_crossley": 2,
    "contact_loss": 1,
    "adhesion": 0,
    "coulomb_friction": 1,
    "stribeck_friction": 1,
    "bouc_wen_hysteresis": 1,
    "backlash": 1,
    "added_mass": 0,
    "structural_mode": 0,
    "force_gain": 0,
    "load_cell_stiffness_error": 0,
    "force_bias": 0,
    "force_drift": 1,
    "zero_by_part": 0,
    "tissue_motion": 0,
    "mains_hum": 0,
    "force_lag": 0,
    "channel_delay": 0,
    "encoder_quantization": 0,
    "encoder_interpolation": 0,
    "stiffness_step": 0,
    "stiffness_ramp": 0,
}
#: It has a form more than before, which the challenge hides by this value (any but that of before).
NEW_FORM = {"bouc_wen_hysteresis": ("bouc_beta", 0.5)}
#: It follows a further channel, which the challenge does not record: hidden here.
BY_CHANNEL = "second_input"


def take_library_before() -> dict[str, Effect]:
    """Return the effects of the library before, without their newer forms."""
    return {
        name: replace(EFFECTS[name], forms=EFFECTS[name].forms[:forms])
        for name, forms in BEFORE.items()
    }


def list_newer_laws() -> tuple[str, ...]:
    """Name the effects of the library that are newer, or have a newer form, and can be hidden."""
    return tuple(
        name
        for name in EFFECTS
        if name in NEW_FORM or (name not in BEFORE and (name in LIBRARY or name == BY_CHANNEL))
    )
