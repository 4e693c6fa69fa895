"""A model under a given motion or force: the samples that the rig would measure."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from tissue_probe import arguments as take
from tissue_probe.analysis.measurements import Measurements, ReadRecording
from tissue_probe.analysis.question import either_model
from tissue_probe.errors import MeasurementError, ParameterError
from tissue_probe.excitation import (
    Chirp,
    Excitation,
    Multisine,
    Sine,
    SteppedSweep,
    parse_excitation,
)
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.interpolation import FEWEST_KNOTS
from tissue_probe.physics.model_file import load
from tissue_probe.physics.response import course, respond
from tissue_probe.quantities import FORCE
from tissue_probe.recording.columns.bounds import MOST_ROWS
from tissue_probe.recording.columns.in_memory import columns_in_memory
from tissue_probe.signals import Channel, FloatArray, Recording, SampleBlock


@take.checks(
    model=either_model,
    duration=take.number(above=0.0, unit="s"),
    sample_rate=take.number(above=0.0, unit="Hz"),
    mean=take.number(),
    noise=take.number(least=0.0),
    seed=take.whole(),
)
def simulate(
    model: str | Path | FittedModel,
    excitation: Excitation | Mapping[str, object] | ArrayLike,
    *,
    duration: float = 2.0,
    sample_rate: float = 2000.0,
    mean: float = 0.0,
    noise: float = 0.0,
    seed: int = 0,
    input2: ArrayLike | None = None,
) -> Measurements:
    """Simulate the samples of a model's rig, from rest.

    Parameters
    ----------
    model : path or FittedModel
        A model with values, such as ``diagnose(...).model``.
    excitation : Excitation, mapping or array
        The input: a signal of ``tissue_probe.excitation``, its description such as
        ``{"kind": "sine", "frequency": 10.0, "amplitude": 1e-3}``, or samples; displacement of the
        coil [m], or where a force drives, that force [N].
    duration : float
        Of a signal [s]; samples have their own.
    sample_rate : float
        [Hz]
    mean : float
        Added to the signal, in its unit: a preload.
    noise : float
        Standard deviation of white noise on the predicted output [its unit].
    seed : int
        Of the noise.
    input2 : array, shape (n,), optional
        Samples of the second input, in its unit, of a model that follows one.

    Returns
    -------
    Measurements
        Position and force, to be compared, fitted or drawn as if measured.

    Raises
    ------
    ParameterError
        If a number is out of its range, or the model has no values.
    MeasurementError
        If the model diverges.
    """
    found = model if isinstance(model, FittedModel) else load(model)
    kernel, period = found.composition.kernel, 1.0 / sample_rate
    if missing := [name for name in kernel.values if name not in found.values]:
        raise ParameterError(f"`model` has no value for {', '.join(missing)}: fit it first")
    drive = _sample_drive(excitation, duration, period) + mean
    second = _second(kernel.hears_input2, input2, drive.size)
    values = np.array([found.values[name] for name in kernel.values])
    start = kernel.begin(values, float(drive[0]), 0.0, float(second[0]))
    coil = course(kernel, drive, period, values, input2=second)
    output = respond(kernel, values, start, coil).output
    if not np.isfinite(output).all():
        raise MeasurementError("`model`: it diverges under this excitation; give a smaller one")
    output = output + noise * np.random.default_rng(seed).standard_normal(output.size)
    position, force = (drive, output) if found.composition.output is FORCE else (output, drive)
    block = SampleBlock(0, 0, period, position, force, np.full(drive.size, np.nan))
    channel = Channel("input2", 0, np.arange(drive.size, dtype=np.float64) * period, second)
    heard = channel if kernel.hears_input2 else None
    recording = Recording((block,), input2=heard)
    return Measurements((ReadRecording("simulated", None, recording, ()),))


def _second(is_heard: bool, given: ArrayLike | None, count: int) -> FloatArray:
    """Return the samples of a second input, 0 where the model follows none."""
    if not is_heard and given is None:
        return np.zeros(count)
    if not is_heard:
        raise ParameterError("`input2`: the model follows no second input; leave it out")
    second = np.asarray(() if given is None else given, dtype=np.float64)
    if second.shape != (count,) or not np.isfinite(second).all():
        raise ParameterError(
            f"`input2`: the model follows a second input; give {count} finite samples of it"
        )
    return second


def _sample_drive(
    excitation: Excitation | Mapping[str, object] | ArrayLike, duration: float, period: float
) -> FloatArray:
    if isinstance(excitation, Mapping):
        excitation = parse_excitation(dict(excitation))
    if isinstance(excitation, Sine | SteppedSweep | Chirp | Multisine):
        if not FEWEST_KNOTS <= duration / period <= MOST_ROWS:
            raise ParameterError(
                f"`duration` {duration:g} s at a `sample_rate` of {1.0 / period:g} Hz is "
                f"{duration / period:.4g} samples; give values with {FEWEST_KNOTS} to {MOST_ROWS}"
            )
        times = np.arange(round(duration / period), dtype=np.float64) * period
        return np.asarray(excitation(times), dtype=np.float64)
    samples = columns_in_memory({"samples": excitation}, "`excitation`").read(["samples"])
    (driven,) = samples.columns
    if (
        driven.dtype.kind not in "fiu"
        or driven.size < FEWEST_KNOTS
        or not np.isfinite(driven).all()
    ):
        raise ParameterError(
            f"`excitation` needs at least {FEWEST_KNOTS} finite numbers, one after another"
        )
    return driven.astype(np.float64)
