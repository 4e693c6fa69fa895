"""What a physical effect declares: the contract of every file in this folder.

Contents: where in a model an effect may act, and what is said about its parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, SupportsIndex

import sympy as sp

from tissue_probe.physics.entry import Entry
from tissue_probe.physics.extent import Extent
from tissue_probe.physics.scale import USUAL, Scale
from tissue_probe.quantities import engineering

TIME = sp.Symbol("time", real=True)
POSITION, POSITION_RATE = sp.symbols("position position_rate", real=True)
POSITION_ACCELERATION = sp.Symbol("position_acceleration", real=True)
POSITION_BEFORE = sp.Symbol("position_before", real=True)
INDENTATION, TIP_VELOCITY = sp.symbols("indentation tip_velocity", real=True)
STIFFNESS, DAMPING = sp.symbols("stiffness damping", real=True)
TISSUE_FORCE, STRETCH, FORCE = sp.symbols("tissue_force stretch force", real=True)
NET_FORCE = sp.Symbol("net_force", real=True)
ELASTIC_DEPTH, ELASTIC_RATE = sp.symbols("elastic_depth elastic_rate", real=True)
#: A further recorded channel, in its own unit: 0 throughout where none is given.
INPUT2 = sp.Symbol("input2", real=True)


@dataclass(frozen=True)
class Parameter:
    """An unknown of an effect: its symbol, unit, where it lies, and where a search begins.

    ``default`` is a value typical of what is met, and the scale of the search.
    """

    symbol: sp.Symbol
    unit: str
    default: float
    lower: float
    upper: float

    @property
    def name(self) -> str:
        """The symbol's name."""
        return str(self.symbol.name)

    @property
    def entry(self) -> Entry:
        """The same without its symbol."""
        return Entry(self.name, self.unit, self.default, self.lower, self.upper)


@dataclass(frozen=True)
class State:
    """A state that an effect brings along.

    ``motion`` is its rate of change, in which ``ELASTIC_RATE`` [m/s] stands for that of
    ``ELASTIC_DEPTH``; ``start`` its value where the probe has been at rest for long, of
    ``POSITION``, ``FORCE`` and ``INPUT2`` as measured; ``spread`` how far it may be from there:
    "length" (of the order of the indentation at the start, or of any where the probe is not at
    rest), "branch" (the same, of a spring in series with a damper: pressed in before, if at all),
    "speed" (of the order of the tip's where it is not at rest), "none" (of a force: by its noise),
    "counted" (a way from the first sample on: none), "free" (of the order of any indentation in any
    case), "input2" (within the range of that channel), or the name of a
    parameter (of the order of its value).
    """

    symbol: sp.Symbol
    motion: sp.Expr
    start: sp.Expr = sp.S.Zero
    spread: str = "length"


@dataclass(frozen=True)
class Switch:
    """Something that is on (1) or off (0), such as contact, and when that changes.

    While on, it goes off as soon as ``on`` is negative; while off, it comes on as soon as ``off``
    is negative. The simulation finds the instant within the step. ``alone`` is what it is, between
    0 and 1, for who remembers nothing, such as a filter: by default on where ``off`` is negative.
    """

    symbol: sp.Symbol
    on: sp.Expr
    off: sp.Expr
    first: bool = True
    alone: sp.Expr | None = None


Starts = Callable[[Extent], Iterable[Mapping[str, float]]]


def _at_default(extent: Extent) -> list[dict[str, float]]:
    return [{}]


class _Told(float):
    """A value that writes itself in the unit that a form asks for."""

    def __format__(self, spec: str) -> str:
        if unit := {"period": "s", "depth": "m"}.get(spec):
            return engineering(1.0 / self if self else math.inf, unit)
        known = spec[:1].isalpha()
        return engineering(float(self), spec) if known else super().__format__(spec)


