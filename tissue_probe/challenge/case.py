"""One measurement before noise is drawn: specimen, instrument and trajectory.

Contents: putting the three together, and how much an effect leaves to a Kelvin-Voigt fit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tissue_probe.challenge.change import Change, Situation
from tissue_probe.challenge.instrument import CHALLENGE_RATE, FORCE_NOISE, InstrumentErrors
from tissue_probe.challenge.kelvin_voigt import fit_residual
from tissue_probe.challenge.motion import MOTION_RATE, move
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.tolerances import Tolerances
from tissue_probe.challenge.trajectory import Trajectory
from tissue_probe.signals import FloatArray


@dataclass(frozen=True)
class Case:
    """Specimen, instrument and trajectory of one measurement."""

    specimen: Specimen
    instrument: InstrumentErrors
    trajectory: Trajectory

    @property
    def situation(self) -> Situation:
        """What effects are scaled by."""
        coil = self.trajectory
        return Situation(self.specimen, coil.amplitude, coil.preload, coil.duration, coil.highest)

    def apply_change(self, change: Change) -> Case:
        """Return the case with what an effect sets."""
        case = replace(
            self,
            specimen=self.specimen._replace(**change.specimen),
            instrument=replace(self.instrument, **change.instrument),
        )
        own = change.preload
        return case.press_in(self.trajectory.preload if own is None else own)

    def press_in(self, preload: float) -> Case:
        """Return the case with another preload [m], held until beta / k has passed eight times."""
        moving = self.specimen.surface_amplitude != 0.0
        settling = 8.0 * self.specimen.damping / self.specimen.stiffness
        # Whole milliseconds, so that every rate has a sample where the lead begins.
        hold = round(0.3 + settling, 3) if preload or moving else 0.0
        return replace(self, trajectory=replace(self.trajectory, preload=preload, hold=hold))

    def measure(self, noise: FloatArray, rate: int = MOTION_RATE) -> tuple[FloatArray, FloatArray]:
        """Return position [m] and force [N] at 2 kHz, the noise [N] added to the force.

        Parameters
        ----------
        noise : array, shape (duration * 2 kHz,)
        rate : int
            Steps a second of the integration [Hz], a multiple of 2 kHz.
        """
        coil, instrument = self.trajectory, self.instrument
        u = coil.sample_motion(CHALLENGE_RATE)[0][coil.before(CHALLENGE_RATE) : -1]
        force = move(self.specimen, coil, rate)
        return instrument.position(u), instrument.force(force, rate, coil.before(rate), noise)

    @property
    def samples(self) -> int:
        """Number of samples of the record."""
        return round(self.trajectory.duration * CHALLENGE_RATE)

    def ratio(
        self, rig: Specimen, rate: int = MOTION_RATE, tolerances: Tolerances | None = None
    ) -> float:
        """Return the rms that the best Kelvin-Voigt fit leaves, in units of the noise.

        The noise is counted as if it were there: 1 means that nothing else is left. The position
        counts from the surface, as the fit would know it on an exact rig.

        Parameters
        ----------
        rig : Specimen
            Rig and tissue as they would be without the effect.
        rate : int
            Steps a second of the integration [Hz].
        tolerances : Tolerances, optional
            Within which the fit may move the rig; by default it knows the rig exactly.
        """
        position, force = self.measure(np.zeros(self.samples), rate)
        if not np.isfinite(force).all():
            return np.inf
        left = fit_residual(position - self.instrument.contact_zero, force, rig, tolerances)
        return float(np.hypot(1.0, np.sqrt(np.mean(left**2)) / FORCE_NOISE))
