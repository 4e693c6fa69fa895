"""ROS parameters declared from pydantic models: one declaration of type, unit, range and meaning."""

from __future__ import annotations

import typing

import annotated_types
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter

Settings = typing.TypeVar("Settings", bound=BaseModel)

_TYPES = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}


class ParameterError(ValueError):
    """A parameter has the wrong type or lies out of its range; the message says what it takes."""


def declare(node: Node, settings: type[BaseModel], prefix: str = "", *, fixed: bool = True) -> None:
    """Declare a parameter for every field of ``settings``, named ``prefix`` + field.

    ``fixed`` parameters take their value when the node starts and cannot be set afterwards.

    Raises
    ------
    ParameterError
        If a value given at start-up has the wrong type or is out of range.
    """
    for name, field in settings.model_fields.items():
        descriptor = ParameterDescriptor(
            description=_meaning(field), additional_constraints=_rule(field), read_only=fixed
        )
        _set_range(descriptor, field)
        try:
            node.declare_parameter(prefix + name, field.get_default(), descriptor)
        except (ParameterException, TypeError, ValueError) as error:
            raise ParameterError(f"parameter {prefix}{name}: give {_rule(field)} ({error})") from None


def read(node: Node, settings: type[Settings], prefix: str = "") -> Settings:
    """Return the parameters that ``declare`` declared, as one checked object.

    Raises
    ------
    ParameterError
        If a value is out of its range, or the values do not go together.
    """
    values = {name: node.get_parameter(prefix + name).value for name in settings.model_fields}
    return build(settings, values, prefix)


def build(settings: type[Settings], values: dict, prefix: str = "") -> Settings:
    """Make ``settings`` of parameter values.

    Raises
    ------
    ParameterError
        If a value is out of its range, or the values do not go together.
    """
    try:
        return settings.model_validate(values)
    except ValidationError as error:
        raise ParameterError(_sentence(settings, prefix, error)) from None


def validate_together(
    node: Node, models: dict[str, type[BaseModel]], changes: list[Parameter]
) -> SetParametersResult:
    """Judge changes of parameters for ``add_on_set_parameters_callback``.

    ``models`` gives the declared settings by their prefix. A change is accepted if all the
    settings are valid with it.
    """
    changed = {parameter.name: parameter.value for parameter in changes}
    try:
        for prefix, settings in models.items():
            values = {
                name: changed.get(prefix + name, node.get_parameter_or(prefix + name).value)
                for name in settings.model_fields
            }
            build(settings, values, prefix)
    except ParameterError as error:
        return SetParametersResult(successful=False, reason=str(error))
    return SetParametersResult(successful=True)


def unit(field: FieldInfo) -> str:
    """Return a field's unit in brackets after a space, or nothing where it has none."""
    extra = field.json_schema_extra
    symbol = extra.get("unit") if isinstance(extra, dict) else None
    return f" [{symbol}]" if symbol else ""


def _meaning(field: FieldInfo) -> str:
    return f"{field.description or ''}{unit(field)}".strip()


def _rule(field: FieldInfo) -> str:
    """Say in words which values a field takes."""
    if typing.get_origin(field.annotation) is typing.Literal:
        return "one of " + ", ".join(map(str, typing.get_args(field.annotation)))
    kind = _TYPES.get(field.annotation, "a list of texts")
    bounds = "".join(
        f"{word} {value:g}"
        for attribute, word in (("gt", " above"), ("ge", " from"), ("lt", " below"), ("le", " to"))
        if (value := _bound(field, attribute)) is not None
    )
    return f"{kind}{bounds}{unit(field)}"


def _bound(field: FieldInfo, attribute: str) -> float | None:
    for constraint in field.metadata:
        if isinstance(
            constraint,
            annotated_types.Gt | annotated_types.Ge | annotated_types.Lt | annotated_types.Le,
        ) and hasattr(constraint, attribute):
            return getattr(constraint, attribute)
    return None


def _set_range(descriptor: ParameterDescriptor, field: FieldInfo) -> None:
    """Put the closed range around a field's values where ROS tools look for it."""
    low = _bound(field, "ge") if _bound(field, "ge") is not None else _bound(field, "gt")
    high = _bound(field, "le") if _bound(field, "le") is not None else _bound(field, "lt")
    if low is None or high is None:
        return
    if field.annotation is int:
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
    elif field.annotation is float:
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high), step=0.0)
        ]


def _sentence(settings: type[BaseModel], prefix: str, error: ValidationError) -> str:
    first = error.errors()[0]
    if not first["loc"]:
        return f"parameters {prefix}*: {first['msg'].removeprefix('Value error, ')}"
    name = str(first["loc"][0])
    field = settings.model_fields.get(name)
    rule = _rule(field) if field else "nothing of that name"
    return f"parameter {prefix}{name} is {first['input']!r}: give {rule}"
