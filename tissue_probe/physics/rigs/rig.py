"""A rig: how an instrument couples to tissue and to further effects, with its facts.

Contents: the contract of every rig's file in this folder, and of a user's own.

All but ``compose`` and ``obstacle`` is known without SymPy, which takes half a second to be
imported.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING, Any, SupportsIndex

from tissue_probe import quantities
from tissue_probe.physics.rigs.constants import Constant
from tissue_probe.quantities import Quantity, other

if TYPE_CHECKING:
    import sympy as sp

    from tissue_probe.physics.effects.effect import Effect
    from tissue_probe.physics.model import Model
    from tissue_probe.physics.tissues import Tissue

Known = dict[str, tuple[float, float]]
"""Value and standard deviation of each constant, by name [SI units]."""


class Live(Enum):
    """How the filters that run beside an instrument (``estimation``) take its samples."""

    no = "not at all"
    windows = "window by window, on Kelvin-Voigt tissue only"
    models = "sample by sample, with model files, too"


@dataclass(frozen=True, eq=False, repr=False)
class Rig:
    """An instrument: its equations, and all that is known of it without them.

    Attributes
    ----------
    name : str
        By which it is chosen.
    summary : str
        The rig in one line.
    whose : str
        Said after its name: whose instrument it is, such as "for a robot that moves the tip".
    equations : callable
        (effects, tissue, zero) -> ``Model`` by ``composing.composed``: the first two states are
        position and velocity of the tip, where that moves by itself; ``zero`` is the position at
        which it touches, a symbol or 0, and no constant of the model yet.
    input : Quantity
        The signal that drives it.
    constants : tuple of Constant
        Of its equations, and ``contact_position``.
    flicker_noise : float
        Rms of the 1/f noise of its load cell over a recording [N].
    tip_is_position : bool
        Whether the tip follows the position that drives exactly: then the force answers to speed
        and acceleration at once, and nothing moves by itself.
    load_cell_yields : bool
        Whether the load cell is a spring between position and tip, on which effects may act.
    live : Live
        How filters take its samples.
    drawing : str
        A small picture (SVG).
    """

    name: str
    summary: str
    whose: str
    equations: Callable[[Sequence[Effect], Tissue, sp.Expr], Model]
    input: Quantity
    constants: tuple[Constant, ...]
    flicker_noise: float = 0.0
    tip_is_position: bool = False
    load_cell_yields: bool = False
    live: Live = Live.no
    drawing: str = ""

    def __reduce_ex__(self, protocol: SupportsIndex) -> Any:
        """Come back from bytes as the package's own of its name; a user's own as its content."""
        from tissue_probe.physics.rigs import RIGS, rig_of

        if RIGS.get(self.name) is self:
            return rig_of, (self.name,)
        return super().__reduce_ex__(protocol)

    @property
    def output(self) -> Quantity:
        """The signal that is predicted."""
        return other(self.input)

    @property
    def known(self) -> Known:
        """Value and standard deviation of each constant, where nobody says anything."""
        return {each.name: (each.value, each.deviation) for each in self.constants}

    def compose(
        self,
        effects: Sequence[Effect] = (),
        tissue: Tissue | None = None,
        contact_position: bool = False,
        force_offset: bool = False,
    ) -> Model:
        """Return the rig's model.

        Parameters
        ----------
        effects : sequence of Effect
            Further physics, applied in this order where the order matters.
        tissue : Tissue, optional
            The tissue that the tip presses on; Kelvin-Voigt's by default.
        contact_position : bool
            Whether the position at which the tip touches [m] is a constant; 0 otherwise.
        force_offset : bool
            Whether a constant force [N] in the output is a parameter to be estimated; 0 otherwise.
            It is the load cell's zero error, and equally a contact point that lies elsewhere: both
            shift the force by a constant, and neither the motion.

        Raises
        ------
        ValueError
            If an effect acts on something that the rig has not, or the equations have a constant
            that the rig does not declare.
        """
        from tissue_probe.physics.rigs.composing import CONTACT, NOWHERE, with_offset
        from tissue_probe.physics.tissues import TISSUES

        for effect in effects:
            if told := self.obstacle(effect):
                raise ValueError(f"{effect.name} {told}; leave it out, or choose another rig")
        zero = CONTACT if contact_position else NOWHERE
        model = self.equations(effects, tissue or TISSUES["kelvin_voigt"], zero)
        if contact_position:
            model = replace(model, constants=(*model.constants, CONTACT))
        for name in map(str, model.constants):
            if name not in self.known:
                raise ValueError(f"{self} has no constant {name}: declare it beside the others")
        return with_offset(model) if force_offset else model

    def admits(self, effect: Effect) -> bool:
        """Whether the rig has the part that an effect acts on."""
        return not self.obstacle(effect)

    def obstacle(self, effect: Effect) -> str:
        """Say why an effect has no meaning for the rig, in a clause; empty where it has one."""
        from tissue_probe.physics.effects.effect import FORCE, POSITION, POSITION_RATE, STRETCH

        cell = (effect.cell, effect.stretch, effect.engaged)
        if not self.load_cell_yields and cell != (1, STRETCH, 1):
            return f"acts on the load cell's spring, and {self} has none"
        if self.input is quantities.POSITION:
            return ""
        coil = (effect.coil, effect.position, effect.rounded)
        if coil != ((POSITION, POSITION_RATE), POSITION, 0):
            return f"acts on a position that drives the tip, and in {self} a force does"
        slope, own = effect.output.diff(FORCE), {state.symbol for state in effect.states}
        if slope == 0 or slope.has(FORCE) or not own.isdisjoint(effect.output.free_symbols):
            return (
                f"distorts the force in a way that cannot be undone, and in {self} the force drives"
            )
        return ""

    def __str__(self) -> str:
        return self.name

    def __repr__(self) -> str:
        return f"<Rig {self.name}: {self.summary}>"

    def _repr_html_(self) -> str:
        """Return the table that a notebook shows."""
        from html import escape

        return (
            f"<figure>{self.drawing}<figcaption>{self.name}: {escape(self.summary)}"
            "</figcaption></figure>"
        )
