"""Recordings of the challenge, as what is fitted: their simulator shares no code with the fit."""

from __future__ import annotations

from functools import cache

import pytest

from tissue_probe.challenge.coil import Coil
from tissue_probe.challenge.simulator import Challenge, make_challenge
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.effects import EFFECTS

TOLERANT = Instrument()
EXACT = TOLERANT.exact()


@cache
def challenge(
    seed: int,
    *effects: str,
    excitation="sine10",
    rig="exact",
    preload: float | None = None,
    coil: Coil | None = None,
) -> Challenge:
    return make_challenge(seed, effects, excitation, rig, preload, coil)


def measurement(made, at_rest=True) -> Measurement:
    return Measurement(made.position, made.force, made.sample_period, at_rest)


def first_of(cases, kept: int) -> list:
    """Return cases of which ``make test`` takes the first few, ``make test-slow`` the others."""
    return [
        case
        if place < kept
        else pytest.param(
            *(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.battery
        )
        for place, case in enumerate(cases)
    ]


def library(*names):
    """Return a few effects of the library, by name."""
    return {name: EFFECTS[name] for name in names}
