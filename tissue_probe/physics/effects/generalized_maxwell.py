"""Stress relaxation with two time constants, or three."""

from tissue_probe.physics.branches import THREE, TWO, Branches
from tissue_probe.physics.effects.effect import TIP_VELOCITY, Effect


def _form(branches: Branches, count: str, forms: tuple[Effect, ...] = ()) -> Effect:
    return Effect(
        name="generalized_maxwell",
        family="relaxation",
        physics="Two or three springs, each in series with a damper, beside the tissue: as many "
        "relaxation times",
        says=f"it relaxes within {branches.times}",
        parameters=branches.parameters,
        force=branches.force,
        states=branches.states(TIP_VELOCITY),
        strengths=branches.count,
        starts=branches.starts,
        near=branches.near,
        forms=forms,
        simpler=("standard_linear_solid",),
        excludes=("springpot", "standard_linear_solid", "quasi_linear_relaxation"),
        assumptions=f"Small strains; {count} relaxation times a factor apart",
        reference="Wiechert (1893); Fung, Biomechanics (1993), section 2.11",
    )


GENERALIZED_MAXWELL = _form(TWO, "two", (_form(THREE, "three"),))
