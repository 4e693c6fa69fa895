"""A composed model by name: rig, tissue and effects, its numbers' names and units, its kernel.

SymPy is imported where symbols are asked for: a model whose machine code is on disk needs none.

What belongs here: what a model file names, and the way from there to symbols and compiled code.
What does not: values (``diagnosis``), equations (``rigs``, ``tissues``, ``effects``).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import TYPE_CHECKING

from tissue_probe.physics.entry import Entry
from tissue_probe.physics.kinds import SIGNALS, TISSUE_EFFECTS
from tissue_probe.quantities import FORCE, Quantity

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect
    from tissue_probe.physics.machine_code import Text
    from tissue_probe.physics.model import Model
    from tissue_probe.physics.response import Kernel

#: What a kernel depends on besides its effects, whose text is part of its name.
SOURCES = (
    "physics/coil_course.py",
    "physics/effects/effect.py",
    "physics/llvm_code.py",
    "physics/machine_code.py",
    "physics/model_functions.py",
    "physics/numba_code.py",
    "physics/pointers.py",
    "physics/response_code.py",
    "physics/rigs.py",
    "physics/runge_kutta.py",
    "physics/tissues.py",
    "physics/transition.py",
)
CONSTANTS = (
    Entry("tip_mass", "kg", default=0.04, lower=0.0, upper=1e4),
    Entry("load_cell_stiffness", "N/m", default=9700.0, lower=1.0, upper=1e8),
    Entry("load_cell_damping", "N s/m", default=0.8, lower=0.0, upper=1e4),
    Entry("contact_position", "m", default=0.0, lower=-1.0, upper=1.0),
)
#: Where a force drives, it divides by the mass [kg].
LIGHTEST = 1e-6
#: A tissue that pulls back when it is let go, or drives, is none: what seems so is another effect.
TISSUE = (
    Entry("stiffness", "N/m", default=450.0, lower=0.0, upper=1e9),
    Entry("damping", "N s/m", default=5.0, lower=0.0, upper=1e6),
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
        own = TISSUE_EFFECTS[self.tissue]
        if not own:
            return self.effects
        from tissue_probe.physics.effects import EFFECTS

        return (*(EFFECTS[name] for name in own), *self.effects)

    @property
    def names(self) -> tuple[str, ...]:
        """The effects' names, the tissue's own among them."""
        return tuple(effect.name for effect in self.all_effects)

    @property
    def input(self) -> Quantity:
        """The signal that drives the model."""
        return SIGNALS[self.rig][0]

    @property
    def output(self) -> Quantity:
        """The signal that the model predicts."""
        return SIGNALS[self.rig][1]

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
        from tissue_probe.physics.rigs import RIGS
        from tissue_probe.physics.tissues import TISSUES

        tissue = TISSUES[self.tissue]
        return RIGS[self.rig].compose(self.all_effects, tissue=tissue, contact_position=True)

    @cached_property
    def kernel(self) -> Kernel:
        """The compiled code, made where no earlier process has."""
        from tissue_probe.physics.response import Kernel

        said = "\n".join((self.rig, self.tissue, *map(_declared, self.all_effects)))
        digest = hashlib.sha256(said.encode()).hexdigest()[:16]
        return Kernel.load(f"response_{digest}", self._text, SOURCES)

    def _text(self) -> Text:
        from tissue_probe.physics.response_code import text

        return text(self.model)

    @cached_property
    def values(self) -> tuple[Entry, ...]:
        """Constants and parameters in the kernel's order, with units and bounds."""
        return self.entries(self.kernel.values)

    def entries(self, names: Iterable[str]) -> tuple[Entry, ...]:
        """Return what is declared of constants and parameters of these names."""
        known = {entry.name: entry for entry in (*CONSTANTS, *TISSUE)}
        if self.input is FORCE:
            known["tip_mass"] = replace(known["tip_mass"], lower=LIGHTEST)
        own = {each.name: each.entry for effect in self.all_effects for each in effect.parameters}
        return tuple((known | own)[name] for name in names)


@cache
def _composed(rig: str, tissue: str, effects: tuple[Effect, ...]) -> Composition:
    """Return the same model for the same parts: a diagnosis composes each many times over."""
    return Composition(rig, tissue, effects)


@cache
def _declared(effect: Effect) -> str:
    """Return all that an effect declares but its other forms, kept since SymPy prints slowly."""
    return repr(effect.plain)
