"""A resonance of what the tip is joined to."""

import math
from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.dynamic_stiffness import tissue_of, together
from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Parameter, State
from tissue_probe.physics.extent import Extent

MODAL_MASS = sp.Symbol("modal_mass", real=True)
MODAL_FREQUENCY = sp.Symbol("modal_frequency", positive=True)
RATIO = sp.Symbol("modal_damping_ratio", positive=True)
OFFSET, SPEED = sp.symbols("modal_displacement modal_velocity", real=True)
# What is bolted together loses half a per cent and more; less would ring through a recording.
LEAST_RATIO = 5e-3
LOWEST, HIGHEST = 3.0, 400.0  # Hz
_OMEGA = 2 * sp.pi * MODAL_FREQUENCY
# Force per mass that the spring and damper exert on the modal mass, which lags the tip by OFFSET.
_PULL = _OMEGA**2 * OFFSET + 2 * RATIO * _OMEGA * (TIP_VELOCITY - SPEED)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose resonances from a quarter of the motion's frequency to twelve times, closer within.

    Of a sweep that is the frequency at its end. Within the motion a resonance is met at once; above
    it is felt from afar, or met by harmonics. One that is narrow lies where a model without it
    leaves most.
    """
    at, loudest = extent.frequency / (2.0 * math.pi), extent.left_at / (2.0 * math.pi)
    over = (0.25, 0.32, 0.4, 0.5, 0.67, 0.83, 1.2, 1.7, 2.5, 4.2, 7.0, 12.0)
    tried = [*(at * each for each in over), *([loudest] if loudest else [])]
    inside = dict.fromkeys(min(max(each, LOWEST), HIGHEST) for each in tried)
    return [{"modal_frequency": each, "modal_damping_ratio": 0.05} for each in inside]


def near(extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
    """Propose other resonances above the motion, light and heavy, the tissue making up for them.

    At one frequency a mass and a softer tissue are alike: they lie along a valley too long for a
    search, and beside it each of the motion's faint harmonics has a resonance of its own.
    """
    at = extent.frequency
    known = found[str(MODAL_MASS)] * _per_mass(at, found[str(MODAL_FREQUENCY)], found[str(RATIO)])
    whole = together(at, found, known)
    proposed = []
    for frequency in (at / (2.0 * math.pi) * over for over in (1.5, 3.0, 6.0, 12.0)):
        for mass in (0.02, 0.08):
            rest = tissue_of(at, whole - mass * _per_mass(at, frequency, 0.05))
            own = {str(MODAL_MASS): mass, str(MODAL_FREQUENCY): frequency, str(RATIO): 0.05}
            proposed.append({**own, **rest})
    return proposed


def _per_mass(at: float, frequency: float, ratio: float) -> complex:
    """Dynamic stiffness of a mode over its mass [1/s^2] at an angular frequency [rad/s]."""
    own = 2.0 * math.pi * frequency
    spring = own**2 + 2j * ratio * own * at
    return -(at**2) * spring / (spring - at**2)


STRUCTURAL_MODE = Effect(
    name="structural_mode",
    family="inertia",
    physics="A mass on a spring and a damper, joined to the tip, resonates",
    says="a part resonates at {modal_frequency:Hz}",
    parameters=(
        Parameter(MODAL_MASS, "kg", default=0.005, lower=0.0, upper=1.0),
        Parameter(MODAL_FREQUENCY, "Hz", default=60.0, lower=LOWEST, upper=HIGHEST),
        Parameter(RATIO, "1", default=0.05, lower=LEAST_RATIO, upper=1.5),
    ),
    drag=MODAL_MASS * _PULL,
    states=(
        State(OFFSET, TIP_VELOCITY - SPEED, spread="length"),
        State(SPEED, _PULL, spread="speed"),
    ),
    starts=starts,
    near=near,
    simpler=("added_mass",),
    assumptions="One mode; light enough to be a vibration absorber on the tip",
    reference="Den Hartog, Mechanical Vibrations (1956), section 3.2",
)
