"""The options of ``compare``, ``diagnose`` and ``improve`` on model, instrument and samples.

Contents: from their declaration (``analysis.question_items``) to options, and back to keywords.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field, fields, make_dataclass
from enum import Enum
from pathlib import Path
from typing import Annotated, Any

import typer

from tissue_probe.analysis.question_items import ITEMS, Item
from tissue_probe.cli.arguments import in_a_folder
from tissue_probe.cli.options_named import with_options

Validate = Annotated[
    list[Path] | None,
    typer.Option(
        "--validate",
        metavar="FILE",
        help="Another recording of the same specimen: models are tried on it, not fitted.",
    ),
]
Json = Annotated[
    Path | None,
    typer.Option(
        "--json", metavar="FILE", callback=in_a_folder, help="Write the answer for programs."
    ),
]


def constants(texts: Sequence[str]) -> dict[str, float | tuple[float, float]]:
    """Return constants by name, with their standard deviations, of NAME=VALUE+-SD each.

    Raises
    ------
    ValueError
        If one is written otherwise.
    """
    return _by_name("--constant", texts, _read, "NAME=VALUE+-SD, such as tip_mass=0.04+-0.001")


def uncertain(option: str, text: str | None) -> tuple[float, float] | None:
    """Return a value with its standard deviation, of VALUE+-SD; None where nothing is said.

    Raises
    ------
    ValueError
        If it is written otherwise.
    """
    try:
        return None if text is None else _read(text)
    except ValueError:
        raise ValueError(f"{option} {text}: give VALUE+-SD, such as 0.004+-0.0001") from None


def _read(written: str) -> tuple[float, float]:
    value, given, deviation = written.partition("+-")
    return float(value), float(deviation) if given else 0.0


def odds(texts: Sequence[str]) -> dict[str, float]:
    """Return odds by name, of NAME=ODDS each.

    Raises
    ------
    ValueError
        If one is written otherwise.
    """
    return _by_name("--prior", texts, float, "NAME=ODDS, such as relaxation=10")


def _by_name(
    option: str, texts: Sequence[str], read: Callable[[str], Any], form: str
) -> dict[str, Any]:
    found = {}
    for text in texts:
        name, _, written = text.partition("=")
        try:
            found[name] = read(written)
        except ValueError:
            raise ValueError(f"{option} {text}: give {form}") from None
    return found


def write_json(path: Path, told: dict[str, object]) -> None:
    """Write an answer for programs; in its advice, parameters as the options that state them."""
    import json

    path.write_text(with_options(json.dumps(told, indent=2)) + "\n", encoding="utf-8")


def _keywords(asked: Any) -> dict[str, Any]:
    """Return the question as the analysis takes it."""
    found = {each.name: getattr(asked, each.name) for each in fields(asked)}
    return {name: _value(name, given) for name, given in found.items() if given is not None}


def _value(name: str, given: Any) -> Any:
    if isinstance(given, Enum):
        return given.value
    if name == "constants":
        return constants(given)
    return odds(given) if name == "prior" else given


#: Types of options by the kind of an item, and their values where nothing is said.
_OPTION_TYPES: dict[str, tuple[Any, Any]] = {
    "constants": (list[str] | None, None),
    "file": (Path | None, None),
    "files": (list[Path] | None, None),
    "flag": (bool, False),
    "names": (list[str] | None, None),
    "number": (float | None, None),
    "odds": (list[str] | None, None),
    "whole": (int | None, None),
}


def option(item: Item) -> tuple[str, Any, Any]:
    """Return name, annotation and default of the option that something is stated by."""
    type_, default = choice(item) if item.kind == "choice" else _OPTION_TYPES[item.kind]
    stated = typer.Option(
        f"--{(item.option or item.name).replace('_', '-')}",
        metavar=item.metavar or ("FILE" if item.kind in ("file", "files") else None),
        help=item.about,
        show_default=with_options(item.else_) or default is not None,
    )
    return item.name, Annotated[type_, stated], field(default=default)


def choice(item: Item) -> tuple[Any, Any]:
    """Return the type of a choice, and its value where nothing is said."""
    # Named as Python can name them: at_rest stands for at-rest.
    names = {each.replace("-", "_"): each for each in item.choices}
    type_ = Enum(item.name, names, type=str)  # type: ignore[misc]  # known when the item is
    return (type_ | None, None) if item.default is None else (type_, type_(item.default))


def _group(name: str, items: Sequence[Item]) -> Any:
    """Return a class whose value has ``keywords()``."""
    return make_dataclass(name, map(option, items), namespace={"keywords": _keywords})


#: All of them, and all but files, which a page does not name.
Asked = _group("Asked", ITEMS)
OfSamples = _group("OfSamples", [each for each in ITEMS if each.kind not in ("file", "files")])
