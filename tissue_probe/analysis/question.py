"""The model that is asked about: rig, tissue or model file, known constants, effects to try.

Contents: from the user's words to a composition, an instrument and a library.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from tissue_probe import arguments as take
from tissue_probe.analysis.choices import Course, RigChoice, Starts, TissueName
from tissue_probe.analysis.question_items import ITEMS, ITEMS_BY_NAME, Item
from tissue_probe.analysis.segments import Segment, segments
from tissue_probe.diagnosis.observation.instrument import FLICKER_NAME, Instrument
from tissue_probe.errors import ParameterError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.rigs import OWN, RIGS, Rig
from tissue_probe.physics.rigs.constants import CONTACT_POSITION
from tissue_probe.recording.layout import Layout

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from tissue_probe.analysis.measurements import Measurements
    from tissue_probe.physics.effects import Effect

#: Values of the tissue that may be known: zeros say that there is none.
KNOWN_TISSUE = ("stiffness", "damping")

Constants = Mapping[str, "float | tuple[float, float]"]
"""A constant's value, or value and standard deviation, by its name [SI units]."""

_EACH = ", or ".join(f"{rig} {rig.whose}" for rig in RIGS.values())
#: A wrong rig is made up for by effects that are not there, so that none is supposed.
WHICH_RIG = f"nobody said which rig measured this: give `rig` {_EACH}"


class Asked(TypedDict, total=False):
    """Statements on measurements, by keyword; ``question_items.ITEMS`` has the meaning of each."""

    site: int | None
    lowpass: float | None
    starts: Starts
    course: Course
    rig: RigChoice | None
    tissue: TissueName | None
    model: str | Path | FittedModel | None
    known_rig: bool
    constants: Constants | None
    prior: Mapping[str, float] | None
    effects: Sequence[str | Path]
    without: Sequence[str]


PRIOR = "`prior`: {} counts as {:g} times as likely as any other effect before the measurement."


@dataclass(frozen=True)
class ModelQuestion:
    """A model, statements on its rig and the samples, and the effects that it may miss.

    Attributes
    ----------
    model : FittedModel
        The model to begin with; without values, where it comes from no file.
    instrument : Instrument
        The rig's constants.
    notes : tuple of str
        Notes on the model, in sentences.
    rig_given : bool
        Whether the user said on which rig was measured.
    site, lowpass, starts, course
        See ``segments``.
    prior : mapping of str to float
        Odds of effects, or of those of a family, by name.
    without : tuple of str
        Names of effects that are not tried.
    stated : mapping
        All given values, by keyword, but for those equal to the default.
    """

    model: FittedModel
    instrument: Instrument
    notes: tuple[str, ...] = ()
    rig_given: bool = True
    site: int | None = None
    lowpass: float | None = None
    starts: Starts = "auto"
    course: Course = "auto"
    prior: Mapping[str, float] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    stated: Mapping[str, Any] = field(default_factory=dict)

    @property
    def head(self) -> str:
        """The line at the head of every answer: rig, tissue, and all else that was said."""
        told = [f"rig {self.composition.rig}", f"tissue {self.composition.tissue}"]
        told += [
            f"{n} {_write_value(v)}" for n, v in self.stated.items() if n not in ("rig", "tissue")
        ]
        return f"Asked: {', '.join(told)}."

    def segments(self, measured: Measurements) -> list[Segment]:
        """Cut measurements into the stretches that are fitted."""
        return segments(measured, self.starts, self.site, self.lowpass, self.course)

    def instrument_for(self, measured: Measurements) -> Instrument:
        """Return the rig's constants as far as they are known for these measurements.

        A position that is the tip's has no spring beside it that tells the touch. Where nobody
        says where it is, the zero of others' positions may be anywhere; this suite's is the touch.

        Raises
        ------
        ParameterError
            If these are measurements of others, and nobody said of which rig.
        """
        own = all(part.is_own for part in measured.parts)
        if not (self.rig_given or own):
            raise ParameterError(WHICH_RIG)
        supposed = CONTACT_POSITION.name in self.instrument.supposed
        rig = self.composition.rig
        zeros = rig.tip_is_position and any(each.zero for each in self.composition.all_effects)
        any_zero = supposed and not (rig.load_cell_yields or own or zeros)
        return replace(self.instrument, any_zero=any_zero)

    @cached_property
    def library(self) -> Mapping[str, Effect]:
        """Effects that are tried.

        A comparison with a model whose machine code is on disk needs none, nor the seconds that
        SymPy and Numba take to be imported.

        Raises
        ------
        EffectError
            If a file of effects cannot be used.
        ParameterError
            If the prior, or ``without``, names something else.
        """
        from tissue_probe.physics import library

        found = library.effects(self.model.effect_files)
        for name, odds in self.prior.items():
            meant = [each for each in found.values() if name in (each.name, each.family)]
            if not meant:
                known = ", ".join(dict.fromkeys(each.family for each in found.values()))
                raise ParameterError(
                    f"`prior` {name}: there is no such effect or family; families are {known}"
                )
            found |= {each.name: each.with_odds(odds) for each in meant}
        for name in self.without:
            if name not in found:
                raise ParameterError(
                    f"`without` {name}: there is no such effect; known are {', '.join(found)}"
                )
        return {name: each for name, each in found.items() if name not in self.without}

    @property
    def composition(self) -> Composition:
        """The model that is asked about."""
        return self.model.composition


