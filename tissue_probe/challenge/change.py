"""What an effect is to a challenge: a family, a range of strengths, and what it sets.

Contents: the shape of an entry in the tables.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tissue_probe.challenge.specimen import Specimen


@dataclass(frozen=True)
class Situation:
    """What an effect is scaled by.

    Attributes
    ----------
    specimen : Specimen
        Rig and tissue.
    amplitude, preload, duration : float
        Of the coil's motion [m], [m], [s].
    highest : float
        Highest frequency of the excitation [Hz].
    """

    specimen: Specimen
    amplitude: float
    preload: float
    duration: float
    highest: float

    @property
    def depth(self) -> float:
        """Deepest displacement of the coil [m]."""
        return self.preload + self.amplitude

    @property
    def speed(self) -> float:
        """Speed of the coil in a sine of 10 Hz [m/s]."""
        return 2.0 * np.pi * 10.0 * self.amplitude


@dataclass(frozen=True)
class Change:
    """Numbers that an effect sets, by name; ``preload`` only if it needs one of its own [m]."""

    specimen: dict[str, Any] = field(default_factory=dict)
    instrument: dict[str, Any] = field(default_factory=dict)
    preload: float | None = None


@dataclass(frozen=True)
class HiddenEffect:
    """An effect to hide.

    Attributes
    ----------
    family : str
        Kinds that are taken for one another.
    make : callable
        ``make(strength, situation, random)`` gives the Change; whatever it draws at random does not
        depend on the strength.
    weakest, typical, strongest : float
        Range of strengths; ``typical`` shows clearly unless a Kelvin-Voigt model absorbs it.
    sets_preload : bool
        Whether it needs a preload of its own.
    beside : tuple of str
        Effects of which one has to be hidden too, since it is another one without; none usually.
    """

    family: str
    make: Callable[[float, Situation, np.random.Generator], Change]
    weakest: float
    typical: float
    strongest: float
    sets_preload: bool = False
    beside: tuple[str, ...] = ()


def log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    """Draw a number whose logarithm is uniform."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def sign(random: np.random.Generator) -> float:
    """Draw -1 or 1."""
    return float(random.choice((-1.0, 1.0)))
