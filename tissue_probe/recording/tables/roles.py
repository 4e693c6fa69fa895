"""Which column of a file is the time, which the position, which the force.

Contents: finding it by names and units, and refusing where these do not tell it.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from itertools import combinations

from tissue_probe.recording.columns.source import Columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Layout
from tissue_probe.recording.tables.usual_names import OWN_NAMES, ROTARY, SWEEP, USUAL_NAMES
from tissue_probe.recording.units import (
    FORCE_UNITS,
    POSITION_UNITS,
    TIME_UNITS,
    VELOCITY_UNITS,
    spell_unit,
    split_unit,
    unit_size,
)
from tissue_probe.signals import SCALED, UnitFrom

_ROLE_UNITS = {
    "time": TIME_UNITS,
    "position": POSITION_UNITS | VELOCITY_UNITS,
    "force": FORCE_UNITS,
}
_IN_CONTAINER = re.compile(r".*[/!.](?=[^/!.]+$)")
_LAST_UNIT = re.compile(r"[\[(]\s*([^\[\]()]+?)\s*[\])]$|_([^_\s]+)$|[,/]\s*([^,/]+)$")
_AXIS = re.compile(r"\s*[\[(][^\[\]()]*[\])]$")


@dataclass(frozen=True)
class Roles:
    """The columns of the signals, and their factors to SI.

    Attributes
    ----------
    names : dict of str to str
        Column of ``time`` (missing where the rate stands for it), ``position`` and ``force``.
    units : dict of str to str
        Their units, as far as told.
    sample_rates : dict of str to float
        Samples a second of ``position`` and ``force``, where no time is read [Hz].
    timed : bool
        Whether the file tells times, in one column or in one for each channel.
    own_times : bool
        Whether position and force tell each their own times, or when they begin.
    told : tuple of str
        The choices of columns that nobody named, in phrases.
    units_from : dict of str to str
        What tells the units of ``position`` and ``force``; see ``signals.UnitFrom``.
    """

    names: dict[str, str]
    units: dict[str, str]
    sample_rates: dict[str, float]
    timed: bool
    own_times: bool
    told: tuple[str, ...]
    units_from: dict[str, UnitFrom]

    @property
    def velocity(self) -> bool:
        """Whether a velocity stands for the position."""
        return self.units.get("position") in VELOCITY_UNITS

    def size(self, role: str) -> float:
        """Return how large one of a role's column is in SI."""
        return unit_size(self.units[role], _ROLE_UNITS[role])


def roles(source: Columns, layout: Layout) -> Roles:
    """Find the columns of the signals.

    A column that is not named is the one that is called as this suite calls it, or else as testing
    machines do; bare or with a unit.

    Raises
    ------
    RecordingError
        If a column is not told or two could be meant, or a unit or the polarity is not known.
    """
    wanted = {"time": layout.time, "position": layout.position, "force": layout.force}
    if layout.sample_rate is not None:
        del wanted["time"]
    names = {
        role: _find_named(source, role, name) if name else _find_usual(source, role)
        for role, name in wanted.items()
        if role != "time" or not source.clocks
    }
    own_clocks = bool(source.clocks) and layout.sample_rate is None
    own_clocks = own_clocks and all(
        layout.time in (None, _AXIS.sub("", source.clocks.get(name or "", "")))
        and name in source.clocks
        for name in names.values()
    )
    if "time" in wanted and source.clocks and not own_clocks:
        time = (
            _find_named(source, "time", layout.time) if layout.time else _find_usual(source, "time")
        )
        names = {"time": time, **names}
    rates = _sample_rates(source, layout, names)
    if rates and names.get("time", "") is None:
        del names["time"]
    _refuse_one_for_two(source, names, wanted)
    if missing := [role for role, name in names.items() if name is None]:
        raise RecordingError(_what_is_not_told(source, missing))
    found = {role: name for role, name in names.items() if name is not None}
    told = [
        f"{role} is {found[role]}"
        for role in found
        if (wanted.get(role) is None and _stem(found[role], role) not in OWN_NAMES[role])
        or (wanted.get(role) or "").isdecimal()
    ]
    if own_clocks:
        told.append("position and force have each a column of times")
    elif "time" not in found and layout.sample_rate is None:
        told.append(f"{rates['force']:.6g} samples a second, as the file says")
    units = _units(source, layout, found)
    told += _list_contradictions(source, layout, found)
    begin = any(found[role] in source.starts for role in ("position", "force"))
    _refuse_other_starts(source, found)
    own_times = own_clocks or ("time" not in found and (begin or len(set(rates.values())) > 1))
    timed = own_clocks or "time" in found
    units_from = {role: _unit_from(source, layout, role, found[role]) for role in SCALED}
    return Roles(found, units, rates, timed, own_times, tuple(told), units_from)


