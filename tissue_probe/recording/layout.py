"""A foreign file's names of its signals, and their units and directions.

Contents: the user's statements.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from itertools import combinations
from numbers import Integral, Real
from typing import Any, Literal, get_args

from tissue_probe import arguments as take
from tissue_probe.errors import ParameterError
from tissue_probe.recording.units import (
    FORCE_UNITS,
    POSITION_UNITS,
    TIME_UNITS,
    VELOCITY_UNITS,
    spell_unit,
    unit_size,
)
from tissue_probe.signals import NANOSECONDS

ForcePolarity = Literal["compression", "tension"]
PositionPolarity = Literal["into", "out"]
Clock = Literal["stamps", "recorder"]


def _column(name: str, given: Any) -> str:
    """Take the name of a column, or its number in a file that names none."""
    if isinstance(given, Integral) and not isinstance(given, bool) and int(given) > 0:
        return str(given)
    if not isinstance(given, str) or not given:
        take.refuse(name, given, "the name of a column, or its number from 1 on")
    return str(given)


def _size(units: Mapping[str, float]) -> take.Kind:
    """Take the name of a unit, or how large one is in SI."""

    def take_size(name: str, given: Any) -> str:
        unit = repr(take.number(above=0.0)(name, given)) if isinstance(given, Real) else given
        try:
            unit_size(take.text(name, unit), units)
        except ParameterError as error:
            raise ParameterError(f"`{name}`: {error}") from None
        return str(unit)

    return take_size


def _unit_of_time(name: str, given: Any) -> str:
    return str(
        take.choice(*TIME_UNITS)(name, spell_unit(given) if isinstance(given, str) else given)
    )


#: The values that each statement may have.
STATEMENT_KINDS: dict[str, take.Kind] = {
    **dict.fromkeys(("position", "force", "time", "input2"), take.optional(_column)),
    "position_unit": take.optional(_size(POSITION_UNITS | VELOCITY_UNITS)),
    "force_unit": take.optional(_size(FORCE_UNITS)),
    "time_unit": take.optional(_unit_of_time),
    "force_polarity": take.optional(take.choice(*get_args(ForcePolarity))),
    "position_polarity": take.choice(*get_args(PositionPolarity)),
    # Stamps of samples are whole nanoseconds.
    "sample_rate": take.optional(take.number(above=0.0, below=NANOSECONDS, unit="Hz")),
    "samples_topic": take.optional(take.text),
    "clock": take.optional(take.choice(*get_args(Clock))),
    "adapter": take.optional(take.text),
}


@dataclass(frozen=True)
class Layout:
    """Where the signals are in a file; None where not stated.

    Parameters
    ----------
    position, force : str, optional
        Name of a column (``group/channel``, ``sheet!column``, ``matrix[:,2]``; its number where a
        file names none), or of a field of a topic (``/ft_sensor.wrench.force.z``).
    time : str, optional
        Name of the column of time; in seconds, unless it ends in a unit (``t_ms``).
    position_unit, force_unit : str, optional
        Name of a unit (``units.POSITION_UNITS``, ``units.VELOCITY_UNITS`` where a velocity stands
        for the position, ``units.FORCE_UNITS``), or a positive number: the size of one in metres
        or newtons.
    time_unit : str, optional
        Name of a unit (``units.TIME_UNITS``).
    force_polarity : {"compression", "tension"}, optional
        Which forces are positive in the file.
    position_polarity : {"into", "out"}
        Whether positions grow into the tissue, or out of it (a height).
    sample_rate : float, optional
        Samples a second [Hz]; then no time is read.
    clock : {"stamps", "recorder"}, optional
        Whose clock counts in a bag, where it is not clear: that of the stamps, or the recorder's.
    samples_topic : str, optional
        Which topic of this suite's samples, where a recording has several.
    input2 : str, optional
        Name of a column, or field of a topic, of a further channel that may drive the force, such
        as a pressure; in its own unit.
    adapter : str, optional
        Parameter file of the node ``adapter``: a bag is read as that node hears the robot, and
        nothing else is to be stated.

    Raises
    ------
    ParameterError
        If a statement is of another kind, a rate is stated together with a column of time, or
        anything beside ``adapter``.
    """

    position: str | None = None
    force: str | None = None
    time: str | None = None
    position_unit: str | None = None
    force_unit: str | None = None
    time_unit: str | None = None
    force_polarity: ForcePolarity | None = None
    position_polarity: PositionPolarity = "into"
    sample_rate: float | None = None
    samples_topic: str | None = None
    clock: Clock | None = None
    input2: str | None = None
    adapter: str | None = None

    def __post_init__(self) -> None:
        for name, kind in STATEMENT_KINDS.items():
            object.__setattr__(self, name, kind(name, getattr(self, name)))
        if self.sample_rate is not None and (self.time or self.time_unit):
            raise ParameterError("`time` and `sample_rate` exclude each other; give one of them")
        if self.adapter and len(self.stated) > 1:
            others = ", ".join(f"`{name}`" for name, _ in self.stated if name != "adapter")
            raise ParameterError(f"`adapter` says all of a bag: leave out {others}")

    def check_signals(self) -> None:
        """Refuse one column or field for two signals.

        Raises
        ------
        ParameterError
            If two of ``position``, ``force``, ``time`` and ``input2`` have the same name.
        """
        names = "position", "force", "time", "input2"
        stated = {name: getattr(self, name) for name in names}
        for one, other in combinations([name for name, given in stated.items() if given], 2):
            if stated[one] == stated[other]:
                raise ParameterError(
                    f"`{one}` and `{other}` are both {stated[one]}: give one of each"
                )

    @property
    def stated(self) -> tuple[tuple[str, Any], ...]:
        """The given statements, by name, but for those equal to the default."""
        given = ((each.name, getattr(self, each.name), each.default) for each in fields(self))
        return tuple((name, value) for name, value, default in given if value != default)

    @property
    def force_sign(self) -> float:
        """The factor that makes a force of the file positive in compression."""
        return -1.0 if self.force_polarity == "tension" else 1.0

    @property
    def position_sign(self) -> float:
        """The factor that makes a position of the file grow into the tissue."""
        return -1.0 if self.position_polarity == "out" else 1.0
