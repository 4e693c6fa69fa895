"""Input from outside, checked against a declaration of its types, names and bounds.

Contents: reading JSON, and the sentence on a value that does not fit.
"""

from __future__ import annotations

import reprlib
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails, from_json

from tissue_probe.workbench.refusal import RequestRefused


class Declared(BaseModel):
    """Holds its declared fields and nothing else; a text is no number, and no number is NaN."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


Kind = TypeVar("Kind", bound=Declared)


def as_object(text: str | bytes, subject: str) -> dict[str, Any]:
    """Return the object that a text of JSON holds.

    Parameters
    ----------
    text : str or bytes
        JSON.
    subject : str
        Its name, with which the sentence begins.

    Raises
    ------
    Refused
        If it is no JSON, is nested too deep to be read, or holds anything else.
    """
    try:
        # Python's own reader runs out of its stack on brackets in brackets, and takes NaN and half
        # of a pair of surrogates, which no file can hold.
        found = from_json(text, allow_inf_nan=False)
    except ValueError as error:
        raise RequestRefused(f"{subject} is JSON; this is none: {error}") from None
    if not isinstance(found, dict):
        raise RequestRefused(f"{subject} is an object, and no {type(found).__name__}")
    return found


def check_declared(kind: type[Kind], given: dict[str, Any], subject: str) -> Kind:
    """Return given values as an object of their declaration.

    Raises
    ------
    Refused
        If it does not fit; says the first place, and the values allowed there.
    """
    try:
        return kind.model_validate(given)
    except ValidationError as error:
        raise RequestRefused(_sentence(subject, error.errors(include_url=False)[0])) from None


def shorten_value(value: object) -> str:
    """Return a given value as a sentence shows it: its beginning and its end, if it is long."""
    return reprlib.repr(value)


def _sentence(subject: str, first: ErrorDetails) -> str:
    if first["type"] == "value_error":  # a field's own check has its own sentence
        return str(first["ctx"]["error"])
    place = ".".join(map(str, first["loc"]))
    if first["type"] == "missing":
        return f"{subject}: `{place}` is missing"
    if first["type"] == "extra_forbidden":
        return f"{subject}: there is no `{place}` in it"
    told = first["msg"].replace("Input should", "it should")
    return f"{subject}: `{place}` is {shorten_value(first['input'])}; {told}"