def _refuse_other_starts(source: Columns, found: dict[str, str]) -> None:
    """Refuse channels whose starts are not both told, or differ from a column of times for both."""
    starts = [source.starts.get(found[role], 0.0) for role in ("position", "force")]
    if any(math.isnan(start) for start in starts):
        raise RecordingError(
            f"{source.path} tells when one of {found['position']} and {found['force']} begins, and "
            "not when the other does; write both starts to the file, or give a column `time`"
        )
    if "time" in found and not source.clocks and starts[0] != starts[1]:
        raise RecordingError(
            f"{source.path} says that {found['force']} begins {1e3 * (starts[1] - starts[0]):.4g} "
            f"ms after {found['position']}, and the column {found['time']} tells one time for "
            "both; take one of the two out of the file"
        )


def _sample_rates(
    source: Columns, layout: Layout, names: dict[str, str | None]
) -> dict[str, float]:
    """Return the rates of position and force where they are stated, or the file tells both."""
    signals = {role: names[role] for role in ("position", "force")}
    if layout.sample_rate is not None:
        return dict.fromkeys(signals, layout.sample_rate)
    periods = {
        role: source.periods[name]
        for role, name in signals.items()
        if name is not None and name in source.periods
    }
    return {role: 1.0 / period for role, period in periods.items()} if len(periods) == 2 else {}


def _refuse_one_for_two(
    source: Columns, names: dict[str, str | None], stated: dict[str, str | None]
) -> None:
    """Refuse a column that is stated for one signal, and would be found for another, too."""
    for one, other in combinations([role for role, name in names.items() if name], 2):
        if names[one] == names[other] and not (stated[one] and stated[other]):
            raise RecordingError(
                f"{source.path}: column {names[one]} cannot be both the {one} and the {other}: "
                f"give another `{one}` or `{other}`; {source.has()}"
            )


def _what_is_not_told(source: Columns, missing: list[str]) -> str:
    options = " ".join(f"`{role}`" for role in missing)
    rate = " (or `sample_rate` where there is none)" if "time" in missing else ""
    if swept := [name for name in source.names if _plain(name, "time") in SWEEP]:
        return (
            f"{source.path} is a frequency sweep, with {', '.join(swept)}: it holds no samples "
            "over time, which this needs; export those, or record again"
        )
    if not source.named:
        return (
            f"{source.path} has no header line that names its columns: state which column is the "
            f"{' and which the '.join(missing)} by their numbers, 1 to {len(source.names)}: give "
            f"{options}{rate}"
        )
    return (
        f"{source.path} does not say which column is the {' and which the '.join(missing)}: give "
        f"{options}{rate}; {source.has()}"
    )


def _stem(name: str, role: str) -> str:
    """Return a column's name without its unit and its place in a container."""
    stem, _ = split_unit(name, _ROLE_UNITS[role])
    return _IN_CONTAINER.sub("", stem.strip())


def _plain(name: str, role: str) -> str:
    """Return the words of a name in lower case, without unit and axis."""
    stem = _AXIS.sub("", _stem(name, role))
    return " ".join(stem.replace("_", " ").replace(".", " ").casefold().split())


def _find_named(source: Columns, role: str, name: str) -> str:
    """Return the column that the user means: by its name, or by that without its unit."""
    if source.names.count(name) > 1:
        raise RecordingError(
            f"{source.path} has {source.names.count(name)} columns called {name}: which is the "
            f"{role}? Give each another name, or write the file with one such column"
        )
    if name not in source.names:
        meant = [each for each in source.names if name in (_stem(each, role), each.strip())]
        if len(meant) == 1:
            return meant[0]
        if len(meant) > 1:
            raise RecordingError(
                f"{source.path} has several columns {name}: {', '.join(meant)}; give `{role}` in "
                "full"
            )
        if name.isdecimal() and name.isascii() and (numbered := _find_numbered(source, int(name))):
            return numbered
        source.require([name])
    return name


def _find_numbered(source: Columns, number: int) -> str | None:
    """Return the name of a file's column by its number from 1; None where that has none."""
    names = source.numbered or source.names
    return (names[number - 1] or None) if 1 <= number <= len(names) else None


def _find_usual(source: Columns, role: str) -> str | None:
    """Return the column that a role's usual names tell."""
    own = OWN_NAMES[role]
    for found in (
        [name for name in own if name in source.names],
        [name for name in source.names if _stem(name, role) in own],
        [name for name in source.names if _plain(name, role) in USUAL_NAMES[role]],
    ):
        if len(found) > 1 and found != [name for name in own if name in source.names]:
            raise RecordingError(
                f"{source.path} has several columns that may be the {role}: {', '.join(found)}; "
                f"give `{role}`"
            )
        if found:
            return found[0]
    return None


