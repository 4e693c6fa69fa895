"""The library of effects: the suite's own, those of installed packages, and a user's own files.

Contents: finding effects, and naming a fault of one in one sentence. Code runs only where
the user has named its file, or has installed its package.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cache, partial
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

import sympy as sp

from tissue_probe.errors import TissueProbeError
from tissue_probe.physics import response_code
from tissue_probe.physics.composition import TISSUE, Composition
from tissue_probe.physics.effects import EFFECTS, Effect, Extent
from tissue_probe.physics.effects.effect import (
    DAMPING,
    ELASTIC_DEPTH,
    ELASTIC_RATE,
    FORCE,
    INDENTATION,
    INPUT2,
    NET_FORCE,
    POSITION,
    POSITION_ACCELERATION,
    POSITION_BEFORE,
    POSITION_RATE,
    STIFFNESS,
    STRETCH,
    TIME,
    TIP_VELOCITY,
    TISSUE_FORCE,
    Parameter,
    State,
    Switch,
)
from tissue_probe.physics.rigs import CONSTANTS
from tissue_probe.physics.rigs.composing import (
    CELL_DAMPING,
    CELL_STIFFNESS,
    CONTACT,
    MASS,
    OFFSET,
    TIP_POSITION,
)
from tissue_probe.physics.tissues import EXTENSION

#: Entry points of this group are effects, too.
GROUP = "tissue_probe.effects"
LIBRARY_SIGNALS = (
    INDENTATION, ELASTIC_DEPTH, ELASTIC_RATE, TIP_VELOCITY, TISSUE_FORCE, STRETCH, NET_FORCE, FORCE,
    POSITION, POSITION_RATE, TIME, INPUT2,
)  # fmt: skip
MODEL = (MASS, CELL_STIFFNESS, CELL_DAMPING, CONTACT, STIFFNESS, DAMPING)
ELSEWHERE = (POSITION_ACCELERATION, POSITION_BEFORE, OFFSET, TIP_POSITION, EXTENSION)
#: A recording like many, on which an effect's proposals are tried.
USUAL_EXTENT = Extent(
    duration=2.0, indentation=1e-3, depth=2e-3, speed=0.06, force=0.3, pull=0.2, step=1e-7
)


class EffectError(TissueProbeError):
    """An effect that cannot be used; the message says which, why, and the remedy."""


def effects(extra_files: Iterable[str | Path] = ()) -> dict[str, Effect]:
    """Return every effect by name: the suite's, installed packages', and those in given files.

    Parameters
    ----------
    extra_files : iterable of path
        Python files that the user named, each with one or more ``Effect``. They are run.

    Raises
    ------
    EffectError
        If a file or an effect cannot be used, or two have one name.
    """
    library = dict(EFFECTS)
    for origin, found in (*_installed(), *((str(p), load_effects(p)) for p in extra_files)):
        for effect in found:
            _check(effect, origin, library)
            library[effect.name] = effect
    return library


def load_effects(path: str | Path) -> tuple[Effect, ...]:
    """Run a Python file; return the effects that it defines under public names.

    Parameters
    ----------
    path : path
        A file such as ``docs/my_effect.py``.

    Raises
    ------
    EffectError
        If there is no such file, it cannot be run, or it defines no effect.
    """
    path = Path(path)
    if not path.is_file():
        raise EffectError(f"{path}: there is no such file of effects")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise EffectError(f"{path} is no Python file: give it a name that ends in .py")
    module = importlib.util.module_from_spec(spec)
    with _told(f"{path} cannot be run"):
        spec.loader.exec_module(module)
    ours = {id(effect) for effect in EFFECTS.values()}
    with _told(f"{path} cannot be used"):
        found = tuple(
            _guarded(value, str(path))
            for name, value in vars(module).items()
            if isinstance(value, Effect) and not name.startswith("_") and id(value) not in ours
        )
    if not found:
        raise EffectError(
            f"{path} defines no effect: write MY_EFFECT = Effect(name=..., ...) in it"
        )
    return found


def _installed() -> Iterator[tuple[str, Sequence[Effect]]]:
    """Go through the effects that installed packages offer, each with its origin."""
    for entry in _offered(entry_points):
        origin = f"entry point {entry.name} = {entry.value}"
        with _told(f"{origin} cannot be loaded"):
            effect = entry.load()
        if not isinstance(effect, Effect):
            raise EffectError(f"{origin} is no Effect: let it name one")
        with _told(f"{origin} cannot be used"):
            guarded = _guarded(effect, origin)
        yield origin, (guarded,)


@cache
def _offered(read: Callable[..., Iterable[EntryPoint]]) -> tuple[EntryPoint, ...]:
    """Return the entry points of installed packages: to read all metadata takes 50 ms."""
    return tuple(read(group=GROUP))


@contextmanager
def _told(what: str) -> Iterator[None]:
    """Make one sentence of any error of another's code, an exit too; but let Ctrl-C through.

    Raises
    ------
    EffectError
        If anything is raised: the sentence's beginning, and that.
    """
    try:
        yield
    except (EffectError, KeyboardInterrupt):
        raise
    except BaseException as error:
        told = " ".join(f"{type(error).__name__}: {error}".split())
        raise EffectError(f"{what}: {told}") from error


def _guarded(effect: Effect, origin: str) -> Effect:
    """Return an effect whose own functions are told of by name, when they fail in a search."""
    default = Effect("", "", "")
    said = f"{origin}: effect {effect.name!r} cannot propose"
    starts, near = effect.starts, effect.near
    if starts is not default.starts:
        starts = partial(_proposed, starts, said)
    if near is not None:
        near = partial(_proposed, near, said)
    forms = tuple(_guarded(form, origin) for form in effect.forms)
    return replace(effect, starts=starts, near=near, forms=forms)


def _proposed(propose: Callable[..., Any], said: str, *known: object) -> list[dict[str, float]]:
    with _told(said):
        return [{name: float(value) for name, value in each.items()} for each in propose(*known)]


def _check(effect: Effect, origin: str, library: Mapping[str, Effect]) -> None:
    """Raise an ``EffectError`` for the first thing by which an effect breaks its contract."""
    with _told(f"{origin}: effect {effect.name!r} cannot be used"):
        for complaint in _complaints(effect, library):
            raise EffectError(f"{origin}: effect {effect.name!r} {complaint}")


def _complaints(effect: Effect, library: Mapping[str, Effect]) -> Iterator[str]:
    if not str(effect.name).isidentifier():
        yield "has no good name: use letters, digits and underscores"
    if effect.name in library:
        yield "has the name of another effect: choose another"
    for form in (effect, *effect.forms):
        yield from _form_complaints(form, library)


def _form_complaints(effect: Effect, library: Mapping[str, Effect]) -> Iterator[str]:
    try:
        hash(effect)
    except TypeError:
        yield "holds a list, a set or a dict: write tuples, as for parameters=(...,)"
        return
    taken = {str(s): "of the model" for s in (*LIBRARY_SIGNALS, *ELSEWHERE)}
    taken |= {entry.name: "of the model" for entry in (*CONSTANTS.values(), *TISSUE)}
    # One and the same switch, such as contact, may serve several effects.
    shared = {switch for other in library.values() for switch in other.switches}
    for other in library.values():
        # Effects of which no model has both may share their unknowns.
        if other.name not in effect.excludes:
            taken |= {str(symbol): f"of the effect {other.name}" for symbol in _own(other)}
    for symbol in _own(effect):
        if any(switch.symbol == symbol for switch in shared.intersection(effect.switches)):
            continue
        if str(symbol) in taken:
            yield f"names a symbol {symbol}, which is one {taken[str(symbol)]}: rename it"
    for entry in effect.parameters:
        if not entry.lower <= entry.default <= entry.upper:
            yield (
                f"has a parameter {entry.name} of default {entry.default:g}, out of its bounds "
                f"{entry.lower:g} to {entry.upper:g}"
            )
    if not 0 <= effect.strengths <= len(effect.parameters) and effect.parameters:
        yield f"says strengths={effect.strengths}, but has {len(effect.parameters)} parameters"
    known = {*LIBRARY_SIGNALS, *_own(effect), *MODEL}
    for symbol in sorted(_used(effect) - known, key=str):
        yield (
            f"uses the symbol {symbol}, which nothing tells: make it a Parameter, or import it "
            "from tissue_probe.physics.effects.effect"
        )
    names = {entry.name for entry in effect.parameters} | {entry.name for entry in TISSUE}
    for start in effect.starts(USUAL_EXTENT):
        if unknown := sorted(set(start) - names):
            yield f"proposes starts for {', '.join(unknown)}, which it has not"
    if effect.parameters and not effect.switches and name_changes(effect):
        yield (
            f"still acts ({', '.join(name_changes(effect))}) with its strengths at neutral="
            f"{effect.neutral:g}: there it must leave the model as it is"
        )
    try:
        response_code.text(Composition(effects=(effect,)).model)
    except (TypeError, ValueError, AttributeError) as error:
        yield f"cannot be composed: {' '.join(str(error).split())}"


def name_changes(effect: Effect) -> list[str]:
    """Name the changes by an effect with its strengths at ``neutral``; none, if it is right.

    States that stay where they start are taken to be there.
    """
    at = {entry.symbol: effect.neutral for entry in effect.parameters[: effect.strengths]}
    start = {state.symbol: state.start for state in effect.states}
    at |= {
        state.symbol: state.start
        for state in effect.states
        if sp.simplify(sp.sympify(state.motion).subs(at).subs(start)) == 0
    }
    # A state that starts at 0 and that nothing moves from there stays 0.
    still = {state.symbol: 0 for state in effect.states if state.start == 0}
    moved = [sp.simplify(state.motion.subs(at).subs(still)) for state in effect.states]
    if all(rate == 0 for rate in moved):
        at |= still
    default = Effect("", "", "")
    places = ("force", "contact", "drag", "inertia", "stretch", "engaged", "cell", "output",
              "position", "delay", "rounded")  # fmt: skip
    return [
        name
        for name in places
        if sp.simplify(sp.sympify(getattr(effect, name)).subs(at) - getattr(default, name)) != 0
    ]


def _own(effect: Effect) -> list[sp.Symbol]:
    owners: list[Parameter | State | Switch] = [
        *effect.parameters,
        *effect.states,
        *effect.switches,
    ]
    return [owner.symbol for owner in owners]


def _used(effect: Effect) -> set[sp.Symbol]:
    """Return every symbol in an effect's expressions."""
    expressions = [
        *(effect.force, effect.contact, *effect.surface, effect.drag, effect.inertia, *effect.coil),
        effect.moving,
        *(effect.stretch, effect.engaged, effect.cell, effect.output, effect.position),
        *(effect.delay, effect.rounded),
        sp.sympify(effect.sampled or 0).subs(POSITION_BEFORE, POSITION),
        *(side for state in effect.states for side in (state.motion, state.start)),
        *(side for switch in effect.switches for side in (switch.on, switch.off)),
        *(switch.alone for switch in effect.switches if switch.alone is not None),
    ]
    return set().union(*(sp.sympify(expression).free_symbols for expression in expressions))
