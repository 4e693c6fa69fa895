"""Lines in the spectrum of a residual: harmonics of the drive, the mains, and lines of their own.

Contents: tests of single frequencies. Each compares a line with the noise and with the spectrum
beside it, whichever is larger, so that a broad rise is no line.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from tissue_probe.diagnosis.chance import f_beyond
from tissue_probe.diagnosis.residuals.drive import Drive, drive_of, spectrum
from tissue_probe.diagnosis.residuals.residual_test import (
    SIGNIFICANCE,
    ResidualTest,
    judge_test,
    untold,
)
from tissue_probe.quantities import Quantity
from tissue_probe.signals import FloatArray

MAINS = (50.0, 60.0)  # Hz
BINS_BESIDE = 31  # bins whose median is the background
LINE_WIDTH = 2  # bins to either side that the window spreads a line over
SLOW_CYCLES = 3.0  # Hz; breathing, heartbeat and drift lie below


@dataclass(frozen=True)
class _Lines:
    """The residual's spectrum in multiples of its background."""

    frequencies: FloatArray
    power: FloatArray
    height: FloatArray
    samples: int
    drive: Drive
    output: Quantity

    def near(self, frequency: float) -> NDArray[np.bool_]:
        """Return the bins over which a line at this frequency is spread."""
        found: NDArray[np.bool_] = (
            np.abs(self.frequencies - frequency) <= (LINE_WIDTH + 0.5) * self.frequencies[0]
        )
        return found

    def harmonic(self) -> NDArray[np.bool_]:
        """Return the bins at multiples of the drive's repetition, itself among them."""
        if self.drive.repetition is None:
            return np.zeros(self.frequencies.size, dtype=bool)
        ratio = self.frequencies / self.drive.repetition
        distance = np.abs(ratio - np.rint(ratio)) * self.drive.repetition
        found: NDArray[np.bool_] = (distance <= 0.75 * self.frequencies[0]) & (ratio > 0.5)
        return found

    def strongest(self, among: NDArray[np.bool_]) -> tuple[float, float, float]:
        """Return frequency [Hz] and amplitude of the strongest line, and the highest's p-value.

        The strongest is looked for among those that no noise explains, if there are any.
        """
        # The background comes from about BINS_BESIDE ordinates, so a line's height is
        # F-distributed.
        chances = among.sum() * f_beyond(self.height, 2, BINS_BESIDE)
        sure = among & (chances < SIGNIFICANCE)
        weight = (
            np.where(sure, self.power, -1.0) if sure.any() else np.where(among, self.height, -1)
        )
        frequency = self.frequencies[np.argmax(weight)]
        amplitude = 2.0 * np.sqrt(self.power[self.near(frequency)].sum() / self.samples)
        return float(frequency), float(amplitude), float(min(1.0, chances[among].min()))


def _lines_of(
    residual: FloatArray, drive: FloatArray, sample_period: float, noise: float, output: Quantity
) -> _Lines:
    frequencies, power = spectrum(residual, sample_period)
    beside = ndimage.median_filter(power, BINS_BESIDE, mode="mirror") / np.log(2.0)
    height = power / np.maximum(beside, noise**2)
    driven = drive_of(drive, sample_period)
    return _Lines(frequencies, power, height, residual.size, driven, output)


def line_tests(
    residual: FloatArray, drive: FloatArray, sample_period: float, noise: float, output: Quantity
) -> tuple[ResidualTest, ...]:
    """Test for harmonics, for each mains frequency, and for lines that belong to neither.

    Parameters
    ----------
    residual, drive : array, shape (N,)
        Measured minus predicted output; the input, as the displacement of the coil [m].
    sample_period : float
        Time between two samples [s].
    noise : float
        Standard deviation of the output's white noise.
    output : Quantity
        The predicted channel.
    """
    lines = _lines_of(residual, drive, sample_period, noise, output)
    return (_harmonics(lines), *(_mains(lines, frequency) for frequency in MAINS), _others(lines))


def _harmonics(lines: _Lines) -> ResidualTest:
    """Look where the drive repeats but does not move: only a nonlinearity answers there.

    The mains' frequencies are left to their own tests.
    """
    name, repetition = "harmonics", lines.drive.repetition
    among = lines.harmonic() & ~lines.drive.driven
    for mains in MAINS:
        among &= ~lines.near(mains)
    if repetition is None or not among.any():
        return untold(name, "the drive does not repeat within the record")
    frequency, amplitude, chance = lines.strongest(among)
    return judge_test(
        name,
        amplitude,
        chance,
        f"strongest where the drive is silent: {lines.output.tell(amplitude)} at "
        f"{frequency:.4g} Hz, {round(frequency / repetition)} times the {repetition:.4g} Hz at "
        "which the drive repeats",
        "the tissue or the instrument is not linear: stiffening, friction, contact, backlash, or "
        "the encoder (encoder_quantization, encoder_interpolation)"
        + _parity(lines, among, repetition),
    )


def _parity(lines: _Lines, among: NDArray[np.bool_], repetition: float) -> str:
    """Explain even or odd harmonics, if the drive itself has odd ones only."""
    order = np.rint(lines.frequencies / repetition).astype(int)
    if (lines.drive.driven & lines.harmonic() & (order % 2 == 0)).any():
        return ""
    even = lines.power[among & (order % 2 == 0)].sum()
    if even > 0.5 * lines.power[among].sum():
        return (
            "; mostly even harmonics, as of an effect that differs inwards and outwards "
            "(contact_loss, adhesion, hertz_contact, exponential_stiffening, hunt_crossley, or "
            "cubic_stiffening under preload)"
        )
    return (
        "; mostly odd harmonics, as of stiffening on both sides (cubic_stiffening), friction "
        "(coulomb_friction, stribeck_friction, bouc_wen_hysteresis) or backlash"
    )


def _mains(lines: _Lines, mains: float) -> ResidualTest:
    name, among = f"{mains:g} Hz", lines.near(mains)
    if not among.any() or (lines.drive.repetition and (among & lines.drive.driven).any()):
        return untold(name, "the drive itself moves there, or the sampling is too slow")
    _, amplitude, chance = lines.strongest(among)
    harmonic = (among & lines.harmonic()).any()
    return judge_test(
        name,
        amplitude,
        chance,
        f"a line of {lines.output.tell(amplitude)}",
        "hum of the mains (mains_hum)"
        + (
            f", or a harmonic of the drive, which repeats at {lines.drive.repetition:.4g} Hz: "
            "drive at another frequency to tell"
            if harmonic
            else ""
        ),
    )


def _others(lines: _Lines) -> ResidualTest:
    """Look where neither the drive moves, nor it repeats, nor the mains hum."""
    among = ~(lines.drive.driven | ndimage.binary_dilation(lines.harmonic()))
    for mains in MAINS:
        among &= ~(lines.near(mains) | lines.near(2.0 * mains) | lines.near(3.0 * mains))
    if not among.any():
        return untold("other lines", "the drive leaves no frequency free")
    frequency, amplitude, chance = lines.strongest(among)
    hint = (
        "slow and not of the drive: tissue that moves by itself (tissue_motion: breathing, "
        "heartbeat), or a force that wanders (force_drift)"
        if frequency < SLOW_CYCLES
        else "not of the drive: vibration of the mount (structural_mode), or interference"
    )
    return judge_test(
        "other lines",
        amplitude,
        chance,
        f"strongest: {lines.output.tell(amplitude)} at {frequency:.4g} Hz",
        hint,
    )