def _units(source: Columns, layout: Layout, names: dict[str, str]) -> dict[str, str]:
    stated, units, missing = _list_stated(layout), {}, []
    for role, name in names.items():
        if not stated[role]:
            _refuse_unknown_unit(source, role, name)
        unit = stated[role] or _unit(source, role, name)
        if unit is not None:
            units[role] = spell_unit(unit)
            unit_size(unit, _ROLE_UNITS[role])
        elif role != "time":
            known = POSITION_UNITS if role == "position" else FORCE_UNITS
            missing.append(f"`{role}_unit` ({', '.join(known)} or a number)")
    if layout.force_polarity is None and names["force"] not in OWN_NAMES["force"]:
        missing.append("`force_polarity` (compression or tension: which forces are positive)")
    if missing:
        raise RecordingError(
            f"{source.path}: the names {names['position']} and {names['force']} do not tell "
            f"everything; state {', '.join(missing)}"
        )
    return units


def _refuse_unknown_unit(source: Columns, role: str, name: str) -> None:
    """Refuse a unit that the file tells beside a column, and that is none of its role's."""
    told = source.units.get(name, "") or _rotary(name)
    named = split_unit(name, _ROLE_UNITS[role])[1]
    if (
        named
        and spell_unit(told) in _ROLE_UNITS[role]
        and _ROLE_UNITS[role][named] != _ROLE_UNITS[role][spell_unit(told)]
    ):
        raise RecordingError(
            f"{source.path}: column {name}, the {role}, is in {named} by its name, and in {told} "
            f"by the unit beside it; state `{role}_unit`"
        )
    if told in ROTARY:
        raise RecordingError(
            f"{source.path}: column {name}, the {role}, is in {told}, of a torque or an angle, and "
            f"forces and ways are read here; state `{role}_unit` as a number: by the lever's "
            "length, how many newtons or metres one is"
        )
    if (
        told and spell_unit(told) not in _ROLE_UNITS[role] and ":" not in told
    ):  # hh:mm:ss is no unit
        raise RecordingError(
            f"{source.path}: column {name}, the {role}, is in '{told}' as the file says, and that "
            f"is no unit of it known here; state `{role}_unit` ({', '.join(_ROLE_UNITS[role])}"
            f"{'' if role == 'time' else ' or a number: the size of one in SI'})"
        )


def _rotary(name: str) -> str:
    """Return the unit of a torque or an angle in which a name ends; nothing where there is none."""
    found = _LAST_UNIT.search(name)
    unit = next((group for group in found.groups() if group), "") if found else ""
    return unit if unit in ROTARY else ""


def _list_stated(layout: Layout) -> dict[str, str | None]:
    """Return the unit that the user states of each role."""
    return {
        "time": layout.time_unit,
        "position": layout.position_unit,
        "force": layout.force_unit,
    }


def _unit_from(source: Columns, layout: Layout, role: str, name: str) -> UnitFrom:
    stated, told = _list_stated(layout)[role], _told_unit(source, role, name)
    if not told:
        return UnitFrom.STATEMENT if stated else UnitFrom.NAME
    same = not stated or unit_size(told, _ROLE_UNITS[role]) == unit_size(stated, _ROLE_UNITS[role])
    return UnitFrom.FILE if same else UnitFrom.OVERRULED


def _list_contradictions(source: Columns, layout: Layout, names: dict[str, str]) -> list[str]:
    """Say in phrases which units are stated where the file tells others."""
    return [
        f"{role} is taken in {unit}, as `{role}_unit` states, and not in {told} as the file says"
        for role, unit in _list_stated(layout).items()
        if unit and role in names and (told := _told_unit(source, role, names[role]))
        if unit_size(told, _ROLE_UNITS[role]) != unit_size(unit, _ROLE_UNITS[role])
    ]


def _told_unit(source: Columns, role: str, name: str) -> str | None:
    """Return the unit that a file tells of a column; None where it tells none."""
    if (unit := spell_unit(source.units.get(name, ""))) in _ROLE_UNITS[role]:
        return unit
    return split_unit(name, _ROLE_UNITS[role])[1]


def _unit(source: Columns, role: str, name: str) -> str | None:
    """Return the unit of a column: that which the file tells, or that of this suite's own names."""
    unit = _told_unit(source, role, name)
    if unit or role == "time":
        return unit
    return next(iter(_ROLE_UNITS[role])) if name in OWN_NAMES[role] else None
