"""Poses that would tell the rest: turns and swings, by the information that they add."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tissue_probe.sensor.free_air import FreeAir
from tissue_probe.sensor.kinematics import turn_orientation
from tissue_probe.sensor.numbers import CORE, PRIOR_DEVIATIONS, Point
from tissue_probe.sensor.smoothed_air import Smoothed
from tissue_probe.sensor.told_numbers import SensorNumber, numbers
from tissue_probe.signals import FloatArray

#: A pose is held, or a swing lasts, for so long [s].
LASTS = 4.0
#: A swing: either way [rad], times a second [Hz]: 2 rad/s and 10 rad/s2 at most, within any wrist.
SWING, SWING_FREQUENCY = 0.35, 0.9
#: More at once nobody would do: one looks again after these.
MOST_MOVES = 3
#: A pose is worth naming where an error falls below this part of it: where the pose tells as much
#: as all the others together.
WORTH = 1.0 / np.sqrt(2.0)


def missing_poses(
    point: Point, covariance: FloatArray, noise: FloatArray, orientation: FloatArray
) -> list[str]:
    """Return in words the moves after which all numbers are told; the most telling first.

    Parameters
    ----------
    point, covariance, noise
        As in ``told_numbers.numbers``.
    orientation : array, shape (4,)
        The last one, from which turns begin.
    """
    core = Point(point.values[:CORE], point.time)
    believed = covariance[:CORE, :CORE] + 1e-12 * np.diag(PRIOR_DEVIATIONS**2)
    sentences: list[str] = []
    moves = [(words, _information(run, core, noise)) for words, run in _moves(orientation, core)]
    while len(sentences) < MOST_MOVES and any(not n.told for n in numbers(core, believed, noise)):
        before = numbers(core, believed, noise)
        information = np.linalg.inv(believed)
        tried = [np.asarray(np.linalg.inv(information + added), float) for _, added in moves]
        costs = [_cost(numbers(core, after, noise)) for after in tried]
        best = int(np.argmin(costs))
        helped = _helped(before, numbers(core, tried[best], noise))
        if not helped:
            break
        sentences.append(f"{moves[best][0]} (tells {', '.join(helped)})")
        believed = tried[best]
    return sentences


def _cost(told: list[SensorNumber]) -> float:
    return float(sum(np.log(max(number.error_of_wrench, 1.0)) for number in told))


def _helped(before: list[SensorNumber], after: list[SensorNumber]) -> list[str]:
    pairs = zip(before, after, strict=True)
    return [a.name for b, a in pairs if not b.told and a.deviation < WORTH * b.deviation]


def _moves(orientation: FloatArray, point: Point) -> Iterator[tuple[str, FreeAir]]:
    """Yield turns that are held, and swings about the same axes, in words and as poses."""
    for axis, letter in enumerate("xyz"):
        for angle, words in ((0.5 * np.pi, "a quarter"), (np.pi, "half a turn")):
            turned = _turned(orientation, axis, np.array([angle]))
            said = f"turn the flange by {words} about its {letter} axis, and hold it {LASTS:g} s"
            yield said, _run(np.repeat(turned, 1000, axis=0), point)
        time = np.arange(1000) * LASTS / 1000
        swing = SWING * np.sin(2.0 * np.pi * SWING_FREQUENCY * time)
        said = (
            f"swing the flange about its {letter} axis by {np.degrees(SWING):.0f} degrees either "
            f"way, {SWING_FREQUENCY:g} times a second, for {LASTS:g} s"
        )
        yield said, _run(_turned(orientation, axis, swing), point)


def _run(orientation: FloatArray, point: Point) -> FreeAir:
    count = len(orientation)
    zeros = np.zeros((count, 6))
    nowhere = np.zeros((count, 3))
    return FreeAir(point.time, LASTS / count, nowhere, orientation, zeros, np.empty((count, 0)))


def _turned(orientation: FloatArray, axis: int, angles: FloatArray) -> FloatArray:
    """Return an orientation turned about one of its own axes, shape (n, 4)."""
    return turn_orientation(orientation, angles[:, None] * np.eye(3)[axis])


def _information(run: FreeAir, point: Point, noise: FloatArray) -> FloatArray:
    smoothed = Smoothed(run)
    _, slopes = point.wrench(smoothed)
    # As many samples as the filter lets count.
    weight = LASTS / (run.period * len(smoothed.time)) / noise**2
    found: FloatArray = np.einsum("naj,a,nak->jk", slopes, weight, slopes)
    return found