def question(**asked: Unpack[Asked]) -> ModelQuestion:
    """Put together a question.

    Raises
    ------
    ParameterError
        If something is not known, contradicts the model, or is out of its bounds.
    ModelFileError, EffectError
        If a file cannot be used.
    """
    if unknown := [name for name in asked if name not in Asked.__annotations__]:
        of_files = any(each.name == unknown[0] for each in fields(Layout))
        where = "it belongs to `tissue_probe.read`" if of_files else "see `Asked` for those known"
        raise TypeError(f"unexpected keyword argument {unknown[0]!r}; {where}")
    said = _checked_kinds(asked)
    model, rig, constants = said.get("model"), said.get("rig"), said.get("constants") or {}
    begun = _begin_model(model, _rig(rig), said.get("tissue"), said.get("effects", ()))
    notes: tuple[str, ...] = ()
    if begun.data and not begun.data.converged:
        name = "the model" if isinstance(model, FittedModel) else model
        notes = (f"{name}: the search for its values did not settle; take them for a guess",)
    odds = said.get("prior") or {}
    notes += tuple(PRIOR.format(name, times) for name, times in odds.items())
    found = ModelQuestion(
        begun,
        _instrument(begun.composition.rig, said.get("known_rig", False), constants),
        notes,
        not (rig is None and model is None and "load_cell_stiffness" not in constants),
        said.get("site"),
        said.get("lowpass"),
        said.get("starts", "auto"),
        said.get("course", "auto"),
        odds,
        said.get("without", ()),
        {name: value for name, value in said.items() if _is_said(ITEMS_BY_NAME[name], value)},
    )
    if begun.effect_files or found.prior or found.without:
        _ = found.library  # a file that cannot be used is told before anything is fitted
    return found


def _checked_kinds(asked: Mapping[str, Any]) -> dict[str, Any]:
    """Return the given values, each checked by its declared kind."""
    kinds = {each.name: _kind(each) for each in ITEMS}
    return {name: kinds[name](name, value) for name, value in asked.items()}


def _kind(item: Item) -> take.Kind:
    """Return which values an item takes; where nothing is said by default, None as well."""
    kind = {
        "choice": take.choice(*item.choices),
        "constants": take.by_name(constant, "numbers"),
        "file": either_model,
        "files": take.several(take.path, "paths"),
        "flag": take.flag,
        "names": take.several(take.text, "names of effects"),
        "number": take.number(),
        "odds": take.by_name(take.number(above=0.0), "numbers"),
        "whole": take.whole(),
    }[item.kind]
    if item.name == "rig":
        kind = _rig_itself(kind)
    return take.optional(kind) if item.default is None else kind


def either_model(name: str, given: Any) -> str | Path | FittedModel:
    """Take a model, or the path of its file."""
    return given if isinstance(given, FittedModel) else take.path(name, given)


def _rig_itself(kind: take.Kind) -> take.Kind:
    """Take a rig of the user's own beside the names of a kind."""
    return lambda name, given: given if isinstance(given, Rig) else kind(name, given)


def constant(name: str, given: Any) -> float | tuple[float, ...]:
    """Take a number, or one with its standard deviation."""
    if not isinstance(given, (tuple, list)):
        return float(take.number()(name, given))
    if len(given) != 2:
        take.refuse(name, given, "a number, or a number and its standard deviation")
    return tuple(take.number()(name, each) for each in given)


def _is_said(item: Item, given: Any) -> bool:
    """Whether something was said that would not be taken anyway."""
    return bool(given != item.default and (given or given == 0))


