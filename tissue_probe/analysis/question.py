"""The model that is asked about: rig, tissue or model file, known constants, effects to try.

What belongs here: from the user's words to a composition, an instrument and a library.
What does not: measurements (``measurements``, ``segments``), fits (``diagnosis``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from tissue_probe.analysis.choices import TISSUE_NAMES, RigChoice, TissueName
from tissue_probe.diagnosis.observation.instrument import FLICKER, Instrument
from tissue_probe.errors import ParameterError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.rigs import OWN, RIGS, Rig
from tissue_probe.physics.rigs.constants import CONTACT_POSITION

if TYPE_CHECKING:
    from tissue_probe.analysis.measurements import Measurements
    from tissue_probe.physics.effects import Effect

#: What may be known of the tissue, such as that there is none.
TISSUE = ("stiffness", "damping")

Constants = Mapping[str, "float | tuple[float, float]"]
"""A constant's value, or value and standard deviation, by its name [SI units]."""

_OTHERS = ", ".join(f"{rig} {rig.whose}" for rig in RIGS.values() if rig is not OWN)
SUPPOSED = (
    f"No `rig` is given: this suite's own probe is supposed, {OWN}, {OWN.whose}. Give `rig` "
    f"{_OTHERS}."
)


@dataclass(frozen=True)
class Question:
    """A model, what is known of its rig, and the effects that it may miss.

    Attributes
    ----------
    model : FittedModel
        The model to begin with; without values, where it comes from no file.
    instrument : Instrument
        The rig's constants.
    notes : tuple of str
        What to know of the model, in sentences.
    rig_given : bool
        Whether the user said on which rig was measured.
    """

    model: FittedModel
    instrument: Instrument
    notes: tuple[str, ...] = ()
    rig_given: bool = True

    def notes_for(self, measured: Measurements) -> tuple[str, ...]:
        """Return what to know of the model for these measurements, in sentences.

        Others than this suite's own are seldom of its probe: a wrong rig is made up for by effects
        that are not there.
        """
        own = self.rig_given or all(part.is_own for part in measured.parts)
        return self.notes if own else (*self.notes, SUPPOSED)

    def instrument_for(self, measured: Measurements) -> Instrument:
        """Return the rig's constants as far as they are known for these measurements.

        A tip that follows the position exactly has no spring that tells the touch. Where nobody
        says where it is, the zero of others' positions may be anywhere; this suite's is the touch.
        """
        supposed = CONTACT_POSITION.name in self.instrument.supposed and not self.model.values
        own = all(part.is_own for part in measured.parts)
        led = self.composition.rig.tip_is_position
        zeros = any(effect.zero for effect in self.composition.all_effects)
        return replace(self.instrument, any_zero=supposed and led and not (own or zeros))

    @cached_property
    def library(self) -> Mapping[str, Effect]:
        """Effects that are tried.

        A comparison with a model whose machine code is on disk needs none, nor the seconds that
        SymPy and Numba take to be imported.

        Raises
        ------
        EffectError
            If a file of effects cannot be used.
        """
        from tissue_probe.physics import library

        return library.effects(self.model.effect_files)

    @property
    def composition(self) -> Composition:
        """The model that is asked about."""
        return self.model.composition


def question(
    model: str | Path | FittedModel | None = None,
    rig: RigChoice | None = None,
    tissue: TissueName | None = None,
    effects: Sequence[str | Path] = (),
    constants: Constants | None = None,
    known_rig: bool = False,
) -> Question:
    """Put together what is asked.

    Parameters
    ----------
    model : path or FittedModel, optional
        A model to begin with, in place of ``rig`` and ``tissue``.
    rig : str or Rig, optional
        A name in ``RIGS``, or a rig of the user's own; by default that of ``model``, else this
        suite's own probe.
    tissue : str, optional
        By default that of ``model``, else ``kelvin_voigt``.
    effects : sequence of path
        Python files with effects of the user's own; they are run.
    constants : mapping, optional
        Known constants of the rig and their standard deviations [SI], such as
        ``{"tip_mass": (0.04, 0.001)}``, or of the tissue, such as ``{"stiffness": 0.0}``.
    known_rig : bool
        Take the rig's constants as exactly known.

    Raises
    ------
    ParameterError
        If something is not known, contradicts the model, or is out of its bounds.
    ModelFileError, EffectError
        If a file cannot be used.
    """
    effects = [effects] if isinstance(effects, (str, Path)) else effects
    begun = _begun(model, _rig(rig), tissue, tuple(map(Path, effects)))
    notes: tuple[str, ...] = ()
    if begun.data and not begun.data.converged:
        name = "the model" if isinstance(model, FittedModel) else model
        notes = (f"{name}: the search for its values did not settle; take them for a guess",)
    instrument = _instrument(begun.composition.rig, known_rig, constants or {})
    given = not (rig is None and model is None and "load_cell_stiffness" not in (constants or {}))
    asked = Question(begun, instrument, notes, given)
    if begun.effect_files:
        _ = asked.library  # a file that cannot be used is told before anything is fitted
    return asked


def check_wanted(asked: Question, wanted: Sequence[str]) -> None:
    """Refuse effects to add that are not known, or in the model already.

    Raises
    ------
    ParameterError
        For the first of them.
    """
    for name in wanted:
        if name not in asked.library:
            known = ", ".join(asked.library)
            raise ParameterError(f"`add` {name}: no such effect; known are {known}")
        if name in asked.composition.names:
            raise ParameterError(f"`add` {name}: the model has it already; leave it out")


def _begun(
    model: str | Path | FittedModel | None,
    rig: Rig | None,
    tissue: str | None,
    effect_files: tuple[Path, ...],
) -> FittedModel:
    if tissue is not None and tissue not in TISSUE_NAMES:
        raise ParameterError(f"`tissue` is {tissue!r}; give one of {', '.join(TISSUE_NAMES)}")
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
    if given not in RIGS:
        raise ParameterError(f"`rig` is {given!r}; give one of {', '.join(RIGS)}")
    return RIGS[given]


def _load(
    model: str | Path | FittedModel, effect_files: tuple[Path, ...], rig: Rig | None
) -> FittedModel:
    """Return a model with the user's files of effects; what reads YAML is imported for a file."""
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
        if name == FLICKER:
            if not 0.0 <= value < math.inf:
                raise ParameterError(
                    f"`constant` {name}: give its rms in newtons, 0 or more, not {value:g}"
                )
            flicker_noise = value
            continue
        if name not in (*values, *TISSUE):
            raise ParameterError(
                f"`constant` {name}: {name} is no constant of {rig}; "
                f"give one of {', '.join((*values, *TISSUE, FLICKER))}"
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
