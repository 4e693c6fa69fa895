"""Effects that the library does not have: the right answer to them is ``unexplained``.

Contents: physics that a probe may well meet.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.challenge.change import Change, HiddenEffect, Situation, log_uniform, sign

Random = np.random.Generator


def _prandtl_tomlinson(strength: float, at: Situation, random: Random) -> Change:
    """Slide over a corrugated surface (Prandtl, 1928; Tomlinson, 1929)."""
    period = log_uniform(random, 1e-4, 4e-4)
    return Change({"corrugation": strength, "corrugation_period": period})


def _zero_jump(strength: float, at: Situation, random: Random) -> Change:
    """Pull at the load cell's cable."""
    time = random.uniform(0.2, 0.8) * at.duration
    return Change(instrument={"jump": sign(random) * strength, "jump_time": time})


def _rate_stiffening(strength: float, at: Situation, random: Random) -> Change:
    return Change({"rate_stiffening": strength / at.speed})


def _amplitude_softening(strength: float, at: Situation, random: Random) -> Change:
    time = log_uniform(random, 0.05, 0.3)
    return Change({"softening": strength / at.depth, "softening_time": time})


def _interference_bursts(strength: float, at: Situation, random: Random) -> Change:
    return Change(
        instrument={
            "burst": strength,
            "burst_frequency": random.uniform(70.0, 190.0),
            "burst_period": random.uniform(0.3, 0.9),
        }
    )


def _parametric_damping(strength: float, at: Situation, random: Random) -> Change:
    """Let the damping come and go, as of a muscle that trembles."""
    frequency = random.uniform(3.0, 9.0)
    return Change({"damping_wave": strength, "damping_wave_frequency": frequency})


OUTSIDE: dict[str, HiddenEffect] = {
    "prandtl_tomlinson": HiddenEffect("outside", _prandtl_tomlinson, 2e-3, 0.05, 0.5),
    "zero_jump": HiddenEffect("outside", _zero_jump, 2e-3, 0.05, 1.0),
    "rate_stiffening": HiddenEffect("outside", _rate_stiffening, 5e-4, 0.3, 5.0),
    "amplitude_softening": HiddenEffect("outside", _amplitude_softening, 1e-3, 1.2, 10.0),
    "interference_bursts": HiddenEffect("outside", _interference_bursts, 2e-3, 0.03, 0.5),
    "parametric_damping": HiddenEffect("outside", _parametric_damping, 1e-3, 0.3, 0.95),
}
"""Effects outside the library, by name."""
