"""A composed model by name: rig, tissue and effects, its numbers' names and units, its kernel.

What belongs here: what a model file names, and the way from there to symbols and compiled code.
What does not: values (``diagnosis``), equations (``rigs``, ``tissues``, ``effects``).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache, cached_property

from tissue_probe.physics.effects import EFFECTS, Effect, Parameter
from tissue_probe.physics.effects.effect import DAMPING, STIFFNESS
from tissue_probe.physics.model import Model
from tissue_probe.physics.response import Kernel
from tissue_probe.physics.response_code import source
from tissue_probe.physics.rigs import CELL_DAMPING, CELL_STIFFNESS, CONTACT, MASS, RIGS
from tissue_probe.physics.tissues import TISSUES
from tissue_probe.quantities import FORCE, Quantity

#: What a kernel depends on besides its effects, whose text is part of its name.
SOURCES = (
    "physics/coil_course.py",
    "physics/effects/effect.py",
    "physics/machine_code.py",
    "physics/model_functions.py",
    "physics/program.py",
    "physics/response_code.py",
    "physics/rigs.py",
    "physics/runge_kutta.py",
    "physics/tissues.py",
    "physics/transition.py",
)
CONSTANTS = (
    Parameter(MASS, "kg", default=0.04, lower=0.0, upper=1e4),
    Parameter(CELL_STIFFNESS, "N/m", default=9700.0, lower=1.0, upper=1e8),
    Parameter(CELL_DAMPING, "N s/m", default=0.8, lower=0.0, upper=1e4),
    Parameter(CONTACT, "m", default=0.0, lower=-1.0, upper=1.0),
)
#: Where a force drives, it divides by the mass [kg].
LIGHTEST = 1e-6
#: A tissue that pulls back when it is let go, or drives, is none: what seems so is another effect.
TISSUE = (
    Parameter(STIFFNESS, "N/m", default=450.0, lower=0.0, upper=1e9),
    Parameter(DAMPING, "N s/m", default=5.0, lower=0.0, upper=1e6),
)


@dataclass(frozen=True)
class Composition:
    """Rig, tissue and effects of one model.

    Attributes
    ----------
    rig, tissue : str
        Names in ``RIGS`` and ``TISSUES``.
    effects : tuple of Effect
        Further physics, in the order in which it is applied.
    """

    rig: str = "compliant_probe"
    tissue: str = "kelvin_voigt"
    effects: tuple[Effect, ...] = ()

    @property
    def all_effects(self) -> tuple[Effect, ...]:
        """The effects that the tissue consists of, then those added to it."""
        return (*(EFFECTS[name] for name in TISSUES[self.tissue].effects), *self.effects)

    @property
    def names(self) -> tuple[str, ...]:
        """The effects' names, the tissue's own among them."""
        return tuple(effect.name for effect in self.all_effects)

    @property
    def input(self) -> Quantity:
        """The signal that drives the model."""
        return RIGS[self.rig].input

    @property
    def output(self) -> Quantity:
        """The signal that the model predicts."""
        return RIGS[self.rig].output

    def plus(self, effect: Effect) -> Composition:
        """Return the model with one effect more."""
        return _composed(self.rig, self.tissue, (*self.effects, effect))

    def without(self, name: str) -> Composition:
        """Return the model with one effect less."""
        kept = tuple(effect for effect in self.effects if effect.name != name)
        return _composed(self.rig, self.tissue, kept)

    def having(self, form: Effect) -> Composition:
        """Return the model with the effect of the same name in this form."""
        effects = (form if each.name == form.name else each for each in self.effects)
        return _composed(self.rig, self.tissue, tuple(effects))

    @cached_property
    def model(self) -> Model:
        """The symbols."""
        tissue = TISSUES[self.tissue]
        return RIGS[self.rig].compose(self.all_effects, tissue=tissue, contact_position=True)

    @cached_property
    def kernel(self) -> Kernel:
        """The compiled code, made where no earlier process has."""
        said = "\n".join((self.rig, self.tissue, *map(_text, self.effects)))
        digest = hashlib.sha256(said.encode()).hexdigest()[:16]
        return Kernel.load(f"response_{digest}", lambda: source(self.model), SOURCES)

    @cached_property
    def values(self) -> tuple[Parameter, ...]:
        """Constants and parameters in the kernel's order, with units and bounds."""
        return self.entries(self.kernel.values)

    def entries(self, names: Iterable[str]) -> tuple[Parameter, ...]:
        """Return what is declared of constants and parameters of these names."""
        known = {entry.name: entry for entry in (*CONSTANTS, *TISSUE)}
        if self.input is FORCE:
            known[str(MASS)] = replace(known[str(MASS)], lower=LIGHTEST)
        own = {entry.name: entry for effect in self.all_effects for entry in effect.parameters}
        return tuple((known | own)[name] for name in names)


@cache
def _composed(rig: str, tissue: str, effects: tuple[Effect, ...]) -> Composition:
    """Return the same model for the same parts: a diagnosis composes each many times over."""
    return Composition(rig, tissue, effects)


@cache
def _text(effect: Effect) -> str:
    """Return all that an effect declares but its other forms, kept since SymPy prints slowly."""
    return repr(effect.plain)
