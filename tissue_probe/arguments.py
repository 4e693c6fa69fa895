"""A caller's arguments, checked where they come in: a value of its kind, or one true sentence.

Contents: kinds of values, and the sentence that refuses any other value.

A kind is a function of a parameter's name and of the given value. It returns the value as the
function takes it, of Python's own types. It imports no NumPy: a program that refuses takes none.
"""

from __future__ import annotations

import inspect
import math
import os
from collections.abc import Callable, Iterable, Mapping
from decimal import Decimal
from functools import wraps
from numbers import Integral, Real
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from tissue_probe.call_cache import during_a_call
from tissue_probe.errors import FileError, ParameterError
from tissue_probe.one_line import sentence

Kind = Callable[[str, Any], Any]

_F = TypeVar("_F", bound=Callable[..., Any])

#: Larger than any quantity; the square of its square is a number still, as a fit takes it.
LARGEST_NUMBER = 1e75

#: Characters of a value that a sentence repeats: a line of text has about as many.
CHARACTERS_SHOWN = 60


def checks(**kinds: Kind) -> Callable[[_F], _F]:
    """Let a public function take nothing but values of its parameters' kinds.

    An error of the operating system with a file, which tells the file and the fault, becomes one of
    the family as well. Values kept for the call go with it (``call_cache``).

    Parameters
    ----------
    **kinds : kind
        By the parameter's name; a parameter that is not named is checked by the function itself.
    """

    def check_function(function: _F) -> _F:
        signature = inspect.signature(function)
        if unknown := kinds.keys() - signature.parameters.keys():
            raise TypeError(f"{function.__qualname__} has no parameter {unknown.pop()}")

        @wraps(function)
        def call_checked(*args: Any, **kwargs: Any) -> Any:
            bound = signature.bind(*args, **kwargs)
            for name, kind in kinds.items():
                if name in bound.arguments:
                    bound.arguments[name] = kind(name, bound.arguments[name])
            try:
                with during_a_call():
                    return function(*bound.args, **bound.kwargs)
            except OSError as error:
                if isinstance(error, FileError) or error.filename is None:
                    raise
                raise FileError(sentence(error)) from error

        return call_checked  # type: ignore[return-value]

    return check_function


def refuse(name: str, given: object, wanted: str) -> NoReturn:
    """Raise the error that says the given value of a parameter, and the allowed ones.

    Parameters
    ----------
    name : str
        Of the parameter; after a blank, of one of its parts.
    given : object
        The given value.
    wanted : str
        The allowed values, in words.

    Raises
    ------
    ParameterError
        Always.
    """
    whole, blank, part = name.partition(" ")
    raise ParameterError(f"`{whole}`{blank}{part} is {_shorten_value(given)}; give {wanted}")


def _shorten_value(given: object) -> str:
    """Write the given value, in short; of an object that is no plain value its type."""
    if given is None or isinstance(given, (str, bytes, Real, complex, Decimal, os.PathLike)):
        try:
            text = str(given) if isinstance(given, os.PathLike) else repr(given)
        except ValueError:  # a whole number of thousands of digits
            text = "a number of too many digits"
        return text if len(text) <= CHARACTERS_SHOWN else f"{text[: CHARACTERS_SHOWN - 3]}..."
    name = given.__name__ if isinstance(given, type) else type(given).__name__
    return f"of the type {name}" if not isinstance(given, type) else f"the type {name}"


def _plain(given: Any) -> Any:
    """Return a scalar of NumPy as Python's own, all else as it is."""
    alone = getattr(given, "ndim", None) == 0 and hasattr(given, "item")
    return given.item() if alone and not isinstance(given, type) else given


def optional(kind: Kind) -> Kind:
    """Take None, too: not stated."""
    return lambda name, given: None if given is None else kind(name, given)


