"""A model under a motion or force that is given: what the rig would measure."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from tissue_probe.analysis.measurements import Measurements, ReadRecording
from tissue_probe.errors import MeasurementError, ParameterError
from tissue_probe.excitation import Excitation, parse_excitation
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.model_file import load
from tissue_probe.physics.response import course, respond
from tissue_probe.quantities import FORCE
from tissue_probe.signals import FloatArray, Recording, SampleBlock


def simulate(
    model: str | Path | FittedModel,
    excitation: Excitation | Mapping[str, object] | ArrayLike,
    *,
    duration: float = 2.0,
    sample_rate: float = 2000.0,
    mean: float = 0.0,
    noise: float = 0.0,
    seed: int = 0,
) -> Measurements:
    """Simulate what a model's rig measures, from rest.

    Parameters
    ----------
    model : path or FittedModel
        A model with values, such as ``diagnose(...).model``.
    excitation : Excitation, mapping or array
        What drives: a signal of ``tissue_probe.excitation``, its description such as
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
    if not 0.0 < sample_rate < np.inf or not 0.0 < duration < np.inf:
        raise ParameterError(
            f"`sample_rate` is {sample_rate} Hz and `duration` {duration} s; both must be positive"
        )
    found = model if isinstance(model, FittedModel) else load(model)
    kernel, period = found.composition.kernel, 1.0 / sample_rate
    if missing := [name for name in kernel.values if name not in found.values]:
        raise ParameterError(f"`model` has no value for {', '.join(missing)}: fit it first")
    drive = _driven(excitation, duration, period) + mean
    values = np.array([found.values[name] for name in kernel.values])
    start = kernel.begin(values, float(drive[0]), 0.0)
    output = respond(kernel, values, start, course(kernel, drive, period, values)).output
    if not np.isfinite(output).all():
        raise MeasurementError("`model`: it diverges under this excitation; give a smaller one")
    output = output + noise * np.random.default_rng(seed).standard_normal(output.size)
    position, force = (drive, output) if found.composition.output is FORCE else (output, drive)
    block = SampleBlock(0, 0, period, position, force, np.full(drive.size, np.nan))
    return Measurements((ReadRecording("simulated", None, Recording((block,)), ()),))


def _driven(
    excitation: Excitation | Mapping[str, object] | ArrayLike, duration: float, period: float
) -> FloatArray:
    if isinstance(excitation, Mapping):
        excitation = parse_excitation(dict(excitation))
    if callable(excitation):
        return excitation(np.arange(round(duration / period), dtype=np.float64) * period)
    samples = np.asarray(excitation, dtype=np.float64)
    if samples.ndim != 1 or samples.size < 2 or not np.isfinite(samples).all():
        raise ParameterError("`excitation` needs at least two finite samples, one after another")
    return samples
