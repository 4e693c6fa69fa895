"""Whether a model leaves noise only, as one number: below 1 it does.

Contents: the tests of a residual, each over its limit.
"""

from __future__ import annotations

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit

#: Residual over noise is known to the first over the root of the number of samples, which fewer
#: than one recording in a hundred exceeds: so well is the noise told from the samples. However many
#: they are, the second share is left aside: no model is right to the last digit.
SIZE, SIZE_NEARLY = 2.8, 0.05
#: The same of slow over fast parts of the residual: slow are an eighth of the cosines, so that the
#: share varies by the root of eight more.
COLOUR, COLOUR_NEARLY = 7.1, 0.12
#: How far an octave of the residual may stand out, in units of noise's usual departure.
EVEN = 8.0
#: Sum of squared departures, in standard deviations, from the rig's tolerances and starts.
STRAINED = 25.0
#: Square of the residual over noise below which the noise is another than it was taken for: more
#: than half of it is not there.
NOT_THERE = 0.5
#: Residual over noise where an encoder's rounding is as large as the noise: its size is known
#: roughly. Where it is less, but at least the second share, it may still have any colour.
ROUGHLY, ROUNDING = 1.2, 0.15

#: A further effect must remove this share of the error beyond the noise, or leave noise only: of
#: models that are all wrong the most probable one has too many effects.
SHARE = 0.65
#: Adequacy below which a residual is noise beyond doubt.
BEYOND_DOUBT = 0.6


def adequacy(fit: Fit) -> float:
    """Return the largest test of a residual over its limit: below 1 a fit leaves noise only.

    That is: no more than there is, of no colour, even over the frequencies, and with a likely rig.
    An encoder's rounding, of which more than its size is not known, may have any colour; so may
    that of the output where it rests.
    """
    share = max(fit.rounding, *(each.stays_rounded for each in fit.measurements)) / fit.noise
    if share > ROUNDING:
        most = _most(SIZE, SIZE_NEARLY, fit)
        most += max(ROUGHLY - 1.0 - most, 0.0) * min(share**2, 1.0)
        return (fit.ratio - 1.0) / most
    return max(
        excess_of(fit),
        NOT_THERE / max(fit.ratio**2, np.finfo(float).tiny),
        measure_colour(fit),
        fit.unevenness / EVEN,
        fit.strain / STRAINED,
    )


def excess_of(fit: Fit) -> float:
    """Return by how much more than noise a fit leaves, over the granted excess."""
    return (fit.ratio - 1.0) / _most(SIZE, SIZE_NEARLY, fit)


def measure_colour(fit: Fit) -> float:
    """Return by how much slower than white noise the residual is, over the granted excess."""
    return (fit.colour - 1.0) / _most(COLOUR, COLOUR_NEARLY, fit)


def _most(unknown: float, nearly: float, fit: Fit) -> float:
    return float(np.hypot(unknown / np.sqrt(fit.samples), nearly))


def leaves_only_noise(fit: Fit) -> bool:
    """Whether a fit leaves noise only."""
    return adequacy(fit) < 1.0


def removes(fit: Fit, better: Fit) -> bool:
    """Whether a further effect removes most of the error beyond the noise, or leaves noise only."""
    excess, left = fit.ratio**2 - 1.0, better.ratio**2 - 1.0
    return left < (1.0 - SHARE) * excess or (
        leaves_only_noise(better) and not leaves_only_noise(fit)
    )


def is_quiet(fit: Fit) -> bool:
    """Whether more than half of the noise that a fit counts is not there."""
    return fit.ratio**2 <= NOT_THERE


def beyond_doubt(fit: Fit) -> bool:
    """Whether a fit leaves noise only, far from the limits of noise."""
    return adequacy(fit) < BEYOND_DOUBT


def doubtful(fit: Fit) -> bool:
    """Whether an encoder's rounding, known roughly, may explain the residual of a fit.

    The residual is too large beyond doubt, or it has a colour that fine steps do not give.
    """
    coloured = not is_coarse(fit) and measure_colour(fit) > 1.0
    return leaves_more(fit) or (fit.rounding > ROUNDING * fit.noise and coloured)


def leaves_more(fit: Fit) -> bool:
    """Whether a fit leaves more than it should beyond doubt, which rounding may explain."""
    return fit.rounding > ROUNDING * fit.noise and excess_of(fit) > BEYOND_DOUBT


def is_coarse(fit: Fit) -> bool:
    """Whether a model reads an encoder in coarse steps."""
    return any(effect.rounded != 0 for effect in fit.composition.effects)