@dataclass(frozen=True)
class Effect:
    """One physical effect beyond Kelvin-Voigt tissue on the paper's rig.

    It acts where it says so; everything left alone stays as in the model without it. With its
    strengths at ``neutral`` it reproduces that model exactly.

    Attributes
    ----------
    name, family, physics : str
        A name, the family it is reported under, and one line on what happens.
    parameters : tuple of Parameter
        What is to be estimated; the first is the effect's strength.
    force : Expr
        Further force of the tissue on the tip [N], positive against indentation. In it stands
        ``ELASTIC_DEPTH`` [m] for all that is elastic over the stiffness: the indentation, and what
        it is where the tissue stiffens.
    contact : Expr
        What becomes of ``TISSUE_FORCE`` [N], the sum of all forces of the tissue.
    surface : tuple of two Expr
        Displacement [m] and velocity [m/s] of the tissue's surface, positive into the tissue.
    drag : Expr
        Force on the tip that does not come from the tissue [N], positive against indentation.
        With it, ``INDENTATION`` and ``TIP_VELOCITY`` of the effect are the tip's displacement and
        velocity, whether or not the tissue's surface moves.
    moving : Expr
        Whether (1, 0) the tip moves, of switches: 0 while it sticks. Their conditions may hold
        ``NET_FORCE``, the sum of all forces on the tip [N], positive into the tissue.
    inertia : Expr
        Mass that moves with the tip [kg].
    coil : tuple of two Expr
        Position [m] and velocity [m/s] at the load cell's end, of ``POSITION`` and its rate.
    sampled : Expr, optional
        The same position [m] for who has samples only, such as a filter, and in place of states and
        switches: of ``POSITION`` and ``POSITION_BEFORE``, what it was a sample ago.
    stretch, engaged : Expr
        Compression [m] of the load cell's spring, of ``STRETCH`` = u - x; whether (1, 0) it is
        engaged.
    cell : Expr
        Factor of the load cell's stiffness.
    output : Expr
        Measured force [N], of ``FORCE``, the load cell's.
    position : Expr
        True position of the coil [m], of ``POSITION``, the measured one, sample by sample.
    delay : Expr
        Time by which the force channel is late [s].
    rounded : Expr
        Step to which the measured position is rounded [m].
    states, switches
        What the effect remembers.
    strengths : int
        How many of the first parameters are strengths: the effect grows with each of them, and the
        others say of what kind it is.
    neutral : float
        The value of every strength at which nothing is changed.
    starts : callable
        From an ``Extent``, values of the parameters from which a search begins, the tissue's
        ``stiffness`` and ``damping`` among them where those of the model without it mislead.
    near : callable, optional
        From an ``Extent`` and values found, further values to try: where a search by gradients
        may stop short, and to begin with where the motion goes on and the effect has states.
    forms : tuple of Effect
        The same physics as others write it; the best of them stands for the effect.
    simpler : tuple of str
        Effects that this one contains, and which are preferred where they fit as well.
    limit : str
        The parameter at whose lower bound this effect is a simpler one, if there is such.
    excludes : tuple of str
        Effects beside which this one is not sought, nor they beside it: both are forms of one law,
        of which the second would only bend the first.
    of_run : tuple of str
        Parameters that belong to a run and not to specimen or instrument, such as a phase.
    of_part : tuple of str
        Parameters by which a part of a run, which a gap in its times ends, differs from the first:
        they are ``neutral`` in that.
    zero : str
        The parameter that is added to the force, the same at all times; empty where none is.
    absolute : bool
        Whether it is a wave of the world about, as of the mains: it is not sought in a record that
        is far slower or faster than usual, whose times are in other units, nor where the samples
        are too few a period to show it. Its strengths are a sine's and a cosine's.
    scale, origin
        Of a copy for a record of another size, see ``effect_scale``: which, and the effect that it
        is a copy of.
    odds : float
        How many times as likely it is missing as any other of the library, before anything is
        measured. 0: it is tried only where it is asked for, by its name or by odds of its own.
    assumptions, reference : str
        Where it holds, and where it comes from.
    says : str
        What its values mean, in a few words: a form that is filled with them by name, each in its
        unit (``{coulomb_force:N}``), as the time of a rate (``{relaxation_rate:period}``), as the
        depth of which it is the inverse (``{softening_with_depth:depth}``), or as a number
        (``{contact_exponent:.2f}``).
    """

    name: str
    family: str
    physics: str
    parameters: tuple[Parameter, ...] = ()
    force: sp.Expr = sp.S.Zero
    contact: sp.Expr = TISSUE_FORCE
    surface: tuple[sp.Expr, sp.Expr] = (sp.S.Zero, sp.S.Zero)
    drag: sp.Expr = sp.S.Zero
    moving: sp.Expr = sp.S.One
    inertia: sp.Expr = sp.S.Zero
    coil: tuple[sp.Expr, sp.Expr] = (POSITION, POSITION_RATE)
    sampled: sp.Expr | None = None
    stretch: sp.Expr = STRETCH
    engaged: sp.Expr = sp.S.One
    cell: sp.Expr = sp.S.One
    output: sp.Expr = FORCE
    position: sp.Expr = POSITION
    delay: sp.Expr = sp.S.Zero
    rounded: sp.Expr = sp.S.Zero
    states: tuple[State, ...] = ()
    switches: tuple[Switch, ...] = ()
    strengths: int = 1
    neutral: float = 0.0
    starts: Starts = field(default=_at_default, repr=False)
    near: Callable[[Extent, Mapping[str, float]], Iterable[Mapping[str, float]]] | None = field(
        default=None, repr=False
    )
    forms: tuple[Effect, ...] = ()
    simpler: tuple[str, ...] = ()
    limit: str = ""
    excludes: tuple[str, ...] = ()
    of_run: tuple[str, ...] = ()
    of_part: tuple[str, ...] = ()
    zero: str = ""
    assumptions: str = ""
    reference: str = ""
    says: str = ""
    absolute: bool = field(default=False, repr=False)
    odds: float = field(default=1.0, repr=False)
    scale: Scale = field(default=USUAL, repr=False, compare=False)
    origin: Effect | None = field(default=None, repr=False, compare=False)

    def __reduce_ex__(self, protocol: SupportsIndex) -> Any:
        """Come back from bytes as the library's own, in its form; a user's own as what it holds."""
        from tissue_probe.physics.library_form import find_in_library, of_library

        place = find_in_library(self)
        return super().__reduce_ex__(protocol) if place is None else (of_library, place)

    @property
    def plain(self) -> Effect:
        """The effect as it is written here, without its other forms."""
        return replace(self, forms=())

    def told(self, values: Mapping[str, float]) -> str:
        """Return what the effect with such values says, in a few words; empty where unknown."""
        named = {each.name: _Told(values[each.name]) for each in self.parameters}
        return self.says.format_map(named)

    def with_odds(self, odds: float) -> Effect:
        """Return the same with other odds, in each of its forms."""
        forms = tuple(replace(each, odds=odds) for each in self.forms)
        return replace(self, odds=odds, forms=forms)

    @property
    def hears_input2(self) -> bool:
        """Whether it follows the second input, and so is none where that is not recorded."""
        acts = (self.force, self.contact, self.drag, self.inertia, self.cell, self.output)
        moved = (state.motion for state in self.states)
        return any(sp.sympify(each).has(INPUT2) for each in (*acts, *moved))

    @property
    def acts_on_channels(self) -> bool:
        """Whether it changes a measured channel, and no law of tissue or rig."""
        unchanged = (FORCE, POSITION, sp.S.Zero, sp.S.Zero)
        return (self.output, self.position, self.delay, self.rounded) != unchanged

    @property
    def changes_contact(self) -> bool:
        """Whether, as it is written here, it changes what the tissue's force does to the tip."""
        return bool(self.contact != TISSUE_FORCE)

    @property
    def follows_spring(self) -> bool:
        """Whether it moves as the spring's force does: beside a straight spring, as the tip."""
        return any(sp.sympify(state.motion).has(ELASTIC_RATE) for state in self.states)

    @property
    def unknowns(self) -> set[str]:
        """Names of the parameters of all of its forms."""
        return {each.name for form in self.every_form for each in form.parameters}

    @property
    def every_form(self) -> tuple[Effect, ...]:
        """The effect as it is written here, then in each other form."""
        return (self.plain, *self.forms)
