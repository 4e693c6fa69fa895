"""A probe on tissue, simulated exactly and apart from everything the estimators integrate with.

Coil, tip and tissue together are one linear system whose only input, the sine of the coil, is an
oscillator among its states: the matrix exponential steps it without error. Tissue may have a
relaxation branch (standard linear solid; Fung, 1993, section 2.11), which Kelvin-Voigt lacks.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.linalg import expm

from tissue_probe.signals import FloatArray, SampleBlock

SAMPLE_PERIOD = 5e-4  # s; 2 kHz, section III-D
TIP_MASS, LOAD_CELL_STIFFNESS, LOAD_CELL_DAMPING = 0.04, 9700.0, 0.8  # SI; section IV-A
FORCE_NOISE = 0.005  # N; the root of v_t, section V-A
ENCODER_RESOLUTION = 1e-7  # m
PAPER_AMPLITUDE = 2.3e-3  # m; makes 1 N on the tissue of the baseline, as in figure 8


@dataclass(frozen=True)
class SimulatedTissue:
    """Kelvin-Voigt tissue with, perhaps, a spring and a damper in series beside it.

    Attributes
    ----------
    stiffness, damping : float
        k [N/m] and beta [N s/m] without the branch.
    relaxing_stiffness, relaxation_rate : float
        Spring k1 [N/m] and rate r [1/s] of the branch, whose damper is k1 / r.
    """

    stiffness: float
    damping: float
    relaxing_stiffness: float = 0.0
    relaxation_rate: float = 100.0

    def at(self, frequency: float) -> tuple[float, float]:
        """Return k [N/m] and beta [N s/m] that a sine of this frequency [Hz] meets.

        The branch adds k1 w^2 / (w^2 + r^2) to k and k1 r / (w^2 + r^2) to beta.
        """
        w, rate = 2.0 * np.pi * frequency, self.relaxation_rate
        share = self.relaxing_stiffness / (w**2 + rate**2)
        return self.stiffness + share * w**2, self.damping + share * rate


NO_CONTACT = SimulatedTissue(0.0, 0.0)


@dataclass(frozen=True)
class SineExperiment:
    """One measurement with a sine at the coil, which starts at rest.

    ``tissues`` holds (time [s] from which it is under the tip, tissue), the first at 0; times are
    those of samples. ``frequency`` [Hz], ``amplitude`` of the coil [m], ``duration`` of the
    measurement [s], which begins ``lead`` [s] after the motion.
    """

    tissues: tuple[tuple[float, SimulatedTissue], ...]
    duration: float = 1.0
    frequency: float = 10.0
    amplitude: float = PAPER_AMPLITUDE
    lead: float = 0.0
    seed: int = 0

    @property
    def time(self) -> FloatArray:
        """Time of each sample after the first [s]."""
        return np.arange(round(self.duration / SAMPLE_PERIOD), dtype=float) * SAMPLE_PERIOD

    def truth(self) -> tuple[FloatArray, FloatArray]:
        """Return k [N/m] and beta [N s/m] at the frequency of the coil, at each sample."""
        known = np.array([tissue.at(self.frequency) for _, tissue in self.tissues])
        return tuple(known[self._pieces()[self._first :]].T)

    @cache  # noqa: B019 - an experiment is a few numbers, and every filter asks for the same
    def samples(self) -> SampleBlock:
        """Return the samples of encoder and load cell, with the noise of the seed."""
        position, tip = self.motion()
        force = LOAD_CELL_STIFFNESS * (position - tip)
        force += FORCE_NOISE * np.random.default_rng(self.seed).standard_normal(force.size)
        position = np.round(position / ENCODER_RESOLUTION) * ENCODER_RESOLUTION
        unknown = np.full(force.size, np.nan)
        return SampleBlock(0, 0, SAMPLE_PERIOD, position, force, unknown)

    def motion(self) -> tuple[FloatArray, FloatArray]:
        """Return the displacement of coil and of tip [m] at each sample, exact."""
        steps = [expm(SAMPLE_PERIOD * self._rates(tissue)) for _, tissue in self.tissues]
        states = np.zeros((self._first + self.time.size, 5))
        states[0, 4] = 1.0
        for sample, piece in enumerate(self._pieces()[:-1]):
            states[sample + 1] = steps[piece] @ states[sample]
        measured = states[self._first :]
        return self.amplitude * measured[:, 3], measured[:, 0]

    @property
    def _first(self) -> int:
        """Number of the first measured sample after the start of the motion."""
        return round(self.lead / SAMPLE_PERIOD)

    def _pieces(self) -> np.ndarray:
        """Return which tissue is under the tip from each sample on; 0 is the motion's start."""
        starts = [round(start / SAMPLE_PERIOD) for start, _ in self.tissues]
        samples = np.arange(self._first + self.time.size)
        return np.searchsorted(starts, samples, side="right") - 1

    def _rates(self, tissue: SimulatedTissue) -> FloatArray:
        """Return the matrix of [x, x', extension of the branch, sin, cos] (paper, eq. 1)."""
        w = 2.0 * np.pi * self.frequency
        tip = np.array(
            [
                -(LOAD_CELL_STIFFNESS + tissue.stiffness),
                -(LOAD_CELL_DAMPING + tissue.damping),
                -tissue.relaxing_stiffness,
                LOAD_CELL_STIFFNESS * self.amplitude,
                LOAD_CELL_DAMPING * self.amplitude * w,
            ]
        )
        branch = [0.0, 1.0, -tissue.relaxation_rate, 0.0, 0.0]
        return np.array(
            [[0, 1, 0, 0, 0], tip / TIP_MASS, branch, [0, 0, 0, 0, w], [0, 0, 0, -w, 0]]
        )
