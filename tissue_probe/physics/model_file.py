"""``model.yaml``: a composed model with its numbers, as the fit, the probe and the filters take it.

Contents: the file's fields, and the way between them and a ``Composition``.
"""

from __future__ import annotations

import datetime
import hashlib
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

from tissue_probe import arguments as take
from tissue_probe import bounded_yaml
from tissue_probe.errors import check_file
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effect_scale import resize_effect
from tissue_probe.physics.effects import EFFECTS, Effect
from tissue_probe.physics.entry import Entry
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.library import EffectError, effects, load_effects
from tissue_probe.physics.rigs import RIGS, Rig
from tissue_probe.physics.scale import Scale
from tissue_probe.physics.tissue_names import TissueName
from tissue_probe.settings import SettingsError, rule, setting


class ModelFileError(SettingsError):
    """A model file that cannot be used; the message says where, why, and the remedy."""


class UnnamedEffectError(ModelFileError):
    """A model file needs an effect of the user's own, and the user has not named its Python file.

    Parameters
    ----------
    path : path
        The model file.
    effect : str
        The effect.
    made_with : str
        The Python file that the effect was in, as the model file tells it.
    """

    def __init__(self, path: Path, effect: str, made_with: str) -> None:
        self._given = path, effect, made_with
        super().__init__(
            f"{path} needs the effect {effect!r}, which is not in the library but in the Python "
            f"file {made_with!r}: a model file runs no code by itself, so, if you trust that file, "
            "name it by `effects`"
        )

    def __reduce__(self) -> Any:
        """Come back from bytes as it was raised, in another process."""
        return type(self), self._given


