"""A learnt shape as the effect that a user would get of it, fitted as every effect is.

Contents: the model with that effect, and whether it leaves noise only where it was not fitted.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tissue_probe.diagnosis.evidence.adequacy import SIZE
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidates import fit_candidates
from tissue_probe.diagnosis.ranking.other_runs import carry_model
from tissue_probe.diagnosis.second_recording import FAR_RATIO
from tissue_probe.diagnosis.shape.choice import FITS, HOLDS
from tissue_probe.physics.library import load_effects
from tissue_probe.signals import FloatArray

#: Parts of a record that are looked at one by one: each has some periods of the motion.
PARTS = 25


@dataclass(frozen=True, eq=False)
class FittedShape:
    """A model with a learnt shape's effect.

    Attributes
    ----------
    fit : Fit
        The model.
    leaves_noise : bool
        Whether it leaves noise only, in each part of the record that is held out, too.
    carries_over : bool
        Whether it does on other recordings, within the depths and speeds of those that were fitted:
        beyond, a table says nothing. It does not where it diverges.
    """

    fit: Fit
    leaves_noise: bool
    carries_over: bool

    @property
    def confirms(self) -> bool:
        """Whether the shape is no artefact of how it was learnt."""
        return self.leaves_noise and self.carries_over


def fit_shape(
    text: str, beside: Fit, instrument: Instrument, second: Sequence[Measurement] = ()
) -> FittedShape | None:
    """Fit a model with a learnt shape's effect; None where no search leads to a fit.

    The shape was learnt along a path, to first order: here the tip moves as the effect lets it.

    Parameters
    ----------
    text : str
        The effect's file.
    beside : Fit
        The model that the shape was learnt beside.
    instrument : Instrument
        Constants of the rig with their tolerances.
    second : sequence of Measurement
        Other recordings of the specimen.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "effect.py"
        path.write_text(text, encoding="utf-8")
        effects = load_effects(path)
    for fit in fit_candidates(beside, effects, instrument):
        moved = carry_model(fit.composition, fit.named(), second, instrument) if second else None
        carries = not second or (moved is not None and _left(fit, moved) <= FAR_RATIO)
        return FittedShape(fit, _leaves_noise(fit), carries)
    return None


def _leaves_noise(fit: Fit) -> bool:
    """Whether a fit leaves noise only, and no part of a record, held out, stands out of it.

    A function that is right on the whole, and wrong in the few moments that another motion would
    have often, shows in these alone. Of few samples the noise is known roughly, as ``SIZE`` says.
    """
    if fit.ratio > FITS:
        return False
    for measurement, residual in zip(fit.measurements, fit.heldout, strict=True):
        for part in np.array_split(measurement.over_noise(residual), PARTS):
            most = 1.0 + np.hypot(SIZE / np.sqrt(part.size), HOLDS - 1.0)
            if np.mean(part**2) > most**2:
                return False
    return True


def _left(fit: Fit, moved: Fit) -> float:
    """Return the residual of other recordings over the noise, inside the range of the first."""
    first = [np.concatenate(each) for each in zip(*_courses(fit), strict=True)]
    left = []
    for index, course in enumerate(_courses(moved)):
        measurement = moved.measurements[index]
        inside = measurement.counted
        for own, known in zip(course, first, strict=True):
            inside = inside & (own >= known.min()) & (own <= known.max())
        noise = np.hypot(measurement.noise.own, fit.excess)
        left.append(moved.residuals[index][inside] / noise)
    every = np.concatenate(left)
    return float(np.sqrt(np.mean(every**2))) if every.size else 0.0


def _courses(fit: Fit) -> list[tuple[FloatArray, FloatArray]]:
    """Return the displacement [m] and the speed [m/s] of the tip in each measurement."""
    pairs = zip(fit.tip, fit.measurements, strict=True)
    return [(tip, np.gradient(tip, measurement.times)) for tip, measurement in pairs]
