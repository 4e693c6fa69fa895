"""What a foreign file calls its signals, and in which units and directions they are.

What belongs here: the user's statements. What does not: reading files by them (``any_file``).
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import combinations
from typing import Any, Literal, get_args

from tissue_probe.errors import ParameterError

ForcePolarity = Literal["compression", "tension"]
PositionPolarity = Literal["into", "out"]
Clock = Literal["stamps", "recorder"]
#: What may be stated where there are few choices, by name.
CHOICES: dict[str, tuple[str, ...]] = {
    "force_polarity": get_args(ForcePolarity),
    "position_polarity": get_args(PositionPolarity),
    "clock": get_args(Clock),
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

    Raises
    ------
    ValueError
        If the rate is not positive, or stated together with a column of time.
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

    def __post_init__(self) -> None:
        for name, known in CHOICES.items():
            if (given := getattr(self, name)) is not None and given not in known:
                raise ParameterError(f"`{name}` is {given!r}; give {' or '.join(known)}")
        if self.sample_rate is not None and not 0.0 < self.sample_rate < float("inf"):
            raise ParameterError(f"`sample_rate` is {self.sample_rate} Hz; it must be positive")
        if self.sample_rate is not None and (self.time or self.time_unit):
            raise ParameterError("`time` and `sample_rate` exclude each other; give one of them")

    def check_signals(self) -> None:
        """Refuse one column or field for two signals.

        Raises
        ------
        ParameterError
            If two of ``position``, ``force`` and ``time`` have the same name.
        """
        stated = {"position": self.position, "force": self.force, "time": self.time}
        for one, other in combinations([name for name, given in stated.items() if given], 2):
            if stated[one] == stated[other]:
                raise ParameterError(
                    f"`{one}` and `{other}` are both {stated[one]}: give one of each"
                )

    @property
    def stated(self) -> tuple[tuple[str, Any], ...]:
        """What was said, by name, but for what would be taken anyway."""
        given = ((each.name, getattr(self, each.name), each.default) for each in fields(self))
        return tuple((name, value) for name, value, default in given if value != default)

    @property
    def force_sign(self) -> float:
        """What makes a force of the file positive in compression."""
        return -1.0 if self.force_polarity == "tension" else 1.0

    @property
    def position_sign(self) -> float:
        """What makes a position of the file grow into the tissue."""
        return -1.0 if self.position_polarity == "out" else 1.0