class _FileEntry(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class ModelNumber(_FileEntry):
    """One number of the model; a deviation of 0 says that it was held."""

    value: float = setting(..., "", "in the unit told")
    deviation: float = setting(0.0, "", "standard deviation of its error, same unit", ge=0.0)
    unit: str = setting(..., "", "SI")


class EffectEntry(_FileEntry):
    """One effect: its name, its form where there are several, the file of a user's own."""

    name: str = setting(..., "", "as `tissue_probe.physics.effects` or the file has it")
    form: int = setting(0, "", "0 for the effect itself, n for its n-th other form", ge=0)
    file: str = setting(
        "", "", "Python file that defined it, from the model file's folder; told, never run"
    )


class DataFile(_FileEntry):
    """One file that the model was fitted to."""

    name: str = setting(..., "", "without its folder")
    sha256: str = setting(..., "", "of the file's bytes, in hexadecimal")


class Data(_FileEntry):
    """The observations of the numbers, and how well they fit them.

    Noise and errors are of the channel that the rig's models predict: a force [N], or a position
    [m].
    """

    files: tuple[DataFile, ...] = setting((), "", "fitted together")
    date: datetime.date = setting(..., "", "day of the fit")
    noise: float = setting(..., "", "standard deviation of the output's white noise", gt=0.0)
    rmse_training: float = setting(..., "", "error on the fitted samples", ge=0.0)
    rmse_heldout: float = setting(..., "", "error on held-out samples", ge=0.0)
    converged: bool = setting(True, "", "whether the search for the numbers settled")
    lowest: float | None = setting(None, "m", "lowest position of the fitted samples")
    highest: float | None = setting(None, "m", "highest position of the fitted samples")
    fastest: float | None = setting(None, "m/s", "speed that 99 % of them do not exceed", ge=0.0)

    @staticmethod
    def of(
        files: Iterable[str | Path],
        noise: float,
        rmse_training: float,
        rmse_heldout: float,
        converged: bool = True,
    ) -> Data:
        """Describe a fit of today to files, whose bytes are read.

        Parameters
        ----------
        files : iterable of path
            The files that the model was fitted to.
        noise, rmse_training, rmse_heldout : float
            White noise of the output, and the fit's errors.
        converged : bool
            Whether the search for the numbers settled.
        """
        told = tuple(
            DataFile(
                name=Path(path).name, sha256=hashlib.sha256(Path(path).read_bytes()).hexdigest()
            )
            for path in files
        )
        return Data(
            files=told,
            date=datetime.date.today(),
            noise=noise,
            rmse_training=rmse_training,
            rmse_heldout=rmse_heldout,
            converged=converged,
        )


class Size(_FileEntry):
    """How many times larger than usual the records are that the model is for (``Scale``)."""

    length: float = setting(1.0, "", "of lengths", gt=0.0)
    force: float = setting(1.0, "", "of forces", gt=0.0)
    time: float = setting(1.0, "", "of times", gt=0.0)
    input2: float = setting(1.0, "", "of the second input", gt=0.0)


class ModelFile(_FileEntry):
    """The file, field by field."""

    version: Literal[1] = setting(..., "", "of this layout")
    rig: str = setting(..., "", "how the instrument couples to the tissue")
    tissue: TissueName = setting(..., "", "the tissue that the tip presses on")
    size: Size = setting(Size(), "", "by which constants of its laws are larger, such as a depth")
    effects: tuple[EffectEntry, ...] = setting((), "", "further physics, in order")
    constants: dict[str, ModelNumber] = setting(..., "", "the rig's")
    parameters: dict[str, ModelNumber] = setting(..., "", "the tissue's and the effects'")
    data: Data | None = setting(None, "", "where the numbers came from")


def save(
    path: str | Path,
    composition: Composition,
    values: Mapping[str, float],
    deviations: Mapping[str, float],
    data: Data | None = None,
    effect_files: Sequence[str | Path] = (),
) -> None:
    """Write a model file; ``load`` gives the same again, to the last digit.

    Parameters
    ----------
    path : path
        Where to; a file that is there is replaced.
    composition : Composition
        The model.
    values, deviations : mapping of float
        Each constant and parameter by name (SI); one without a deviation was held.
    data : Data, optional
        The observations of the numbers.
    effect_files : sequence of path
        Python files of the effects that are the user's own.

    Raises
    ------
    ModelFileError
        If a value is missing, or an effect is neither in the library nor in the files.
    """
    path = Path(path)
    entries = [_entry(effect, path, effect_files) for effect in composition.effects]
    constants = {str(symbol) for symbol in composition.model.constants}
    declared = _declared(composition)
    missing = [entry.name for entry in declared if entry.name not in values]
    if missing:
        raise ModelFileError(f"{path} is not written: no value for {', '.join(missing)}")
    quantities = {
        entry.name: {
            "value": float(values[entry.name]),
            "deviation": float(deviations.get(entry.name, 0.0)),
            "unit": entry.unit,
        }
        for entry in declared
    }
    content = {
        "version": 1,
        "rig": composition.rig.name,
        "tissue": composition.tissue,
        "effects": entries,
        "constants": {name: q for name, q in quantities.items() if name in constants},
        "parameters": {name: q for name, q in quantities.items() if name not in constants},
    }
    if not composition.scale.is_usual:
        content["size"] = asdict(composition.scale)
    if data is not None:
        content["data"] = data.model_dump(mode="json")
    _validated(path, content)
    path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")


@take.checks(
    path=take.path,
    effect_files=take.several(take.path, "paths"),
    rig=take.optional(take.instance(Rig, "a rig of your own")),
)
def load(
    path: str | Path, effect_files: Sequence[str | Path] = (), rig: Rig | None = None
) -> FittedModel:
    """Read a model file.

    The Python files that it names are not run: a model file may come from anywhere.

    Parameters
    ----------
    path : path
        The file.
    effect_files : sequence of path
        Python files with the effects of the user's own that it needs, and others; they are run.
    rig : Rig, optional
        The user's own that it needs.

    Raises
    ------
    UnnamedEffectError
        If it needs an effect that is neither in the library nor in those files.
    ModelFileError
        If it is no model file, or its parts do not go together.
    NoFileError
        If there is no such file.
    OSError
        If it cannot be read.
    """
    path = Path(path)
    check_file(path)
    text = _read_text(path)
    file = _validated(path, _content(path, text))
    # One file may be named twice, by different ways to it.
    own_files = tuple({Path(each).resolve(): Path(each) for each in effect_files}.values())
    try:
        library = effects(own_files)
    except EffectError as error:
        raise ModelFileError(f"{path}: {error}") from None
    scale = Scale(**file.size.model_dump())
    chosen = tuple(_effect(path, entry, library, scale) for entry in file.effects)
    composition = Composition(_rig(path, file, rig), file.tissue, chosen, scale)
    _consistent(path, file, composition)
    quantities = file.constants | file.parameters
    return FittedModel(
        composition,
        {name: quantity.value for name, quantity in quantities.items()},
        {name: quantity.deviation for name, quantity in quantities.items()},
        file.data,
        own_files,
        text,
    )


def _read_text(path: Path) -> str:
    try:
        return bounded_yaml.read_text(path)
    except bounded_yaml.YamlError as error:
        raise ModelFileError(f"{path} is not a model.yaml: it {error}") from None


def _content(path: Path, text: str) -> dict[str, Any]:
    """Read the fields of a file; its further content is not quoted."""
    try:
        content = bounded_yaml.parse(text)
    except bounded_yaml.YamlError as error:
        raise ModelFileError(f"{path} is not a model.yaml: it {error}") from None
    if not isinstance(content, dict) or not content.keys() & ModelFile.model_fields.keys():
        raise ModelFileError(
            f"{path} is not a model.yaml: it has no rig, tissue and parameters; give a file that "
            "tissue_probe improve wrote"
        )
    return content


def _declared(composition: Composition) -> tuple[Entry, ...]:
    # Of the symbols: the kernel, which has the names too, may still have to be compiled.
    return composition.entries(map(str, composition.model.values))


def _validated(path: Path, content: object) -> ModelFile:
    try:
        return ModelFile.model_validate(content)
    except ValidationError as error:
        raise ModelFileError(f"{path}: {_first_complaint(error)}") from None


def _entry(effect: Effect, path: Path, effect_files: Sequence[str | Path]) -> dict[str, Any]:
    """Say where an effect is found again."""
    folder = path.resolve().parent
    known = effects(effect_files).get(effect.name)
    form = None if known is None else _form_of(effect, known)
    if form is None:
        raise ModelFileError(
            f"{path} is not written: the effect {effect.name} is not in the library; say in which "
            "file it is"
        )
    entry: dict[str, Any] = {"name": effect.name}
    if form:
        entry["form"] = form
    for file in effect_files:
        if any(each.name == effect.name for each in load_effects(file)):
            entry["file"] = os.path.relpath(Path(file).resolve(), folder)
    return entry


def _form_of(effect: Effect, known: Effect) -> int | None:
    # By its text: functions of a file that was loaded twice are not the same ones.
    forms = [repr(form.plain) for form in known.every_form]
    said = repr((effect.origin or effect).plain)
    return forms.index(said) if said in forms else None


def _rig(path: Path, file: ModelFile, own: Rig | None) -> Rig:
    known = RIGS if own is None else {own.name: own, **RIGS}
    if file.rig not in known:
        told = "a rig of your own is given to Python's `load_model`"
        raise ModelFileError(f"{path}: rig is {file.rig!r}: give {_WANTED['rig']}; {told}")
    return known[file.rig]


def _effect(path: Path, entry: EffectEntry, library: Mapping[str, Effect], scale: Scale) -> Effect:
    if entry.name not in library and entry.file:
        raise UnnamedEffectError(path, entry.name, str(path.parent / entry.file))
    if entry.name not in library:
        raise ModelFileError(
            f"{path}: there is no effect {entry.name!r}; there are {', '.join(library)}"
        )
    effect = library[entry.name]
    forms = effect.every_form
    if entry.form >= len(forms):
        raise ModelFileError(
            f"{path}: effect {entry.name} has no form {entry.form}: give 0 to {len(forms) - 1}"
        )
    form, ours = forms[entry.form], effect is EFFECTS.get(entry.name)
    return resize_effect(form, scale) if ours and not form.absolute else form


def _consistent(path: Path, file: ModelFile, composition: Composition) -> None:
    """Raise an error for the first thing that does not go with the composition."""
    names = list(composition.names)
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice:
        raise ModelFileError(f"{path}: effect {twice} is there twice: leave one out")
    try:
        constants = {str(symbol) for symbol in composition.model.constants}
    except ValueError as error:
        raise ModelFileError(f"{path}: {error}") from None
    wanted = {entry.name: entry for entry in _declared(composition)}
    for section in ("constants", "parameters"):
        given = getattr(file, section)
        here = {n: e for n, e in wanted.items() if (n in constants) == (section == "constants")}
        for name in given:
            if name not in here:
                raise ModelFileError(
                    f"{path}: {section}.{name} is nothing that this model has; it has "
                    f"{', '.join(here)}"
                )
        for name, entry in here.items():
            if name not in given:
                raise ModelFileError(f"{path}: {section}.{name} is missing: give it [{entry.unit}]")
            if given[name].unit != entry.unit:
                raise ModelFileError(
                    f"{path}: {section}.{name}.unit is {given[name].unit!r}: convert to "
                    f"{entry.unit!r}"
                )
            if not entry.lower <= given[name].value <= entry.upper:
                raise ModelFileError(
                    f"{path}: {section}.{name}.value is {given[name].value:g}: give a number from "
                    f"{entry.lower:g} to {entry.upper:g} [{entry.unit}]"
                )


def _first_complaint(error: ValidationError) -> str:
    """Say in one clause which field is wrong, and the allowed values."""
    complaint = error.errors()[0]
    place = complaint["loc"]
    name = ".".join(map(str, place)) or "the file"
    model = _model_at(place)
    if complaint["type"] == "extra_forbidden":
        return f"there is no {name}; there are {', '.join(model.model_fields)}"
    found = "missing" if complaint["type"] == "missing" else repr(complaint["input"])[:60]
    if place and place[-1] in model.model_fields:
        field = model.model_fields[place[-1]]
        simple = field.annotation in (int, float, str) or "Literal" in repr(field.annotation)
        wanted = _WANTED.get(str(place[-1])) or (rule(field) if simple else "a mapping")
    else:
        wanted = f"the fields {', '.join(model.model_fields)}"
    return f"{name} is {found}: give {wanted}"


_WANTED = {
    "rig": f"one of {', '.join(RIGS)}",
    "effects": "a list of effects, each with a name",
    "size": "a mapping of length, force and time",
    "files": "a list of files, each with name and sha256",
    "date": "a day such as 2026-11-20",
    "converged": "true or false",
    "lowest": "a number [m]",
    "highest": "a number [m]",
    "fastest": "a number of 0 or more [m/s]",
}


def _model_at(place: tuple[int | str, ...]) -> type[BaseModel]:
    """Return the class in which the last name of a place is a field, or the one at the place."""
    if not place:
        return ModelFile
    depth = len(place)
    if place[0] in ("constants", "parameters") and depth > 1:
        return ModelNumber
    if place[0] == "size" and depth > 1:
        return Size
    if place[0] == "effects" and depth > 1:
        return EffectEntry
    if place[0] == "data" and depth > 1:
        return DataFile if place[1] == "files" and depth > 2 else Data
    return ModelFile
