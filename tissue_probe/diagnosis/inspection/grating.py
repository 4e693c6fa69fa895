"""Whether the roughness of a position repeats with the place: an encoder's error, and no noise."""

from __future__ import annotations

import numpy as np

from tissue_probe.signals import FloatArray

#: Periods of gratings [m], from and to; and travel of more than so many of the longest is not
#: looked at: the periods that can be told apart are too many.
FINE, WIDE, MANY = 4e-6, 2e-4, 100
#: Samples in a row that tell it.
SAMPLES_IN_A_ROW = 2000
#: Differences of this order leave noise, and nothing of a motion that is sampled well.
GRATING_ORDER = 6
#: A value that exceeds the median by this factor is no noise, and no error of a grating.
CORNER = 8.0
#: Share of the roughness from which it is the encoder's: of noise hardly any repeats.
REPEATS = 0.5


def repeats(position: FloatArray, place: FloatArray, scale: float = 1.0) -> float:
    """Return the share of a position's roughness that one sine of the place explains, 0 to 1.

    Parameters
    ----------
    position, place : array, shape (n,)
        As it was read, and the smooth course in it [m]: the noise itself tells no place.
    scale : float
        How many times larger than usual lengths are.
    """
    position, place = position[:SAMPLES_IN_A_ROW] / scale, place[:SAMPLES_IN_A_ROW] / scale
    travel = float(np.ptp(place))
    rough = np.diff(position, GRATING_ORDER)
    # A corner of the motion stands out, and is passed at one place.
    usual = np.abs(rough) <= CORNER * np.median(np.abs(rough))
    rough = rough[usual]
    whole = float(rough @ rough)
    if not (WIDE < travel < MANY * WIDE and whole > 0.0):
        return 0.0
    # Waves to a travel: half of one more is another wave.
    waves = np.arange(travel / WIDE, travel / FINE, 0.5)
    # Each wave is the one before, turned by half a wave along the travel.
    half, most = np.exp(1j * np.pi * place / travel), 0.0
    wave = np.exp(2j * np.pi * waves[0] * place / travel)
    for _ in waves:
        changes = np.diff(wave, GRATING_ORDER)[usual]
        sines = np.stack([changes.imag, changes.real])
        told = sines @ rough
        most = max(most, float(told @ np.linalg.lstsq(sines @ sines.T, told, rcond=None)[0]))
        wave = wave * half
    return most / whole
