"""Poroelastic relaxation: fluid in the pores bears a part of the force until it has flowed away.

F = k x + integral of K g(D (t - s) / a^2) dx(s) beside the damping. D is the diffusivity of the
fluid in the tissue [m^2/s], a the radius of the contact [m], and K by how much more stiffly the
tissue answers before any fluid has moved [N/m]. Under a sphere

    g(T) = 0.491 exp(-0.908 sqrt(T)) + 0.509 exp(-1.679 T);

under a cone it is that of a sphere at 0.807 T, to 0.001; and under a flat punch

    g(T) = 1.304 exp(-sqrt(T)) - 0.304 exp(-0.254 T).

As a differential equation, g is a sum of exponentials of fixed weights and rates, so that the law
has two numbers, K and D / a^2. K / k is 1 - 2 n, with n Poisson's ratio of the tissue after its
fluid has moved.

It is tried only where it is asked for. A time of diffusion is 0.1 s to a month: D is 1e-11 to 1e-9
m^2/s in gels and tissues, and a is 10 um to 5 mm. Most recordings last seconds, under tips of
millimetres: their fluid has no time to flow, and the relaxation in them is another one.
"""

from collections.abc import Mapping

import sympy as sp

from tissue_probe.physics.dynamic_stiffness import hand_over, of_branch
from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect, Parameter, State
from tissue_probe.physics.extent import SLOWEST_RELAXATION, Extent

FLUID_STIFFNESS = sp.Symbol("fluid_stiffness", real=True)
DIFFUSION_RATE = sp.Symbol("diffusion_rate", positive=True)
Kernel = tuple[tuple[float, float], ...]
#: Weights and rates over D / a^2 of as many exponentials, of which g differs by 0.001 at most after
#: T = 1 / 300: the damping stands for faster relaxation. Up to the angular frequency 300 D / a^2
#: their largest error is the least that so many leave.
_OF_SPHERE = (
    (0.08266, 0.11558),
    (0.168, 0.44974),
    (0.6324, 1.7317),
    (0.06973, 10.266),
    (0.03203, 74.873),
)
#: The same under a flat punch, of which g differs by 0.0013.
_OF_PUNCH = (
    (0.07871, 0.09424),
    (0.3922, 0.86976),
    (0.27, 3.5353),
    (0.1473, 17.063),
    (0.07178, 105.19),
)
FLUID_BRANCHES = sp.symbols(f"fluid_branch_1:{len(_OF_SPHERE) + 1}", real=True)


def starts(extent: Extent) -> list[dict[str, float]]:
    """Propose rates two a decade, from those seen in the whole record to the tip's own."""
    slowest = SLOWEST_RELAXATION / extent.duration
    return [{str(DIFFUSION_RATE): slowest * 10 ** (i / 2)} for i in range(7)]


def _form(kernel: Kernel, assumptions: str, forms: tuple[Effect, ...] = ()) -> Effect:
    def at(frequency: float, rate: float) -> complex:
        """Dynamic stiffness over K at an angular frequency [rad/s] and a rate D / a^2 [1/s]."""
        return sum((w * of_branch(frequency, r * rate) for w, r in kernel), 0j)

    def near(extent: Extent, found: Mapping[str, float]) -> list[dict[str, float]]:
        """Propose other rates, and most or half of the tissue's dynamic stiffness for the fluid.

        At one frequency tissue and fluid are alike, and lie along a valley too long for a search.
        """
        name, rate = str(FLUID_STIFFNESS), str(DIFFUSION_RATE)
        known = found[name] * at(extent.frequency, found[rate])
        proposed = []
        for other in (extent.frequency * f for f in (0.03, 0.1, 0.3, 1.0)):
            unit = at(extent.frequency, other)
            for share in (0.5, 0.95):
                stiffness, rest = hand_over(extent.frequency, found, known, unit, share)
                proposed.append({name: stiffness, rate: other, **rest})
        return proposed

    return Effect(
        name="poroelastic_relaxation",
        family="relaxation",
        physics="Fluid in the pores bears a force that falls as g(D t / a^2) while it flows away",
        says="fluid bears {fluid_stiffness:N/m} at first, and flows away within "
        "{diffusion_rate:period} (a^2/D)",
        parameters=(
            Parameter(FLUID_STIFFNESS, "N/m", default=300.0, lower=0.0, upper=1e5),
            Parameter(DIFFUSION_RATE, "1/s", default=5.0, lower=1e-4, upper=500.0),
        ),
        force=FLUID_STIFFNESS
        * sum(w * e for (w, _), e in zip(kernel, FLUID_BRANCHES, strict=True)),
        states=tuple(
            State(e, TIP_VELOCITY - r * DIFFUSION_RATE * e, spread="branch")
            for (_, r), e in zip(kernel, FLUID_BRANCHES, strict=True)
        ),
        starts=starts,
        near=near,
        forms=forms,
        odds=0.0,
        excludes=(
            *("standard_linear_solid", "generalized_maxwell", "springpot"),
            "quasi_linear_relaxation",
        ),
        assumptions=f"{assumptions}; small strains; the contact's radius stays as it is, and with "
        "it the time of diffusion; tissue deeper and wider than the contact; fluid passes its free "
        "surface",
        reference="Hu, Zhao, Vlassak and Suo, Applied Physics Letters 96 (2010), 121904; Biot, J. "
        "Applied Physics 12 (1941), 155",
    )


_UNDER_PUNCH = _form(_OF_PUNCH, "A flat punch")
POROELASTIC_RELAXATION = _form(_OF_SPHERE, "A sphere, or a cone", (_UNDER_PUNCH,))
