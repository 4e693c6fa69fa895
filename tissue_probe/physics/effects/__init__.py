"""Physical effects beyond Kelvin-Voigt tissue. A new one is a file here and a line below."""

from tissue_probe.physics.effects.effect import Effect, Parameter
from tissue_probe.physics.effects.hardening import HARDENING
from tissue_probe.physics.effects.relaxation import RELAXATION

__all__ = ["EFFECTS", "Effect", "Parameter"]

EFFECTS = {effect.name: effect for effect in (RELAXATION, HARDENING)}
