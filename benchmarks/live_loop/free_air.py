"""How right a force sensor is identified in free air, on an arm in MuJoCo.

Contents: the rows of the table, their seeds and goals, the marks.

Each seed draws its own tool, bias, drift and motions. 60 s of turning are identified; marked is the
wrench that is foreseen in other motions of the same kind, against MuJoCo's own without noise: its
error as the root mean square of its length, over force and over torque. Seeds from ``FIRST`` on
were not looked at while the fit was made.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass

import numpy as np
from rich.table import Table

from benchmarks.live_loop.arm import DELAY, RATE, Array, Cable, Measured, World
from tissue_probe.sensor.compensation import compensation
from tissue_probe.sensor.identify import Identified, identify
from tissue_probe.sensor.live import LiveCompensation
from tissue_probe.sensor.sensor_tracks import Track, stretches
from tissue_probe.signals import NANOSECONDS

FIRST = 1000
IDENTIFIED = 60.0  # s
SOON, LATE, ZERO, LIVE = 30.0, 600.0, 2.0, 10.0  # s
EPOCH = 1_700_000_000 * NANOSECONDS
WITHIN = 1.96  # standard deviations: 95 %


@dataclass(frozen=True)
class Row:
    """One row of the table: a world, whether the joints are told, and goals [N]."""

    name: str
    make: Callable[[int], World]
    joints: bool
    soon: str
    late: str


ROWS = (
    Row("no cable", World, False, "<= .03", "<= .05"),
    Row("cable 3 N/m", lambda seed: World(seed, Cable(3.0)), True, "<= .06", "<= .1"),
    Row("cable 10 N/m", lambda seed: World(seed, Cable(10.0)), True, "<= .2", "<= .3"),
    Row(
        "10 N/m, sags 5 cm", lambda seed: World(seed, Cable(10.0, sag=0.05)), True, "<= .2", "<= .3"
    ),
    Row("3 N/m, pose alone", lambda seed: World(seed, Cable(3.0)), False, "<= .06", "<= .1"),
    Row("10 N/m, pose alone", lambda seed: World(seed, Cable(10.0)), False, "<= .2", "<= .3"),
    Row("drift settles, 300 s", lambda seed: World(seed, fade=300.0), False, "", ""),
)


@dataclass(frozen=True)
class Mark:
    """What one seed of a row got.

    ``soon``, ``late`` and ``live`` are errors of force [N] and torque [N m]; ``inside`` which share
    of the wrench lies within its 95 % intervals, soon and late; ``held_soon`` and ``held_late``
    whether the six axes did in the middle of each; ``numbers`` whether mass, centre, inertia and
    delay lie within theirs.
    """

    row: str
    seed: int
    verdict: str
    soon: tuple[float, float]
    late: tuple[float, float]
    live: tuple[float, float]
    inside: tuple[float, float]
    held_soon: tuple[bool, ...]
    held_late: tuple[bool, ...]
    numbers: dict[str, bool]


def measure(count: int, first: int = FIRST, names: Iterable[str] | None = None) -> list[Mark]:
    """Return the marks of so many seeds of each row."""
    wanted = [row for row in ROWS if names is None or row.name in names]
    return [_mark(row, seed) for row in wanted for seed in range(first, first + count)]


def _mark(row: Row, seed: int) -> Mark:
    world = row.make(seed)
    runs = runs_of(world.move(0.0, IDENTIFIED), row.joints)
    found = identify(runs)
    soon = world.move(IDENTIFIED, SOON)
    zero = runs_of(world.move(LATE, ZERO), row.joints)[0]
    late = world.move(LATE + ZERO, SOON)
    error_soon, inside_soon, held_soon = _off(found, soon, row.joints)
    error_late, inside_late, held_late = _off(found.with_zero(zero), late, row.joints)
    return Mark(
        row=row.name,
        seed=seed,
        verdict=found.verdict,
        soon=error_soon,
        late=error_late,
        live=_live(found, runs, _cut(soon, LIVE), row.joints),
        inside=(inside_soon, inside_late),
        held_soon=held_soon,
        held_late=held_late,
        numbers=_held(found, world),
    )


def _cut(measured: Measured, seconds: float) -> Measured:
    """Return the first seconds."""
    count = round(seconds * RATE)
    return Measured(**{name: rows[:count] for name, rows in vars(measured).items()})


def _tracks(measured: Measured, joints: bool) -> tuple[Track, Track, Track | None]:
    stamps = EPOCH + np.round(measured.time * NANOSECONDS).astype(np.int64)
    poses = Track(stamps, np.hstack([measured.position, measured.orientation]))
    angles = Track(stamps, measured.joints) if joints else None
    return poses, Track(stamps, measured.wrench), angles


def runs_of(measured: Measured, joints: bool):
    """Return a stretch as the identification takes it."""
    return stretches(*_tracks(measured, joints), EPOCH)


def _off(
    found: Identified, measured: Measured, joints: bool
) -> tuple[tuple[float, float], float, tuple[bool, ...]]:
    """Return errors of the wrench foreseen, the share within, and whether the middle is."""
    time, made, deviation = found.wrench(runs_of(measured, joints)[0])
    true = np.stack([np.interp(time, measured.time, each) for each in measured.true.T], axis=1)
    off = made - true
    inside = np.abs(off) < WITHIN * deviation
    return _sizes(off), float(inside.mean()), tuple(inside[len(inside) // 2].tolist())


def _live(found: Identified, runs, measured: Measured, joints: bool) -> tuple[float, float]:
    """Return errors of the wrench that is left at once, its own noise taken away."""
    model = compensation(found, runs, EPOCH)
    live = LiveCompensation(model, late=0.0)
    poses, wrenches, angles = _tracks(measured, joints)
    cabled = model.cable is not None and joints
    rows = np.hstack([poses.rows, angles.rows]) if cabled and angles else poses.rows
    delayed = round(DELAY * RATE)
    off = []
    for number, stamp in enumerate(poses.stamps.tolist()):
        live.take_pose(stamp, rows[number])
        live.take_wrench(stamp, wrenches.rows[number])
        if number % 50 == 49:
            for left in live.take_known():
                place = round((left.stamp - int(poses.stamps[0])) / NANOSECONDS * RATE)
                noise = measured.wrench[place] - measured.true[place - delayed]
                off.append(left.wrench - noise)
    return _sizes(np.array(off[round(RATE) :]))


def _sizes(off: Array) -> tuple[float, float]:
    force, torque = np.sum(off[:, :3] ** 2, axis=1), np.sum(off[:, 3:] ** 2, axis=1)
    return float(np.sqrt(force.mean())), float(np.sqrt(torque.mean()))


def _held(found: Identified, world: World) -> dict[str, bool]:
    """Return whether mass, centre and inertia lie within their intervals."""
    tool = world.tool
    c = tool.centre
    about = tool.inertia + tool.mass * (c @ c * np.eye(3) - np.outer(c, c))
    truth = {"mass": tool.mass}
    truth |= {f"centre_{letter}": value for letter, value in zip("xyz", c, strict=True)}
    for name, pair in {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1)}.items():
        truth[f"inertia_{name}"] = about[pair]
    truth |= {"inertia_xz": about[0, 2], "inertia_yz": about[1, 2], "delay": DELAY}
    numbers = {each.name: each for each in found.numbers}
    return {
        name: bool(abs(numbers[name].value - value) < WITHIN * numbers[name].deviation)
        for name, value in truth.items()
    }


def kept(marks: list[Mark]) -> list[dict[str, object]]:
    """Return the marks as plain data."""
    return [asdict(mark) for mark in marks]


def table(marks: list[Mark]) -> Table:
    """Return a table of the rows: median and worst, beside the goals."""
    shown = Table(title="Free air: errors of the wrench beyond noise, median / worst")
    for column in (
        *(
            "row",
            "seeds",
            "30 s [N]",
            "goal",
            r"\[mN m]",
            "10 min, re-zero [N]",
            "goal",
            r"\[mN m]",
        ),
        *("live [N]", "wrench held", "numbers held", "verdicts"),
    ):
        shown.add_column(column)
    for row in ROWS:
        some = [mark for mark in marks if mark.row == row.name]
        if some:
            shown.add_row(row.name, str(len(some)), *_cells(row, some))
    return shown


def _cells(row: Row, marks: list[Mark]) -> Iterable[str]:
    def of(values: Iterable[float], scale: float = 1.0) -> str:
        array = scale * np.array(list(values))
        return f"{np.median(array):.3f} / {array.max():.3f}"

    yield of(mark.soon[0] for mark in marks)
    yield row.soon
    yield of((mark.soon[1] for mark in marks), 1e3)
    yield of(mark.late[0] for mark in marks)
    yield row.late
    yield of((mark.late[1] for mark in marks), 1e3)
    yield of(mark.live[0] for mark in marks)
    soon, late = (np.sum(held, axis=0).min() for held in _middles(marks))
    yield f"{soon}, {late} (least of the axes)"
    counts = {name: sum(mark.numbers[name] for mark in marks) for name in marks[0].numbers}
    least = min(counts, key=lambda name: counts[name])
    yield f"{counts[least]} ({least}), mean {np.mean(list(counts.values())):.1f}"
    verdicts = [mark.verdict for mark in marks]
    yield ", ".join(f"{verdicts.count(each)} {each}" for each in sorted(set(verdicts)))


def _middles(marks: list[Mark]) -> tuple[Array, Array]:
    return np.array([mark.held_soon for mark in marks]), np.array([m.held_late for m in marks])
