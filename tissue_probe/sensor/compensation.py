"""The model as a node uses it: the wrench without contact at one pose, and its file.

Contents: the numbers of the file; load and cable at a moment; the drift, which is forgotten.
"""

from __future__ import annotations

import math
import os
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from tissue_probe import bounded_yaml
from tissue_probe.bounded_yaml import YamlError
from tissue_probe.errors import FileError, MeasurementError, check_file
from tissue_probe.sensor.belief import likely_unrest
from tissue_probe.sensor.cable import MOST_JOINTS, CableFunctions
from tissue_probe.sensor.free_air import FreeAir
from tissue_probe.sensor.identify import Identified
from tissue_probe.sensor.kinematics import Motion
from tissue_probe.sensor.load import load_columns
from tissue_probe.sensor.numbers import BIAS_PLACES, DELAY_PLACE, LOAD, RATE_PLACES
from tissue_probe.sensor.smoothed_air import LONGEST_SENSOR_DELAY, Smoothed
from tissue_probe.signals import NANOSECONDS, FloatArray, sound_stamp

SENSOR_FORMAT = "tissue_probe sensor 1"
#: Digits of a number in the file: those that the errors of any robot need.
DIGITS = 9


@dataclass(frozen=True)
class Compensation:
    """The wrench of a sensor without contact.

    Attributes
    ----------
    load : array, shape (10,)
        Mass [kg], mass times centre [kg m], inertia about the sensor's origin [kg m2], with the
        sensor's sign.
    gains : array, shape (6,)
        Of the axes.
    delay : float
        Of the wrench after the pose [s].
    bias, rate : array, shape (6,)
        At the stamp [N], [N m], and in a second.
    drift_covariance : array, shape (6, 2, 2)
        Of the errors of each axis' bias and rate.
    unrest : array, shape (6,)
        Variance that rates gain in a second.
    deviation : array, shape (6,)
        Standard deviation of load and cable, as poses of the identification had it.
    noise, noise_of_zero : array, shape (6,)
        Standard deviation of a sample, and of the mean of a second, whose noise is not white.
    range : array, shape (3,)
        Up to which acceleration [m/s2], angular velocity [rad/s], acceleration [rad/s2] it holds.
    stamp : int
        When bias and rate held [ns].
    cable : CableFunctions or None
        Functions of the cable.
    weights : array, shape (6, count)
        Of these.
    mass_deviation, delay_deviation : float
        Standard deviations of the mass' error [kg] and of the delay's [s]; infinite in a file that
        does not say.
    """

    load: FloatArray
    gains: FloatArray
    delay: float
    bias: FloatArray
    rate: FloatArray
    drift_covariance: FloatArray
    unrest: FloatArray
    deviation: FloatArray
    noise: FloatArray
    noise_of_zero: FloatArray
    range: FloatArray
    stamp: int
    cable: CableFunctions | None
    weights: FloatArray
    mass_deviation: float = math.inf
    delay_deviation: float = math.inf

    @property
    def mass(self) -> tuple[float, float]:
        """What hangs on the sensor, and its error [kg].

        The error is infinite with a cable, whose weight is one with it.
        """
        return abs(float(self.load[0])), math.inf if self.cable else self.mass_deviation

    def predict_pull(self, moved: Motion, run: FreeAir) -> FloatArray:
        """Return the wrench of load and cable, shape (n, 6), of motions and the poses of a run."""
        wrench = self.gains * (load_columns(moved) @ self.load)
        if self.cable is not None:
            wrench += self.cable.columns(run) @ self.weights.T
        return wrench

    def predict_bias(self, stamp: int) -> tuple[FloatArray, FloatArray]:
        """Return the bias at a stamp [ns], and the standard deviation of all that is predicted."""
        passed = (stamp - self.stamp) / NANOSECONDS
        step = np.array([1.0, passed])
        variance = np.einsum("j,ajk,k->a", step, self.drift_covariance, step)
        variance += self.unrest * abs(passed) ** 3 / 3.0 + self.deviation**2
        return self.bias + passed * self.rate, np.sqrt(variance)

    def with_zero(self, left: FloatArray, seconds: float, stamp: int) -> Compensation:
        """Return the same after a zero taken anew.

        Parameters
        ----------
        left : array, shape (6,)
            Mean of the wrench less load and cable, over some seconds of free air.
        seconds : float
            How long these were.
        stamp : int
            Their middle [ns].
        """
        passed = (stamp - self.stamp) / NANOSECONDS
        moved = np.array([[1.0, passed], [0.0, 1.0]])
        calm = moved @ self.drift_covariance @ moved.T
        missed = left - self.bias - passed * self.rate
        noise = self.noise_of_zero**2 / seconds + self.deviation**2
        gained = np.array([abs(passed) ** 3 / 3.0])
        unrest = likely_unrest(self.unrest, missed[None], (calm[:, 0, 0] + noise)[None], gained)
        walk = np.array([[abs(passed) ** 3 / 3.0, passed * abs(passed) / 2.0], [0.0, abs(passed)]])
        walk[1, 0] = walk[0, 1]
        prior = calm + unrest[:, None, None] * walk
        gain = prior[:, :, 0] / (prior[:, 0, 0] + noise)[:, None]
        state = np.stack([self.bias + passed * self.rate, self.rate], axis=1)
        state = state + gain * missed[:, None]
        covariance = prior - gain[:, :, None] * prior[:, None, 0]
        return replace(
            self,
            bias=state[:, 0],
            rate=state[:, 1],
            drift_covariance=covariance,
            unrest=unrest,
            stamp=stamp,
        )

    def text(self) -> str:
        """Return the file's text."""
        plain: dict[str, Any] = {"format": SENSOR_FORMAT}
        for name, value in asdict(self).items():
            if not (isinstance(value, float) and math.isinf(value)):
                plain[name] = _plain(value)
        return str(yaml.safe_dump(plain, sort_keys=False, default_flow_style=None))


