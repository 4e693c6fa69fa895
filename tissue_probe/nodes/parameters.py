"""ROS parameters declared from settings: one declaration of type, unit, range and meaning."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

from pydantic import BaseModel
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

from tissue_probe.settings import Settings, SettingsError, bound, build, meaning, rule


def declare(
    node: Node, settings: type[BaseModel], prefix: str = "", *, live: Collection[str] = ()
) -> None:
    """Declare a parameter for every field of ``settings``, named ``prefix`` + field.

    The fields named in ``live`` may be set while the node runs, if ``follow_changes`` is called,
    too; all others take their value when the node starts.

    Raises
    ------
    SettingsError
        If a value given at start-up has the wrong type or is out of range.
    """
    for name, field in settings.model_fields.items():
        descriptor = ParameterDescriptor(
            description=meaning(field),
            additional_constraints=rule(field),
            read_only=name not in live,
        )
        _set_range(descriptor, field)
        # rclpy takes an empty list for one of bytes; of which type it is, ``read`` checks.
        descriptor.dynamic_typing = field.default in ([], ())
        try:
            node.declare_parameter(prefix + name, field.get_default(), descriptor)
        except (ParameterException, TypeError, ValueError) as error:
            # rclpy's own words go on with the range, without its unit.
            given = str(error).partition(" for parameter.")[0]
            hint = ", with a decimal point" if field.annotation is float else ""
            raise SettingsError(
                f"parameter {prefix}{name}: give {rule(field)}{hint} ({given})"
            ) from None


def read(node: Node, settings: type[Settings], prefix: str = "") -> Settings:
    """Return the parameters that ``declare`` declared, as one checked object.

    Raises
    ------
    SettingsError
        If a value is out of its range, or the values do not go together.
    """
    values = {name: node.get_parameter(prefix + name).value for name in settings.model_fields}
    return build(settings, values, f"parameter {prefix}")


def follow_changes(
    node: Node,
    models: dict[str, type[BaseModel]],
    on_change: Callable[[], None],
    refuse: Callable[[str], str] = lambda name: "",
    examine: Callable[[Any], str] = lambda settings: "",
) -> None:
    """Judge changes of live parameters, and call ``on_change`` after those that are accepted.

    Parameters
    ----------
    node : Node
        Whose parameters.
    models : dict
        The declared settings by their prefix. A change is accepted if all are valid with it.
    on_change : callable
        Called when changed values can be ``read``.
    refuse : callable
        Says why the parameter of a name cannot be changed now; empty if it can.
    examine : callable
        Says why settings that are valid cannot be in force; empty if they can.
    """

    def judge(changes: list[Parameter]) -> SetParametersResult:
        reasons = [reason for change in changes if (reason := refuse(change.name))]
        if reasons:
            return SetParametersResult(successful=False, reason=reasons[0])
        return _validate_together(node, models, changes, examine)

    node.add_on_set_parameters_callback(judge)
    node.add_post_set_parameters_callback(lambda changes: on_change())


def _validate_together(
    node: Node,
    models: dict[str, type[BaseModel]],
    changes: list[Parameter],
    examine: Callable[[BaseModel], str],
) -> SetParametersResult:
    changed = {parameter.name: parameter.value for parameter in changes}
    try:
        for prefix, settings in models.items():
            values = {
                name: changed.get(prefix + name, node.get_parameter(prefix + name).value)
                for name in settings.model_fields
            }
            if reason := examine(build(settings, values, f"parameter {prefix}")):
                return SetParametersResult(successful=False, reason=reason)
    except SettingsError as error:
        return SetParametersResult(successful=False, reason=str(error))
    return SetParametersResult(successful=True)


def _set_range(descriptor: ParameterDescriptor, field: FieldInfo) -> None:
    """Put the closed range around a field's values where ROS tools look for it."""
    low = bound(field, "gt") if bound(field, "ge") is None else bound(field, "ge")
    high = bound(field, "lt") if bound(field, "le") is None else bound(field, "le")
    if low is None or high is None:
        return
    if field.annotation is int:
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
    elif field.annotation is float:
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high), step=0.0)
        ]
