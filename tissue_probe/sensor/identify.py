"""A force sensor in free air: the fit, its verdict, and the wrench that is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tissue_probe.errors import MeasurementError
from tissue_probe.sensor.cable import MOST_JOINTS, CableFunctions
from tissue_probe.sensor.fit import SensorFit, fit
from tissue_probe.sensor.free_air import FreeAir
from tissue_probe.sensor.kinematics import motion
from tissue_probe.sensor.numbers import DELAY_PLACE, Point
from tissue_probe.sensor.poses import missing_poses
from tissue_probe.sensor.smoothed_air import Smoothed
from tissue_probe.sensor.smoothing import Smoother
from tissue_probe.sensor.told_numbers import SensorNumber, numbers
from tissue_probe.sensor.verdict import LEAST_CONCERN, missing_effects
from tissue_probe.signals import FloatArray

Verdict = Literal["adequate", "missing", "cannot tell"]

LEAST_TIME = 8.0
"""Shortest free air of use [s]: two poses, and the way between them."""
ASKED_FOR = 10.0
"""A cable is taken where data are more probable with it by this (of the logarithm): e^10 to 1."""

ALWAYS_ONE = (
    "the common gain of the forces and the mass are one function: a sensor that reads 1 % too much "
    "says 1 % more mass. A known weight tells them apart",
    "the common gain of the torques and centre and inertia are one function, likewise",
)
ONE_WITH_CABLE = (
    "the weight of the cable, the part of its force that turns with gravity, and the mass are one "
    "function of the pose, and so are the biases and the cable's mean force: the wrench that is "
    "left is as stated, mass and centre are not. Take the cable off to tell them",
)


@dataclass(frozen=True)
class Identified:
    """The numbers of a sensor, with their errors.

    Attributes
    ----------
    verdict : str
        ``adequate``: the wrench is explained to the noise, and every number is told. ``missing``:
        something else is in the wrench. ``cannot tell``: poses tell too little.
    numbers : list of Number
        Mass, centre, inertia, gains, delay, biases, drifts.
    noise : array, shape (6,)
        Standard deviation of a sample's noise [N], [N m].
    missing_effects, missing_poses, one_function : list of str
        Further effects in the wrench; moves that would tell the rest; numbers that nothing in
        free air tells apart.
    cable : CableFunctions or None
        Where the data ask for a cable.
    fit : Fit
        Numbers and covariance.
    range : array, shape (3,)
        Up to which acceleration [m/s2], angular velocity [rad/s] and acceleration [rad/s2] it was
        found, as the filter lets pass.
    """

    verdict: Verdict
    numbers: list[SensorNumber]
    noise: FloatArray
    missing_effects: list[str]
    missing_poses: list[str]
    one_function: list[str]
    cable: CableFunctions | None
    fit: SensorFit
    range: FloatArray

    def number(self, name: str) -> SensorNumber:
        """Return a number by its name."""
        return next(each for each in self.numbers if each.name == name)

    def wrench(self, run: FreeAir) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return times, the wrench at them without contact, and its standard deviation, (n, 6).

        It is that of the poses' own times: the delay is taken out.
        """
        smoothed = Smoothed(run, self.cable)
        belief = self.fit.belief
        values = belief.point.values.copy()
        values[DELAY_PLACE] = 0.0
        made, _ = Point(values, belief.point.time).wrench(smoothed)
        return smoothed.time, made, belief.deviation(smoothed)

    def with_zero(self, run: FreeAir) -> Identified:
        """Return the same after a zero taken anew, in some seconds of free air."""
        belief = self.fit.belief.with_zero(Smoothed(run, self.cable))
        cabled = self.cable is not None
        told = numbers(belief.point, belief.covariance, self.noise, cabled)
        return replace(self, fit=replace(self.fit, belief=belief), numbers=told)


def identify(runs: Sequence[FreeAir]) -> Identified:
    """Identify a sensor from stretches of free air.

    Parameters
    ----------
    runs : sequence of FreeAir
        In the order of time.

    Raises
    ------
    MeasurementError
        If there is too little of it.
    """
    total = sum(run.seconds for run in runs)
    if total < LEAST_TIME:
        raise MeasurementError(
            f"there are {total:.3g} s of free air: record 30 to 60 s in which the flange turns"
        )
    if (count := runs[0].joints.shape[1]) > MOST_JOINTS:
        raise MeasurementError(
            f"{count} joints are told: a minute of poses tells of a cable along {MOST_JOINTS} at "
            "most; name those of the wrist"
        )
    smoothed = [Smoothed(run) for run in runs]
    found, cable = fit(smoothed), None
    effects = missing_effects(found, runs, smoothed, cabled=False)
    if effects:
        functions = CableFunctions.about(list(runs))
        cabled = [Smoothed(run, functions) for run in runs]
        other = fit(cabled, functions)
        # As any cause it has to explain most: of a touch, or a bias that wanders, it cannot.
        left = other.belief.unexplained.sum() / found.belief.unexplained.sum()
        if left < 1.0 - LEAST_CONCERN and other.evidence > found.evidence + ASKED_FOR:
            found, cable, smoothed = other, functions, cabled
            effects = missing_effects(found, runs, smoothed, cabled=True)
    noise = np.sqrt(np.mean([run.noise**2 for run in smoothed], axis=0))
    belief = found.belief
    told = numbers(belief.point, belief.covariance, noise, cable is not None)
    poses = []
    if cable is None:
        poses = missing_poses(belief.point, belief.covariance, noise, runs[-1].orientation[-1])
    untold = any(not (number.told or number.one_function) for number in told)
    verdict: Verdict = "missing" if effects else "cannot tell" if untold else "adequate"
    one = [*ALWAYS_ONE, *(ONE_WITH_CABLE if cable else ())]
    return Identified(verdict, told, noise, effects, poses, one, cable, found, _range(runs))


def _range(runs: Sequence[FreeAir]) -> FloatArray:
    greatest = np.zeros(3)
    for run in runs:
        moved = motion(run.position, run.orientation, run.period)
        smooth = Smoother(run.period)
        away = np.diff(run.position, 2, axis=0) / run.period**2
        sizes = [
            np.linalg.norm(smooth(each), axis=1).max() for each in (away, moved.rate, moved.turning)
        ]
        greatest = np.maximum(greatest, sizes)
    return greatest