def compensation(found: Identified, runs: list[FreeAir], origin: int) -> Compensation:
    """Return the part of the answer that a node needs.

    Parameters
    ----------
    found : Identified
        Of the stretches.
    runs : list of FreeAir
        The stretches.
    origin : int
        The stamp from which their times count [ns].
    """
    end = runs[-1].begin + runs[-1].seconds
    belief = found.fit.belief
    later = belief.at(end)
    point = later.point
    # Errors of load and cable alone: the bias, which is anew known at each zero, takes the mean.
    variance = []
    for run in runs:
        _, slopes = point.wrench(Smoothed(run, found.cable))
        slopes[:, :, BIAS_PLACES], slopes[:, :, RATE_PLACES] = 0.0, 0.0
        slopes -= slopes.mean(axis=0)
        variance.append(np.einsum("naj,jk,nak->na", slopes, belief.covariance, slopes))
    places = [(BIAS_PLACES.start + axis, RATE_PLACES.start + axis) for axis in range(6)]
    values = point.values
    return Compensation(
        load=values[LOAD],
        gains=point.gains,
        delay=float(values[DELAY_PLACE]),
        bias=values[BIAS_PLACES],
        rate=values[RATE_PLACES],
        drift_covariance=np.array([later.covariance[np.ix_(pair, pair)] for pair in places]),
        unrest=later.unrest,
        deviation=np.sqrt(np.concatenate(variance).mean(axis=0) + belief.unexplained),
        noise=found.noise,
        noise_of_zero=_of_a_second(found, runs),
        range=found.range,
        stamp=origin + round(end * NANOSECONDS),
        cable=found.cable,
        weights=point.weights if found.cable else np.empty((6, 0)),
        mass_deviation=found.number("mass").deviation,
        delay_deviation=found.number("delay").deviation,
    )


def _of_a_second(found: Identified, runs: list[FreeAir]) -> FloatArray:
    """Return the standard deviation of the mean wrench of a second."""
    times = Smoothed(runs[0]).time
    rate = 1.0 / float(np.median(np.diff(times)))
    return np.array([np.sqrt(colour.of_mean(1) / rate) for colour in found.fit.belief.colours])


def load_file(path: str | Path) -> Compensation:
    """Read the file that ``Compensation.text`` is the text of.

    Raises
    ------
    MeasurementError
        If it is none.
    OSError
        If it cannot be read.
    """
    check_file(Path(path))
    try:
        return _of_content(bounded_yaml.read(path))
    except YamlError as error:
        raise MeasurementError(f"{path} {error}") from None
    except MeasurementError as error:
        raise MeasurementError(f"{path}: {error}") from None


