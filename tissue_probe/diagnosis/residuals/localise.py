"""Where a model fails: when, at which frequency, depth, speed, direction and phase of the cycle.

Contents: the residual's energy over each of these quantities, and the region of each that stands
out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tissue_probe.diagnosis.chance import chi_squared_beyond
from tissue_probe.diagnosis.residuals.residual_test import (
    SHORTEST_RESIDUAL,
    SIGNIFICANCE,
    check_signals,
)
from tissue_probe.diagnosis.transforms import analytic, welch, without_line
from tissue_probe.signals import FloatArray

BINS = 36  # of time, depth and speed; of phase, 10 degrees each
BANDS_PER_OCTAVE = 3
LONGEST_SEGMENT = 1.0  # s of a Welch segment at most; an eighth of the record otherwise
WIDEST_REGION = 0.6  # of a quantity's axis: a wider region is everywhere
SHARE_CONTRAST = 0.25  # by which a region's share of the error must exceed its share of the axis


@dataclass(frozen=True)
class ResidualRegion:
    """Where the residual stands out.

    Parameters
    ----------
    begin, end : float
        Ends of the interval, in the unit of its quantity. Of a phase, ``begin`` may lie above
        ``end``: the interval then goes on through +-180 degrees.
    excess : float
        The residual's energy in the region, over that of noise alone.
    share : float
        The region's share of the residual's energy beyond noise, 0 to 1 (more if others lack).
    contrast : float
        ``share`` less the region's share of the axis: 0 if the residual is spread evenly.
    """

    begin: float
    end: float
    excess: float
    share: float
    contrast: float


@dataclass(frozen=True)
class Profile:
    """The residual's energy over one quantity.

    Parameters
    ----------
    quantity, unit : str
        The quantity that the bins divide, and its unit.
    edges : array, shape (B + 1,)
        Ends of the bins.
    energy, expected : array, shape (B,)
        Sum of squares of the residual in each bin, and that of noise alone.
    here : Region or None
        The interval that stands out most; None if the residual is noise, or spread evenly.
    labels : tuple of str
        Names of the bins where they are classes; else empty.
    """

    quantity: str
    unit: str
    edges: FloatArray
    energy: FloatArray
    expected: FloatArray
    here: ResidualRegion | None
    labels: tuple[str, ...] = ()

    @property
    def excess(self) -> FloatArray:
        """Energy over that of noise alone, per bin; NaN in bins without samples."""
        empty = np.full(self.energy.size, np.nan)
        found: FloatArray = np.divide(
            self.energy, self.expected, out=empty, where=self.expected > 0.0
        )
        return found

    def describe(self) -> str:
        """Return the region in words, or that there is none."""
        if self.here is None:
            return f"{self.quantity}: nothing stands out"
        found = self.here
        if self.labels:
            place = self.labels[int(np.searchsorted(self.edges, found.begin, side="right")) - 1]
        else:
            place = f"{found.begin:.3g} to {found.end:.3g} {self.unit}"
        return (
            f"{self.quantity} {place}: {100.0 * min(found.share, 1.0):.0f} % of the error beyond "
            f"noise, rms {np.sqrt(found.excess):.3g} times the noise"
        )


@dataclass(frozen=True)
class Localisation:
    """Where a model fails.

    Parameters
    ----------
    profiles : tuple of Profile
        One for each quantity.
    here : Profile or None
        The one whose region stands out most, None if none does; frequency only if no other does,
        since a moving mass always keeps to low frequencies.
    """

    profiles: tuple[Profile, ...]
    here: Profile | None


def localise(
    residual: FloatArray,
    position: FloatArray,
    tip_position: FloatArray,
    sample_period: float,
    noise: float,
) -> Localisation:
    """Divide the residual's energy over time, frequency, depth, speed, direction and phase.

    Parameters
    ----------
    residual : array, shape (N,)
        Measured minus predicted output; N >= 64.
    position : array, shape (N,)
        Displacement u of the moved part [m], positive into the tissue.
    tip_position : array, shape (N,)
        Displacement x of the tip [m]: the indentation; as the model predicts it, or u - F / k0.
    sample_period : float
        Time between two samples [s].
    noise : float
        Standard deviation of the output's white noise.

    Returns
    -------
    Localisation
        With the profiles ``time`` [s since the first sample], ``frequency`` [Hz],
        ``indentation`` [mm], ``speed`` [mm/s, of the tip, positive inwards], ``direction``
        (out, in) and ``phase`` [degrees of the motion's cycle, 0 where it is deepest, -90 on the
        way in].

    Raises
    ------
    ValueError
        If the signals differ in length, are too short or not finite, or the noise is not positive.

    Notes
    -----
    A region is the contiguous run of bins, at most 60 % of the axis, of largest contrast: share of
    the error beyond noise less share of the axis. The axis counts in samples; of frequency, in
    octaves. The statistic is Kuiper's (N. Kuiper, Proc. Kon. Ned. Akad. Wet. A 63 (1960), 38)
    between the two distributions. Its energy must exceed the noise's with 0.1 % significance
    (chi^2, Bonferroni over all runs).
    """
    residual, position, tip_position = check_signals(noise, residual, position, tip_position)
    time = sample_period * np.arange(residual.size, dtype=float)
    speed = np.gradient(tip_position, sample_period)
    phase = np.rad2deg(np.angle(analytic(without_line(position))))
    squares = residual**2
    profiles = (
        _profile_over("time", "s", time, squares, noise),
        _over_frequency(residual, sample_period, noise),
        _profile_over("indentation", "mm", 1e3 * tip_position, squares, noise),
        _profile_over("speed", "mm/s", 1e3 * speed, squares, noise),
        _over_direction(speed, squares, noise),
        _profile_over("phase", "degrees", phase, squares, noise, (-180.0, 180.0)),
    )
    return Localisation(profiles, _foremost(profiles))


def _foremost(profiles: tuple[Profile, ...]) -> Profile | None:
    """Return the profile of largest contrast; frequency only if no other has a region."""
    found = [
        (profile.quantity != "frequency", profile.here.contrast, profile)
        for profile in profiles
        if profile.here
    ]
    return max(found, key=lambda one: one[:2])[2] if found else None


def _profile_over(
    quantity: str,
    unit: str,
    values: FloatArray,
    squares: FloatArray,
    noise: float,
    limits: tuple[float, float] | None = None,
) -> Profile:
    edges = np.histogram_bin_edges(values, BINS, limits)
    count, _ = np.histogram(values, edges)
    energy, _ = np.histogram(values, edges, weights=squares)
    here = _region(edges, energy, count * noise**2, count, noise, circular=limits is not None)
    return Profile(quantity, unit, edges, energy, count * noise**2, here)


def _over_direction(speed: FloatArray, squares: FloatArray, noise: float) -> Profile:
    inward = speed > 0.0
    count = np.array([np.sum(~inward), np.sum(inward)])
    energy = np.array([squares[~inward].sum(), squares[inward].sum()])
    edges = np.array([-1.0, 0.0, 1.0])
    here = _region(edges, energy, count * noise**2, count, noise)
    return Profile("direction", "", edges, energy, count * noise**2, here, ("out", "in"))


def _over_frequency(residual: FloatArray, sample_period: float, noise: float) -> Profile:
    """Divide the energy by Welch's method into bands of a third of an octave."""
    segment = max(
        round(LONGEST_SEGMENT / sample_period), SHORTEST_RESIDUAL
    )  # of slow samples, as many as 64
    segment = min(segment, residual.size // 8)
    frequencies, density = welch(residual, sample_period, segment)
    frequencies, density = frequencies[1:], density[1:]
    energy_of_bin = residual.size * density * frequencies[0]
    octaves = np.log2(frequencies[-1] / frequencies[0])
    edges = frequencies[0] * 2.0 ** np.linspace(0, octaves, round(octaves * BANDS_PER_OCTAVE) + 1)
    edges = np.r_[edges[:-1], np.nextafter(frequencies[-1], np.inf)]
    # Of the lowest bands, some lie between two bins: join them with the next.
    edges = edges[np.r_[True, np.diff(np.searchsorted(frequencies, edges)) > 0]]
    count, _ = np.histogram(frequencies, edges)
    energy, _ = np.histogram(frequencies, edges, weights=energy_of_bin)
    expected = residual.size * noise**2 * count / frequencies.size
    here = _region(edges, energy, expected, np.diff(np.log2(edges)), noise)
    return Profile("frequency", "Hz", edges, energy, expected, here)


def _region(
    edges: FloatArray,
    energy: FloatArray,
    expected: FloatArray,
    width: FloatArray | NDArray[np.int_],
    noise: float,
    circular: bool = False,
) -> ResidualRegion | None:
    """Return the run of bins of largest contrast, or None; see `localise`."""
    bins = energy.size
    beyond = energy.sum() - expected.sum()
    freedom = expected.sum() / noise**2
    if chi_squared_beyond(energy.sum() / noise**2, freedom) > SIGNIFICANCE:
        return None
    share, axis = (energy - expected) / beyond, width / width.sum()
    best = None
    for first in range(bins):
        for length in range(1, bins + 1 if circular else bins - first + 1):
            run = np.arange(first, first + length) % bins
            if axis[run].sum() > WIDEST_REGION:
                break
            contrast = share[run].sum() - axis[run].sum()
            if best is None or contrast > best[0]:
                best = (contrast, run)
    if best is None or best[0] < SHARE_CONTRAST:
        return None
    contrast, run = best
    samples = expected[run].sum() / noise**2
    chance = bins**2 * chi_squared_beyond(energy[run].sum() / noise**2, samples)
    if chance > SIGNIFICANCE:
        return None
    return ResidualRegion(
        float(edges[run[0]]),
        float(edges[run[-1] + 1]),
        float(energy[run].sum() / expected[run].sum()),
        float(share[run].sum()),
        float(contrast),
    )
