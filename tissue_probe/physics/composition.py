"""A composed model by name: rig, tissue and effects, its numbers' names and units, its kernel.

SymPy is imported where symbols are asked for: a model whose machine code is on disk needs none.

Contents: the parts that a model file names, and the way from there to symbols and code.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np

from tissue_probe.physics.entry import Entry
from tissue_probe.physics.kinds import TISSUE_EFFECTS
from tissue_probe.physics.rigs import OWN, RIGS, Rig, rig_of
from tissue_probe.physics.scale import USUAL, Scale
from tissue_probe.quantities import Quantity

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect
    from tissue_probe.physics.machine_code import Text
    from tissue_probe.physics.model import Model
    from tissue_probe.physics.response import ResponseKernel

#: Sources that a kernel depends on besides its effects, whose text is part of its name.
KERNEL_SOURCES = (
    "physics/above.py",
    "physics/coil_course.py",
    "physics/effects/effect.py",
    "physics/llvm_code.py",
    "physics/machine_code.py",
    "physics/model_functions.py",
    "physics/numba_code.py",
    "physics/pointers.py",
    "physics/response_code.py",
    "physics/rigs/*.py",
    "physics/runge_kutta.py",
    "physics/tissues.py",
    "physics/transition.py",
)
#: A tissue that pulls back when it is let go, or drives, is none: it is another effect.
TISSUE = (
    Entry("stiffness", "N/m", default=450.0, lower=0.0, upper=1e9),
    Entry("damping", "N s/m", default=5.0, lower=0.0, upper=1e6),
)


@dataclass(frozen=True)
class Composition:
    """Rig, tissue and effects of one model.

    Attributes
    ----------
    rig : Rig
        May be given by its name in ``RIGS``.
    tissue : str
        A name in ``TISSUES``.
    effects : tuple of Effect
        Further physics, in the order in which it is applied; those of the library of this scale.
    scale : Scale
        The size of the records that it is for: bounds, typical values and the constants of laws are
        as many times larger. All numbers are in SI units at any size.
    """

    rig: Rig = OWN
    tissue: str = "kelvin_voigt"
    effects: tuple[Effect, ...] = ()
    scale: Scale = USUAL

    def __post_init__(self) -> None:
        object.__setattr__(self, "rig", rig_of(self.rig))

    def __reduce_ex__(self, protocol: SupportsIndex) -> Any:
        """Come back from bytes as its parts say: machine code is found or made again."""
        return _composed, (self.rig, self.tissue, self.effects, self.scale)

    @property
    def all_effects(self) -> tuple[Effect, ...]:
        """The effects that the tissue consists of, then those added to it."""
        own = TISSUE_EFFECTS[self.tissue]
        if not own:
            return self.effects
        from tissue_probe.physics.effects import EFFECTS

        if self.scale.is_usual:
            return (*(EFFECTS[name] for name in own), *self.effects)
        from tissue_probe.physics.effect_scale import resize_effect

        return (*(resize_effect(EFFECTS[name], self.scale) for name in own), *self.effects)

    @property
    def names(self) -> tuple[str, ...]:
        """The effects' names, the tissue's own among them."""
        return tuple(effect.name for effect in self.all_effects)

    @property
    def input(self) -> Quantity:
        """The signal that drives the model."""
        return self.rig.input

    @property
    def output(self) -> Quantity:
        """The signal that the model predicts."""
        return self.rig.output

    def plus(self, effect: Effect) -> Composition:
        """Return the model with one effect more."""
        return _composed(self.rig, self.tissue, (*self.effects, effect), self.scale)

    def without(self, name: str) -> Composition:
        """Return the model with one effect less."""
        kept = tuple(effect for effect in self.effects if effect.name != name)
        return _composed(self.rig, self.tissue, kept, self.scale)

    def having(self, form: Effect) -> Composition:
        """Return the model with the effect of the same name in this form."""
        effects = (form if each.name == form.name else each for each in self.effects)
        return _composed(self.rig, self.tissue, tuple(effects), self.scale)

    @cached_property
    def has_curved_spring(self) -> bool:
        """Whether an effect bends the force that indentation alone gives."""
        from tissue_probe.physics.effects.effect import INDENTATION
        from tissue_probe.physics.rigs.composing import elastic_depth

        return bool(elastic_depth(self.all_effects) != INDENTATION)

    @cached_property
    def is_kelvin_voigt(self) -> bool:
        """Whether the tissue is a spring beside a damper, and no effect changes its force."""
        if self.tissue != "kelvin_voigt" or not self.effects:
            return self.tissue == "kelvin_voigt"
        from tissue_probe.physics.effects.effect import TISSUE_FORCE

        return all(each.force == 0 and each.contact == TISSUE_FORCE for each in self.effects)

    @cached_property
    def model(self) -> Model:
        """The symbols."""
        from tissue_probe.physics.tissues import TISSUES

        tissue = TISSUES[self.tissue]
        return self.rig.compose(self.all_effects, tissue, contact_position=True)

    @cached_property
    def kernel(self) -> ResponseKernel:
        """The compiled code, made where no earlier process has.

        It is the same for records of every size: numbers are turned before and after.
        """
        if not self.scale.is_usual:
            return self._turned_kernel()
        from tissue_probe.physics.response import ResponseKernel

        digest = hashlib.sha256(self._said.encode()).hexdigest()[:16]
        return ResponseKernel.load(f"response_{digest}", self._text, KERNEL_SOURCES)

    @property
    def _said(self) -> str:
        """Text that tells the model from any other, whose code is on disk too.

        The name of a rig of the package stands for the equations in ``KERNEL_SOURCES``; those of a
        user's own have to be composed.
        """
        if RIGS.get(self.rig.name) is not self.rig:
            return repr(self.model)
        return "\n".join((self.rig.name, self.tissue, *map(_declared, self.all_effects)))

    def _turned_kernel(self) -> ResponseKernel:
        from tissue_probe.physics.effect_scale import over
        from tissue_probe.physics.response import Turned

        own = ((each.origin or over(each, self.scale)).plain for each in self.effects)
        kernel = _composed(self.rig, self.tissue, tuple(own)).kernel
        entries = self.entries(kernel.values)
        units = {entry.name: entry.unit for entry in entries}
        states = [state_unit(spread, units, self.output.unit) for spread in kernel.spreads]
        return replace(
            kernel,
            turned=Turned(
                values=np.array([self.scale.of(entry.unit) for entry in entries]),
                states=np.array([self.scale.of(unit) for unit in states]),
                input=self.scale.of(self.input.unit),
                output=self.scale.of(self.output.unit),
                scale=self.scale,
            ),
        )

    def _text(self) -> Text:
        from tissue_probe.physics.response_code import text

        return text(self.model)

    @cached_property
    def values(self) -> tuple[Entry, ...]:
        """Constants and parameters in the kernel's order, with units and bounds."""
        return self.entries(self.kernel.values)

    def entries(self, names: Iterable[str]) -> tuple[Entry, ...]:
        """Return the declarations of constants and parameters of these names."""
        constants = (constant.entry for constant in self.rig.constants)
        known = {entry.name: entry for entry in (*constants, *TISSUE)}
        if not self.scale.is_usual:
            known = {name: entry.times(self.scale) for name, entry in known.items()}
        own = {each.name: each.entry for effect in self.all_effects for each in effect.parameters}
        return tuple((known | own)[name] for name in names)


def state_unit(spread: str, units: Mapping[str, str], output: str = "N") -> str:
    """Return the unit of a state by the scale of its start (``State.spread``).

    Parameters
    ----------
    spread : str
        Of the state.
    units : mapping of str to str
        Of the model's values, by name.
    output : str
        Of the predicted channel.
    """
    kinds = {
        **dict.fromkeys(("length", "branch", "free", "counted"), "m"),
        "speed": "m/s",
        "none": output,
        "input2": "input2",
    }
    return kinds.get(spread) or units[spread]


@cache
def _composed(
    rig: Rig, tissue: str, effects: tuple[Effect, ...], scale: Scale = USUAL
) -> Composition:
    """Return the same model for the same parts: a diagnosis composes each many times over."""
    return Composition(rig, tissue, effects, scale)


@cache
def _declared(effect: Effect) -> str:
    """Return all that an effect declares but its other forms, kept since SymPy prints slowly."""
    return repr(effect.plain)
