"""The force of a model with typical values under a given motion, with an effect and without."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tissue_probe.analysis.measurements import Measurements
from tissue_probe.analysis.simulating import simulate
from tissue_probe.diagnosis.advice.separation import PROBE_AMPLITUDE
from tissue_probe.excitation import parse_excitation
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import Effect
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.rigs import RIGS, Rig
from tissue_probe.quantities import POSITION
from tissue_probe.signals import FloatArray

#: Samples a second of the suite's probe [Hz].
PAGE_RATE = 2000.0
#: Frequency of the second input, of amplitude 1: that of no motion [Hz].
SECOND_FREQUENCY = 0.7
#: The motion sets in over this time [s], a tenth of the shortest experiment.
SETTING_IN = 0.2


@dataclass(frozen=True)
class DriveMotion:
    """A motion of the drive, from rest at the surface.

    Attributes
    ----------
    excitation : mapping
        As ``parse_excitation`` takes it, without an amplitude.
    preload : float
        Mean position [m].
    duration : float
        [s]
    """

    excitation: Mapping[str, object]
    preload: float
    duration: float

    @property
    def times(self) -> FloatArray:
        """Times of the samples [s]."""
        return np.arange(round(self.duration * PAGE_RATE)) / PAGE_RATE

    @property
    def position(self) -> FloatArray:
        """Position at each sample [m]."""
        signal = parse_excitation({**self.excitation, "amplitude": PROBE_AMPLITUDE})(self.times)
        return np.asarray(_begin_gently(self.times) * (self.preload + signal), dtype=np.float64)

    def __str__(self) -> str:
        told = self.excitation
        band = f"{told.get('start', told.get('frequency')):g}"
        band += f" to {told['stop']:g}" if "stop" in told else ""
        about = f"about {1e3 * self.preload:g} mm" if self.preload else "about the surface"
        return (
            f"{told['kind']}, {band} Hz, {1e3 * PROBE_AMPLITUDE:g} mm {about}, {self.duration:g} s"
        )


def _begin_gently(times: FloatArray) -> FloatArray:
    """Return a factor from 0 to 1 without a jump of speed or acceleration (minimum jerk).

    A jump would tell effects apart that the experiment itself does not.
    """
    share = np.minimum(times / SETTING_IN, 1.0)
    return np.asarray(share**3 * (10.0 - 15.0 * share + 6.0 * share**2))


def rig_for(effect: Effect) -> Rig:
    """Return the rig on which an effect is shown: one whose tip is the position, if it can be."""
    rigs = [rig for rig in RIGS.values() if rig.input is POSITION and rig.admits(effect)]
    return sorted(rigs, key=lambda rig: not rig.tip_is_position)[0]


def typical(composition: Composition) -> dict[str, float]:
    """Return the typical value of each number of a model [SI]."""
    return {entry.name: entry.default for entry in composition.values}


def force(composition: Composition, values: Mapping[str, float], motion: DriveMotion) -> FloatArray:
    """Return the force of a model at each sample of a motion [N]."""
    return simulate_recording(composition, values, motion).force


def simulate_recording(
    composition: Composition, values: Mapping[str, float], motion: DriveMotion, noise: float = 0.0
) -> Measurements:
    """Return a simulated recording of a motion; a second input, where one is heard, is a sine."""
    model = FittedModel(composition, dict(values), {})
    heard = (
        np.sin(2.0 * np.pi * SECOND_FREQUENCY * motion.times)
        if composition.kernel.hears_input2
        else None
    )
    return simulate(model, motion.position, sample_rate=PAGE_RATE, noise=noise, input2=heard)