def number(
    above: float = -math.inf,
    least: float = -math.inf,
    below: float = math.inf,
    unit: str = "",
) -> Kind:
    """Take a finite number within bounds; no truth, and no text."""
    wanted = ["a number"]
    wanted += [f"above {above:g}"] if above > -math.inf else []
    wanted += [f"of {least:g} or more"] if least > -math.inf else []
    wanted += [f"below {below:g}"] if below < math.inf else []
    told = " and ".join([" ".join(wanted[:2]), *wanted[2:]]) + (f" [{unit}]" if unit else "")
    # Exclusive of infinities, and of numbers whose squares are infinite.
    least, below = max(least, -LARGEST_NUMBER), min(below, LARGEST_NUMBER)

    def take(name: str, given: Any) -> float:
        value = _plain(given)
        if isinstance(value, bool) or not isinstance(value, (Real, Decimal)):
            refuse(name, given, told)
        try:
            found = float(value)
        except (OverflowError, ValueError):
            refuse(name, given, told)
        if abs(found) > LARGEST_NUMBER and math.isfinite(found):
            refuse(name, given, f"{told}, of an amount up to {LARGEST_NUMBER:g}")
        if not (least <= found < below and found > above):
            refuse(name, given, told)
        return found

    return take


def whole(least: int = 0, most: int | None = None) -> Kind:
    """Take a whole number within bounds, from ``least`` on."""
    told = f"a whole number from {least} {'on' if most is None else f'to {most}'}"

    def take(name: str, given: Any) -> int:
        value = _plain(given)
        if isinstance(value, bool) or not isinstance(value, Integral):
            refuse(name, given, told)
        found = int(value)
        if found < least or (most is not None and found > most):
            refuse(name, given, told)
        return found

    return take


def flag(name: str, given: Any) -> bool:
    """Take a truth: a text is none, though Python takes any for True."""
    value = _plain(given)
    if not isinstance(value, bool):
        refuse(name, given, "True or False")
    return value


def text(name: str, given: Any) -> str:
    """Take a text that is not empty."""
    if not isinstance(given, str) or not given:
        refuse(name, given, "a text")
    return str(given)


def choice(*names: str) -> Kind:
    """Take one of some names."""
    told = " or ".join(names) if len(names) < 3 else f"one of {', '.join(names)}"

    def take(name: str, given: Any) -> str:
        if not isinstance(given, str) or given not in names:
            refuse(name, given, told)
        return str(given)

    return take


def path(name: str, given: Any) -> Path:
    """Take the path of a file or folder, whether or not there is one."""
    if not isinstance(given, (str, os.PathLike)) or not isinstance(os.fspath(given), str):
        refuse(name, given, "the path of a file")
    written = os.fspath(given)
    try:
        possible = bool(written) and b"\0" not in os.fsencode(written)
    except UnicodeEncodeError:
        possible = False
    if not possible:
        refuse(name, given, "the path of a file")
    return Path(written)


def function(name: str, given: Any) -> Callable[..., Any]:
    """Take a function."""
    if not callable(given) or isinstance(given, type):
        refuse(name, given, "a function")
    return given  # type: ignore[no-any-return]


def instance(kind: type, wanted: str) -> Kind:
    """Take an object of a class; ``wanted`` says which in words."""

    def take(name: str, given: Any) -> Any:
        if not isinstance(given, kind):
            refuse(name, given, wanted)
        return given

    return take


def several(kind: Kind, wanted: str) -> Kind:
    """Take any number of one kind, in a list or another order; a single one stands for itself."""

    def take(name: str, given: Any) -> tuple[Any, ...]:
        if isinstance(given, (str, os.PathLike)):
            return (kind(name, given),)
        if isinstance(given, (bytes, Mapping, type)) or not isinstance(given, Iterable):
            refuse(name, given, f"a list of {wanted}")
        return tuple(kind(name, each) for each in given)

    return take


def by_name(kind: Kind, wanted: str) -> Kind:
    """Take a mapping from names to values of one kind."""

    def take(name: str, given: Any) -> dict[str, Any]:
        if not isinstance(given, Mapping):
            refuse(name, given, f"{wanted} by name, as a mapping")
        for key in given:
            if not isinstance(key, str):
                refuse(name, key, f"{wanted} by name, and names are texts")
        return {str(key): kind(f"{name} {key}", value) for key, value in given.items()}

    return take
