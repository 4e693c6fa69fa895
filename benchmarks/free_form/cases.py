"""Records with a force that the base model lacks, by the challenge's simulator, and a second one.

Contents: what is hidden, on which variables it depends, how strong it is made.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tissue_probe.challenge.case import Case
from tissue_probe.challenge.instrument import CHALLENGE_RATE, FORCE_NOISE, InstrumentErrors
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.strength import SEARCH_RATE
from tissue_probe.challenge.trajectory import DURATIONS, MULTISINE_LINES, Trajectory
from tissue_probe.signals import FloatArray

#: Excitations in the order of the rows: the last one is a single loop.
EXCITATIONS = ("msine60", "chirp60", "stepped30", "sine10", "sine10ss")
#: What the best Kelvin-Voigt fit leaves, in multiples of the noise.
STRENGTHS = (2.0, 6.0, 20.0)
#: The motion of the second record and its amplitude [m]: other frequencies, and mostly inside the
#: depths and speeds of the first.
SECOND = {
    "msine60": ("chirp60", 0.3e-3),
    "chirp60": ("msine60", 0.5e-3),
    "stepped30": ("msine60", 0.4e-3),
    "sine10": ("stepped30", 0.3e-3),
    "sine10ss": ("stepped30", 0.3e-3),
}
#: Peak velocity by which forces of the speed are scaled [m/s].
SPEED = 0.1

Change = Callable[[float, Specimen], dict[str, object]]


def _relaxing(curved: float, cubic: float) -> Change:
    def change(s: float, at: Specimen) -> dict[str, object]:
        return {
            "branch_stiffness": (s * at.stiffness,),
            "branch_rate": (20.0,),
            "branch_curved": curved,
            "cubic": cubic * s * at.stiffness / 1e-6,
        }

    return change


#: What is hidden, by name: the variables that it depends on, and how it is made.
TERMS: dict[str, tuple[frozenset[str], Change]] = {
    "cubic spring": (
        frozenset(["indentation"]),
        lambda s, at: {"cubic": s * at.stiffness / 1e-6},
    ),
    "softening spring": (
        frozenset(["indentation"]),
        lambda s, at: {"hyperbola_depth": 1e-3 / s},
    ),
    "wavy surface": (
        frozenset(["indentation"]),
        lambda s, at: {"corrugation": 0.1 * s, "corrugation_period": 8e-4},
    ),
    "quadratic drag": (
        frozenset(["velocity"]),
        lambda s, at: {"drag": s * at.damping / SPEED},
    ),
    "dry friction": (
        frozenset(["velocity"]),
        lambda s, at: {"coulomb": 0.1 * s, "static": 0.1 * s},
    ),
    "damping with depth": (
        frozenset(["indentation", "velocity"]),
        lambda s, at: {"depth_damping": s * at.damping / 1e-3},
    ),
    "stiffening with speed": (
        frozenset(["indentation", "velocity"]),
        lambda s, at: {"rate_stiffening": s / SPEED},
    ),
    "relaxation": (frozenset(["past"]), _relaxing(0.0, 0.0)),
    "relaxation of a cubic spring": (frozenset(["indentation", "past"]), _relaxing(1.0, 1.0)),
    "hysteresis": (
        frozenset(["path"]),
        lambda s, at: {"bouc_force": 0.1 * s, "bouc_yield": 2e-4},
    ),
}


@dataclass(frozen=True, eq=False)
class Record:
    """What was measured, and what is true of it.

    ``truth`` are the variables of the hidden force, none where the record is clean; ``second`` is
    of another amplitude and motion.
    """

    term: str
    truth: frozenset[str]
    excitation: str
    strength: float
    time: FloatArray
    first: tuple[FloatArray, FloatArray]
    second: tuple[FloatArray, FloatArray]


def record(term: str, excitation: str, strength: float, seed: int) -> Record:
    """Simulate a record; with the ``term`` "clean" nothing is hidden."""
    random = np.random.default_rng(seed)
    specimen = Specimen(
        stiffness=float(np.exp(random.uniform(np.log(250.0), np.log(1200.0)))),
        damping=float(random.uniform(2.0, 8.0)),
    )
    first = _moving(random, excitation, random.uniform(0.9e-3, 1.1e-3))
    other, amplitude = SECOND[excitation]
    second = _moving(random, other, amplitude)
    truth, change = TERMS.get(term, (frozenset[str](), lambda s, at: {}))
    case = Case(specimen, InstrumentErrors(), first)
    if truth:
        case = replace(case, specimen=_as_strong(case, change, strength))
    another = replace(case, trajectory=second)
    time = np.arange(case.samples) / CHALLENGE_RATE
    return Record(
        *(term, truth, excitation, strength, time, _measured(case, random)),
        _measured(another, random),
    )


def _moving(random: np.random.Generator, kind: str, amplitude: float) -> Trajectory:
    phases = tuple(random.uniform(0.0, 2.0 * np.pi, MULTISINE_LINES).tolist())
    return Trajectory(kind, amplitude, min(DURATIONS[kind], 4.0), phases=phases)


def _as_strong(case: Case, change: Change, target: float) -> Specimen:
    """Return the specimen with a term that leaves so much of the best Kelvin-Voigt fit."""
    plain = case.specimen
    low, high = 1e-3, 3.0
    for _ in range(14):
        middle = float(np.sqrt(low * high))
        changed = plain._replace(**change(middle, plain))
        left = replace(case, specimen=changed).ratio(plain, SEARCH_RATE)
        low, high = (middle, high) if left < target else (low, middle)
    return plain._replace(**change(low, plain))


def _measured(case: Case, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    return case.measure(FORCE_NOISE * random.standard_normal(case.samples))
