"""A resonance of what the tip is joined to."""

import sympy as sp

from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Extent, Parameter, State

MASS = sp.Symbol("modal_mass", real=True)
FREQUENCY = sp.Symbol("modal_frequency", positive=True)
RATIO = sp.Symbol("modal_damping_ratio", positive=True)
OFFSET, SPEED = sp.symbols("modal_displacement modal_velocity", real=True)
_OMEGA = 2 * sp.pi * FREQUENCY
# Force per mass that the spring and damper exert on the modal mass, which lags the tip by OFFSET.
_PULL = _OMEGA**2 * OFFSET + 2 * RATIO * _OMEGA * (TIP_VELOCITY - SPEED)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose resonances from 15 to 300 Hz."""
    frequencies = (15.0, 25.0, 35.0, 50.0, 70.0, 100.0, 150.0, 250.0)
    return [{"modal_frequency": f, "modal_damping_ratio": 0.05} for f in frequencies]


STRUCTURAL_MODE = Effect(
    name="structural_mode",
    family="inertia",
    physics="A mass on a spring and a damper, joined to the tip, resonates",
    parameters=(
        Parameter(MASS, "kg", default=0.005, lower=0.0, upper=1.0),
        Parameter(FREQUENCY, "Hz", default=60.0, lower=3.0, upper=400.0),
        Parameter(RATIO, "1", default=0.05, lower=1e-3, upper=1.5),
    ),
    drag=MASS * _PULL,
    states=(
        State(OFFSET, TIP_VELOCITY - SPEED, spread="length"),
        State(SPEED, _PULL, spread="speed"),
    ),
    starts=starts,
    simpler=("added_mass",),
    assumptions="One mode; light enough to be a vibration absorber on the tip",
    reference="Den Hartog, Mechanical Vibrations (1956), section 3.2",
)
