"""Settings: values with a type, a unit, a range and a meaning, and clear words when one is wrong.

A settings class is a pydantic model with one field a value; a field's unit stands in its
``json_schema_extra``. Nodes declare their parameters from it, the command line shows it.
"""

from __future__ import annotations

import typing

import annotated_types
from pydantic import BaseModel, Field, ValidationError
from pydantic.fields import FieldInfo

from tissue_probe.errors import TissueProbeError

Settings = typing.TypeVar("Settings", bound=BaseModel)

_TYPE_WORDS: dict[typing.Any, str] = {
    **{bool: "true or false", int: "a whole number", float: "a number", str: "a text"},
    list[float]: "a list of numbers",
}
_BOUNDS = {"gt": " above", "ge": " from", "lt": " below", "le": " to"}
_CONSTRAINTS = (annotated_types.Gt, annotated_types.Ge, annotated_types.Lt, annotated_types.Le)


class SettingsError(TissueProbeError):
    """A value has the wrong type or lies out of its range; the message says the allowed values."""


def setting(default: typing.Any, unit: str, description: str, **bounds: typing.Any) -> typing.Any:
    """Return a pydantic field with a unit ("" for none) and bounds (gt, ge, lt, le)."""
    extra: dict[str, typing.Any] | None = {"unit": unit} if unit else None
    return Field(default, description=description, json_schema_extra=extra, **bounds)


def build(settings: type[Settings], values: dict[str, typing.Any], prefix: str = "") -> Settings:
    """Make settings of values by name; ``prefix`` stands before the names in error messages.

    Raises
    ------
    SettingsError
        If a value is out of its range, or the values do not go together.
    """
    for name, value in values.items():
        field = settings.model_fields.get(name)
        if field is not None and field.annotation in (int, float) and isinstance(value, bool):
            raise SettingsError(f"{prefix}{name} is {value}: give {rule(field)}")
    try:
        return settings.model_validate(values)
    except ValidationError as error:
        raise SettingsError(_sentence(settings, prefix, error)) from None


def meaning(field: FieldInfo) -> str:
    """Return a field's meaning, with its unit in brackets."""
    return f"{field.description or ''}{_unit(field)}".strip()


def rule(field: FieldInfo) -> str:
    """Say in words which values a field takes, such as 'a number from 0.1 to 30 [Hz]'."""
    if typing.get_origin(field.annotation) is typing.Literal:
        return "one of " + ", ".join(map(str, typing.get_args(field.annotation)))
    kind = _TYPE_WORDS.get(field.annotation, "a list of texts")
    bounds = " and".join(
        f"{word} {value:g}"
        for attribute, word in _BOUNDS.items()
        if (value := bound(field, attribute)) is not None
    )
    # "from 1 to 2" needs no "and"; "above 1 and below 2" does.
    bounds = bounds.replace(" and to", " to")
    return f"{kind}{bounds}{_unit(field)}"


def bound(field: FieldInfo, attribute: str) -> float | None:
    """Return a field's bound 'gt', 'ge', 'lt' or 'le', None where it has none."""
    for constraint in field.metadata:
        if isinstance(constraint, _CONSTRAINTS) and hasattr(constraint, attribute):
            found: float = getattr(constraint, attribute)
            return found
    return None


def _unit(field: FieldInfo) -> str:
    extra = field.json_schema_extra
    symbol = extra.get("unit") if isinstance(extra, dict) else None
    return f" [{symbol}]" if symbol else ""


def _sentence(settings: type[BaseModel], prefix: str, error: ValidationError) -> str:
    first = error.errors()[0]
    if not first["loc"]:
        together = f"{prefix}*: " if prefix else ""
        return together + first["msg"].removeprefix("Value error, ")
    name = str(first["loc"][0])
    field = settings.model_fields.get(name)
    if field is None:
        return f"there is no {prefix}{name}; there are {', '.join(settings.model_fields)}"
    given = "missing" if first["type"] == "missing" else repr(first["input"])
    return f"{prefix}{name} is {given}: give {rule(field)}"