def _write_value(value: Any) -> str:
    """Write a given value in one line."""
    if isinstance(value, Mapping):
        pairs = ((n, v if isinstance(v, tuple) else (v,)) for n, v in value.items())
        return " ".join(f"{name}={'+-'.join(f'{each:g}' for each in v)}" for name, v in pairs)
    if isinstance(value, FittedModel):
        return "a fitted model"
    return str(value) if isinstance(value, (str, int, float, Path)) else " ".join(map(str, value))


def check_wanted(asked: ModelQuestion, wanted: Sequence[str]) -> None:
    """Refuse effects to add that are not known, in the model already, or one law with another.

    Raises
    ------
    ParameterError
        For the first of them.
    """
    own = {each.name: each for each in asked.composition.all_effects}
    for name in wanted:
        if name not in asked.library:
            known = ", ".join(asked.library)
            raise ParameterError(f"`add` {name}: no such effect; known are {known}")
        if name in asked.composition.names:
            raise ParameterError(f"`add` {name}: the model has it already; leave it out")
        own[name] = asked.library[name]
        for other in own:
            if other != name and not own[other].unknowns.isdisjoint(own[name].unknowns):
                raise ParameterError(
                    f"`add` {name}: it is a form of the law of {other}, which has the same "
                    "unknowns; leave one of them out"
                )


def _begin_model(
    model: str | Path | FittedModel | None,
    rig: Rig | None,
    tissue: str | None,
    effect_files: tuple[Path, ...],
) -> FittedModel:
    if model is None:
        plain = Composition(rig or OWN, tissue or "kelvin_voigt")
        return FittedModel(plain, {}, {}, effect_files=effect_files)
    found = _load(model, effect_files, rig)
    for name, given, own in (
        ("rig", rig, found.composition.rig),
        ("tissue", tissue, found.composition.tissue),
    ):
        if given and given != own:
            told = "" if isinstance(model, FittedModel) else f" {model}"
            raise ParameterError(
                f"`{name}` {given} contradicts `model`{told}, which is of a {own}; leave out one "
                "of them"
            )
    return found


def _rig(given: RigChoice | None) -> Rig | None:
    """Return the rig that is asked about, by its name or as itself."""
    if given is None:
        return None
    if isinstance(given, Rig):
        if RIGS.get(given.name, given) is not given:
            raise ParameterError(f"`rig` has the name of another rig, {given}: choose another")
        return given
    return RIGS[given]


def _load(
    model: str | Path | FittedModel, effect_files: tuple[Path, ...], rig: Rig | None
) -> FittedModel:
    """Return a model with the user's files of effects; YAML is imported only for a file."""
    if isinstance(model, FittedModel):
        files = dict.fromkeys((*model.effect_files, *effect_files))
        return replace(model, effect_files=tuple(files))
    from tissue_probe.physics.model_file import load

    return load(model, effect_files, rig)


def _instrument(rig: Rig, known: bool, constants: Constants) -> Instrument:
    """Return the rig's constants, those of the paper unless others are given."""
    values = rig.known
    flicker_noise = None
    for name, given in constants.items():
        value, deviation = given if isinstance(given, tuple) else (given, 0.0)
        if not 0.0 <= deviation < math.inf:
            raise ParameterError(
                f"`constant` {name}: its standard deviation is {deviation:g}; give 0 or more"
            )
        if name == FLICKER_NAME:
            if not 0.0 <= value < math.inf:
                raise ParameterError(
                    f"`constant` {name}: give its rms in newtons, 0 or more, not {value:g}"
                )
            flicker_noise = value
            continue
        if name not in (*values, *KNOWN_TISSUE):
            raise ParameterError(
                f"`constant` {name}: {name} is no constant of {rig}; "
                f"give one of {', '.join((*values, *KNOWN_TISSUE, FLICKER_NAME))}"
            )
        (entry,) = Composition(rig).entries([name])
        # How large it may be depends on the record; which sign it has, does not.
        right = value > 0.0 if entry.lower > 0.0 else value >= 0.0 or entry.lower < 0.0
        if not (right and math.isfinite(value)):
            least = "more than 0" if entry.lower > 0.0 else "0 or more"
            wanted = least if entry.lower >= 0.0 else "any number"
            raise ParameterError(
                f"`constant` {name}={value:g}: {name} of {rig} is {wanted} [{entry.unit}]; give "
                "one that is"
            )
        values[name] = (value, deviation)
    supposed = frozenset(values).difference(constants)
    chosen = Instrument(rig, values, flicker_noise, supposed)
    return chosen.exact() if known else chosen
