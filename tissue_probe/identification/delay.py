"""The delay of the force channel against the position channel, from a run in free air.

In free air the paper's eq. 1 gives the force from the coil's displacement alone,

    F / u = k0 m s^2 / (m s^2 + beta0 s + k0),   s = i w

and a delay T of the force turns its phase by -w T. The stretches of the run are independent
measurements of T, whose scatter gives the interval; one in which a sample is missing is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.signal.windows import hann

from tissue_probe.identification.line import CONFIDENCE, Interval
from tissue_probe.signals import FloatArray

#: Into so many stretches a run is cut.
STRETCHES = 10
#: Fewest of them that must be whole.
LEAST_STRETCHES = 5
#: Frequencies with less than this part of the strongest one's power tell nothing.
LEAST_POWER = 0.01
#: Shortest stretch [s].
SHORTEST_STRETCH = 0.5


@dataclass(frozen=True)
class Delay:
    """By how much the force comes after the position [s], and its 95 % confidence interval."""

    seconds: float
    interval: Interval


def force_delay(
    position: FloatArray,
    force: FloatArray,
    sample_period: float,
    tip_mass: float,
    load_cell_stiffness: float,
    load_cell_damping: float,
) -> Delay:
    """Return the delay of the force channel.

    Parameters
    ----------
    position : array, shape (n,)
        Displacement of the coil [m] in free air.
    force : array, shape (n,)
        Force [N], positive in compression.
    sample_period : float
        Time between two samples [s].
    tip_mass, load_cell_stiffness, load_cell_damping : float
        The tool's m [kg], k0 [N/m], beta0 [N s/m].

    Raises
    ------
    ValueError
        If the run is shorter than 5 s, more than half of its stretches lack a sample, or the forces
        are not those of a free tip.
    """
    size = position.size // STRETCHES
    if size * sample_period < SHORTEST_STRETCH:
        raise ValueError(f"the run is too short: record {STRETCHES * SHORTEST_STRETCH:g} s or more")
    tool = (tip_mass, load_cell_stiffness, load_cell_damping)
    stretches = [slice(first, first + size) for first in range(0, STRETCHES * size, size)]
    whole = [s for s in stretches if np.isfinite(position[s] + force[s]).all()]
    if len(whole) < LEAST_STRETCHES:
        raise ValueError("too many samples are missing: record the run again")
    found = np.array([_delay(position[s], force[s], sample_period, tool) for s in whole])
    spread = stats.t.ppf(0.5 + CONFIDENCE / 2.0, found.size - 1) * found.std(ddof=1)
    spread /= np.sqrt(found.size)
    return Delay(float(found.mean()), (float(found.mean() - spread), float(found.mean() + spread)))


def _delay(
    position: FloatArray,
    force: FloatArray,
    sample_period: float,
    tool: tuple[float, float, float],
) -> float:
    """Return the delay in one part: the phase's slope, weighted by each frequency's precision."""
    mass, stiffness, damping = tool
    window = hann(position.size, sym=False)
    u, f = (np.fft.rfft(window * (each - each.mean())) for each in (position, force))
    s = 2.0j * np.pi * np.fft.rfftfreq(position.size, sample_period)
    expected = stiffness * mass * s**2 / (mass * s**2 + damping * s + stiffness) * u
    power = np.abs(expected) ** 2
    told = (power > LEAST_POWER * power.max()) & (s.imag < 0.5 * np.sqrt(stiffness / mass))
    cross = (f * np.conj(expected))[told]
    if not told.any() or cross.sum().real < 0.5 * power[told].sum():
        raise ValueError(
            "the force is not that of a tip in free air: lift the probe, drive it at 10 Hz or "
            "more, and give the tool's constants before"
        )
    weight = power[told] * s.imag[told]
    return float(-np.sum(weight * np.angle(cross)) / np.sum(weight * s.imag[told]))