def parse(text: str) -> Compensation:
    """Return the model of a text.

    Raises
    ------
    MeasurementError
        If it is none; says why.
    """
    try:
        return _of_content(bounded_yaml.parse(text))
    except YamlError as error:
        raise MeasurementError(f"the text {error}") from None


def _of_content(content: Any) -> Compensation:
    if not isinstance(content, dict) or content.get("format") != SENSOR_FORMAT:
        raise MeasurementError(
            "it is no model of a sensor: give a file that `tissue_probe sensor` wrote"
        )
    try:
        return _of_plain(content)
    except ValueError as error:
        raise MeasurementError(f"the model of the sensor is damaged: {error}") from None


def _of_plain(content: dict[str, Any]) -> Compensation:
    cable = _cable(content["cable"]) if content.get("cable") is not None else None
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(("noise", "noise_of_zero", "gains"), (6,))
    shapes |= dict.fromkeys(("bias", "rate", "unrest", "deviation"), (6,))
    shapes |= {"load": (10,), "range": (3,), "drift_covariance": (6, 2, 2)}
    shapes |= {"weights": (6, cable.count if cable else 0)}
    arrays = {name: _numbers(content, name, shape) for name, shape in shapes.items()}
    for name in ("noise", "noise_of_zero", "range"):
        if not (arrays[name] > 0.0).all():
            raise ValueError(f"{name} is not positive")
    delay = float(_numbers(content, "delay", ()))
    # The search begins within these, and its steps may leave them a little.
    if abs(delay) > 2.0 * LONGEST_SENSOR_DELAY:
        raise ValueError(f"delay is {delay:g} s: sensors have {LONGEST_SENSOR_DELAY:g} s at most")
    stamp = sound_stamp(_whole(content, "stamp"))
    known = [name for name in ("mass_deviation", "delay_deviation") if name in content]
    told: dict[str, Any] = {name: float(_numbers(content, name, ())) for name in known}
    for name, value in told.items():
        if value < 0.0:
            raise ValueError(f"{name} is below 0")
    numbers: dict[str, Any] = {**arrays, **told}
    return Compensation(**numbers, delay=delay, stamp=stamp, cable=cable)


def _cable(content: Any) -> CableFunctions:
    if not isinstance(content, dict):
        raise ValueError("cable has no entries")
    joints, reach = _whole(content, "joints"), float(_numbers(content, "reach", ()))
    if not 0 <= joints <= MOST_JOINTS or reach <= 0.0:
        raise ValueError(f"the cable has {joints} joints and a reach of {reach:g} m")
    frame, place = _numbers(content, "frame", (3, 3)), _numbers(content, "place", (3,))
    return CableFunctions(joints, frame, place, reach)


def _numbers(content: dict[str, Any], name: str, shape: tuple[int, ...]) -> FloatArray:
    try:
        values = np.array(content.get(name), dtype=np.float64)
    except (TypeError, ValueError):  # words, dates, rows of several lengths
        values = np.array(np.nan)
    if values.shape != shape or not np.isfinite(values).all():
        wanted = f"the shape {shape} of finite numbers" if shape else "a finite number"
        raise ValueError(f"{name} has not {wanted}")
    return values


def _whole(content: dict[str, Any], name: str) -> int:
    value = content.get(name)
    if type(value) is not int:
        raise ValueError(f"{name} has not a whole number")
    return value


def save(path: str | Path, model: Compensation) -> None:
    """Write a model's file, in one motion: a node that starts meanwhile reads a whole one.

    Raises
    ------
    FileError
        If it cannot be written.
    """
    path = Path(path)
    unfinished = path.with_name(f"_unfinished-{path.name}")
    try:
        unfinished.write_text(model.text(), encoding="utf-8")
        os.replace(unfinished, path)
    except OSError as error:
        with suppress(OSError):
            unfinished.unlink()
        raise FileError(error.errno, error.strerror, str(path)) from None


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, np.ndarray):
        return [_plain(each) for each in value] if value.ndim > 1 else [_digits(v) for v in value]
    return _digits(value) if isinstance(value, float) else value


def _digits(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
