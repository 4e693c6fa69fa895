"""Taking parts faster than the motion out of measurements.

Contents: one filter for all channels alike, so that none comes late against another.
"""

from __future__ import annotations

from dataclasses import replace

from tissue_probe.errors import ParameterError
from tissue_probe.signals import SampleBlock

FILTER_ORDER = 4
#: Samples that are kept in a cycle of the cut-off frequency: the remaining noise stays white.
SAMPLES_A_CYCLE = 2.5


def filter_block(block: SampleBlock, frequency: float) -> SampleBlock:
    """Filter position and force alike, without delay, and keep as many samples as that leaves.

    A linear model holds for filtered signals as it does for the raw ones, and its acceleration
    term no longer drowns in the position's resolution, which two derivatives magnify.

    Parameters
    ----------
    block : SampleBlock
        Finite samples.
    frequency : float
        Where a Butterworth filter of fourth order, run forth and back, halves the signal [Hz].

    Raises
    ------
    ParameterError
        If the samples are too few, or taken too slowly, for this filter.

    Notes
    -----
    M. Gautier, "Dynamic identification of robots with power model", IEEE ICRA (1997), 1922-1927:
    the "parallel filtering" and decimation of robot identification.
    """
    rate = 1.0 / block.sample_period
    slowest = rate / len(block)  # a cycle in the record: of slower ones it tells nothing
    if not slowest <= frequency <= rate / SAMPLES_A_CYCLE:
        raise ParameterError(
            f"`lowpass` {frequency:g}: with {rate:.4g} samples a second, {len(block)} without a "
            f"gap, give a frequency from {slowest:.4g} to {rate / SAMPLES_A_CYCLE:.4g} Hz"
        )
    if len(block) < 100:
        raise ParameterError(
            f"`lowpass`: {len(block)} samples are too few to be filtered; give 100"
        )
    from scipy.signal import butter, sosfiltfilt  # only where a low-pass is asked for

    sections = butter(FILTER_ORDER, frequency, fs=rate, output="sos")
    every = int(rate / (SAMPLES_A_CYCLE * frequency) + 1e-9)
    position, force = (
        sosfiltfilt(sections, channel)[::every] for channel in (block.position, block.force)
    )
    return replace(
        block,
        sample_period=every * block.sample_period,
        position=position.copy(),
        force=force.copy(),
        command=block.command[::every].copy(),
    )
